#include "io/checkpoint.hpp"

#include <filesystem>
#include <optional>

#include "base/error.hpp"
#include "base/log.hpp"
#include "io/file_order.hpp"
#include "io/format.hpp"

namespace fbi::io {
namespace {

/// Order of the rows of the arrays of a mesh; that with images is made for the first array that has them.
class Orders {
 public:
  explicit Orders(const mesh::FiberMesh& fibers) : owned_(fiber_node_order(fibers)) {}
  explicit Orders(const mesh::HexMesh& fluid) : fluid_(&fluid), owned_(node_order(fluid)) {}
  const FileOrder& of(const StateArray& array) {
    if (!array.images || fluid_ == nullptr) return owned_;
    if (!with_images_) with_images_ = output_order(*fluid_);
    return *with_images_;
  }

 private:
  const mesh::HexMesh* fluid_ = nullptr;
  FileOrder owned_;
  std::optional<FileOrder> with_images_;
};

void write_arrays(File& file, const std::string& group, Orders orders, const std::vector<StateArray>& arrays) {
  for (const StateArray& array : arrays) {
    const FileOrder& order = orders.of(array);
    file.write_rows(group + array.name, order.to_file(*array.values, array.components), array.components, order.begin(),
                    order.total());
  }
}

void read_arrays(const File& file, const std::string& group, Orders orders, const std::vector<StateArray>& arrays) {
  for (const StateArray& array : arrays) {
    const FileOrder& order = orders.of(array);
    const std::array<GlobalIndex, 2> shape = file.shape(group + array.name);
    if (shape != std::array<GlobalIndex, 2>{order.total(), array.components})
      throw Error(
          ExitCode::file,
          log::format(
              "%s of \"%s\" has %lld x %lld numbers, but this case needs %lld x %d; run the case from the start",
              (group + array.name).c_str(), file.path().c_str(), static_cast<long long>(shape[0]),
              static_cast<long long>(shape[1]), static_cast<long long>(order.total()), array.components));
    *array.values =
        order.from_file(file.read_rows<double>(group + array.name, order.begin(), order.count()), array.components);
  }
}

GlobalIndex bytes_of(const std::vector<StateArray>& arrays, GlobalIndex rows) {
  GlobalIndex bytes = 0;
  for (const StateArray& array : arrays) bytes += 8 * array.components * rows;
  return bytes;
}

}  // namespace

void write_checkpoint(const Comm& comm, const RunPaths& paths, const CheckpointHeader& header,
                      const mesh::HexMesh* fluid_mesh, const std::vector<StateArray>& fluid,
                      const mesh::FiberMesh* fiber_mesh, const std::vector<StateArray>& fibers) {
  GlobalIndex bytes = 65536;
  if (fluid_mesh) bytes += bytes_of(fluid, fluid_mesh->global_nodes);
  if (fiber_mesh) bytes += bytes_of(fibers, fiber_mesh->global_nodes);
  for (const auto& [name, vector] : header.vectors) bytes += static_cast<GlobalIndex>(8 * vector.size() + 512);
  {
    File file = File::create(comm, paths.checkpoint(header.step), bytes);
    write_format(file, FileKind::checkpoint);
    file.write_attribute("/", "step", header.step);
    file.write_attribute("/", "time", header.time);
    file.write_attribute("/", "case_fingerprint", header.case_fingerprint);
    file.make_group("/numbers");
    for (const auto& [name, number] : header.numbers)
      file.write_rows("/numbers/" + name, comm.rank() == 0 ? std::vector{number} : std::vector<double>{}, 1, 0, 1);
    file.make_group("/vectors");
    for (const auto& [name, vector] : header.vectors)
      file.write_rows("/vectors/" + name, comm.rank() == 0 ? vector : std::vector<double>{}, 1, 0,
                      static_cast<GlobalIndex>(vector.size()));
    if (fluid_mesh) write_arrays(file, "/fluid/", Orders(*fluid_mesh), fluid);
    if (fiber_mesh) write_arrays(file, "/fibers/", Orders(*fiber_mesh), fibers);
    file.commit();
  }
  if (comm.rank() != 0) return;
  const std::vector<GlobalIndex> steps = paths.checkpoints();
  GlobalIndex before = -1;
  for (const GlobalIndex step : steps)
    if (step < header.step) before = step;
  for (const GlobalIndex step : steps) {
    std::error_code ignored;  // a checkpoint too many does no harm
    if (step != header.step && step != before) std::filesystem::remove(paths.checkpoint(step), ignored);
  }
}

GlobalIndex find_checkpoint(const Comm& comm, const RunPaths& paths, const std::string& which) {
  const bool last = which == "last";
  if (!last && (which.empty() || which.size() > 15 || which.find_first_not_of("0123456789") != std::string::npos))
    throw Error(ExitCode::usage, "--restart takes \"last\" or a step number, not \"" + which + "\"");
  GlobalIndex found = -1;
  std::string text;
  if (comm.rank() == 0) {
    const std::vector<GlobalIndex> steps = paths.checkpoints();
    std::string existing;
    for (const GlobalIndex step : steps) {
      existing += (existing.empty() ? "" : ", ") + std::to_string(step);
      if (last || step == std::stoll(which)) found = step;
    }
    if (steps.empty())
      text = "there is no checkpoint in \"" + paths.directory + "\"; run the case from the start (without --restart)";
    else if (found < 0)
      text = "there is no checkpoint of step " + which + " in \"" + paths.directory + "\"; there are: " + existing;
  }
  agree_on_error(comm, ExitCode::file, text);
  MPI_Bcast(&found, 1, MPI_INT64_T, 0, comm.get());
  return found;
}

CheckpointHeader read_checkpoint(const Comm& comm, const RunPaths& paths, GlobalIndex step,
                                 const std::string& case_fingerprint, const mesh::HexMesh* fluid_mesh,
                                 const std::vector<StateArray>& fluid, const mesh::FiberMesh* fiber_mesh,
                                 const std::vector<StateArray>& fibers) {
  const File file = open_kind(comm, paths.checkpoint(step), FileKind::checkpoint);
  CheckpointHeader header;
  header.step = file.integer_attribute("/", "step");
  header.time = file.number_attribute("/", "time");
  header.case_fingerprint = file.text_attribute("/", "case_fingerprint");
  if (header.case_fingerprint != case_fingerprint)
    throw Error(ExitCode::file,
                "checkpoint \"" + file.path() +
                    "\" belongs to another case: the input has changed since; run the case from the start "
                    "(without --restart) or restore the input the checkpoint was made with");
  for (const std::string& name : file.children("/numbers"))
    header.numbers[name] = file.read_rows<double>("/numbers/" + name, 0, 1).at(0);
  for (const std::string& name : file.children("/vectors"))
    header.vectors[name] = file.read<double>("/vectors/" + name);
  if (fluid_mesh) read_arrays(file, "/fluid/", Orders(*fluid_mesh), fluid);
  if (fiber_mesh) read_arrays(file, "/fibers/", Orders(*fiber_mesh), fibers);
  return header;
}

}  // namespace fbi::io
