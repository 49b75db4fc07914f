#include "post/vtk_export.hpp"

#include <array>
#include <bit>
#include <cstring>
#include <filesystem>

#include "base/error.hpp"
#include "base/log.hpp"
#include "io/format.hpp"
#include "io/pending_file.hpp"
#include "post/fiber_lines.hpp"

namespace fbi::post {
namespace {

static_assert(std::endian::native == std::endian::little, "byte_order below says LittleEndian");

// A VTK XML file under construction: the head grows by elements, the arrays are appended behind it.
class VtkFile {
 public:
  VtkFile(const std::string& type, bool single, double time) : type_(type), single_(single) {
    head_ = "<?xml version=\"1.0\"?>\n<VTKFile type=\"" + type +
            "\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n  <" + type + ">\n" +
            log::format(
                "    <FieldData>\n      <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" "
                "format=\"ascii\">%.17g</DataArray>\n    </FieldData>\n",
                time);
  }

  void open(const std::string& element) { head_ += "    <" + element + ">\n"; }
  void close(const std::string& element) { head_ += "    </" + element + ">\n"; }

  void numbers(const std::string& name, const std::vector<double>& values, int components = 1) {
    if (!single_) return array("Float64", name, values, components);
    array("Float32", name, std::vector<float>(values.begin(), values.end()), components);
  }
  void integers(const std::string& name, const std::vector<std::int64_t>& values) { array("Int64", name, values, 1); }
  void types(const std::string& name, const std::vector<std::uint8_t>& values) { array("UInt8", name, values, 1); }
  // Six rows of a symmetric tensor, from xx, xy, xz, yy, yz, zz to VTK's order.
  void tensor(const std::string& name, const std::vector<double>& ours) {
    constexpr int place[6] = {0, 3, 5, 1, 4, 2};
    std::vector<double> theirs(ours.size());
    for (std::size_t k = 0; k < ours.size(); ++k) theirs[k] = ours[k / 6 * 6 + place[k % 6]];
    numbers(name, theirs, 6);
  }
  void field(const std::string& name, const std::vector<double>& values, int components) {
    if (components == 6) return tensor(name, values);
    numbers(name, values, components);
  }

  void write(const std::string& path) {
    std::string text = head_ + "  </" + type_ + ">\n  <AppendedData encoding=\"raw\">\n_";
    head_.clear();
    text += data_;
    data_ = std::string();
    text += "\n  </AppendedData>\n</VTKFile>\n";
    io::write_text_file(path, text);
  }

 private:
  template <class T>
  void array(const char* type, const std::string& name, const std::vector<T>& values, int components) {
    head_ += log::format("      <DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" ", type, name.c_str(),
                         components);
    constexpr const char* axes[] = {"X", "Y", "Z"};
    constexpr const char* pairs[] = {"XX", "YY", "ZZ", "XY", "YZ", "XZ"};
    for (int c = 0; c < components && components > 1; ++c)
      head_ += log::format("ComponentName%d=\"%s\" ", c, components == 3 ? axes[c] : pairs[c]);
    head_ += log::format("format=\"appended\" offset=\"%zu\"/>\n", data_.size());
    const std::uint64_t bytes = values.size() * sizeof(T);
    data_.append(reinterpret_cast<const char*>(&bytes), sizeof bytes);
    data_.append(reinterpret_cast<const char*>(values.data()), bytes);
  }

  std::string type_, head_, data_;
  bool single_;
};

std::vector<std::int64_t> counted(std::size_t count, std::int64_t step) {
  std::vector<std::int64_t> numbers(count);
  for (std::size_t k = 0; k < count; ++k) numbers[k] = step * static_cast<std::int64_t>(k + 1);
  return numbers;
}

void write_fluid(const std::string& path, const io::File& mesh, const io::File& fields, const VtkOptions& options,
                 double time) {
  const std::size_t cells = static_cast<std::size_t>(mesh.shape("/fluid/cells")[0]);
  VtkFile file("UnstructuredGrid", options.single, time);
  file.open(log::format("Piece NumberOfPoints=\"%lld\" NumberOfCells=\"%zu\"",
                        static_cast<long long>(mesh.shape("/fluid/nodes")[0]), cells));
  file.open("PointData");
  for (const std::string& name : fields.children("/fluid"))
    file.field(name, fields.read<double>("/fluid/" + name), static_cast<int>(fields.shape("/fluid/" + name)[1]));
  file.close("PointData");
  file.open("Points");
  file.numbers("Points", mesh.read<double>("/fluid/nodes"), 3);
  file.close("Points");
  file.open("Cells");
  file.integers("connectivity", mesh.read<std::int64_t>("/fluid/cells"));
  file.integers("offsets", counted(cells, 8));
  file.types("types", std::vector<std::uint8_t>(cells, 12));  // hexahedron
  file.close("Cells");
  file.close("Piece");
  file.write(path);
}

void write_fibers(const std::string& path, const FiberLines& lines, const io::File& fields, const VtkOptions& options,
                  double time) {
  VtkFile file("PolyData", options.single, time);
  file.open(
      log::format("Piece NumberOfPoints=\"%zu\" NumberOfVerts=\"0\" NumberOfLines=\"%zu\" NumberOfStrips=\"0\" "
                  "NumberOfPolys=\"0\"",
                  lines.points(), lines.fibers()));
  file.open("PointData");
  std::vector<double> displacement(lines.position.size());
  for (std::size_t k = 0; k < displacement.size(); ++k) displacement[k] = lines.position[k] - lines.reference[k];
  file.numbers("displacement", displacement, 3);
  for (const std::string& name : fields.children("/fibers"))
    if (name != "dofs" && name != "position")
      file.field(name, fields.read<double>("/fibers/" + name), static_cast<int>(fields.shape("/fibers/" + name)[1]));
  file.close("PointData");
  file.open("CellData");
  std::vector<std::int64_t> numbers = counted(lines.fibers(), 1);
  for (std::int64_t& number : numbers) --number;
  file.integers("fiber", numbers);
  file.integers("group", lines.group);
  file.numbers("radius", lines.radius);
  file.close("CellData");
  file.open("Points");
  file.numbers("Points", lines.position, 3);
  file.close("Points");
  file.open("Lines");
  std::vector<std::int64_t> points = counted(lines.points(), 1);
  for (std::int64_t& point : points) --point;
  file.integers("connectivity", points);
  file.integers("offsets", {lines.first.begin() + 1, lines.first.end()});
  file.close("Lines");
  file.close("Piece");
  file.write(path);
}

}  // namespace

std::vector<std::string> write_vtk(const std::string& base, const Run& run, const VtkOptions& options) {
  std::vector<io::StepTime> outputs = run.outputs;
  if (options.at.step || options.at.time || outputs.empty()) outputs = {choose_output(run, options.at)};
  const io::File mesh = io::open_kind(run.paths.mesh(), io::FileKind::mesh);
  const std::filesystem::path folder(base + ".vtk");
  io::make_directory(folder.string());
  std::vector<std::string> files = {base + ".pvd"};
  std::string series =
      "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n"
      "  <Collection>\n";
  for (const io::StepTime& output : outputs) {
    const io::File fields = io::open_kind(run.paths.step(output.step), io::FileKind::step);
    const auto add = [&](const char* ending, int part) {
      const std::string name = log::format("%06lld.%s", static_cast<long long>(output.step), ending);
      series += log::format("    <DataSet timestep=\"%.17g\" group=\"\" part=\"%d\" file=\"", output.time, part) +
                folder.filename().string() + "/" + name + "\"/>\n";
      files.push_back((folder / name).string());
      return files.back();
    };
    if (mesh.has("/fluid/nodes")) write_fluid(add("fluid.vtu", 0), mesh, fields, options, output.time);
    const FiberLines lines = read_fiber_lines(run, output);
    if (lines.fibers() > 0) write_fibers(add("fibers.vtp", 1), lines, fields, options, output.time);
  }
  io::write_text_file(files[0], series + "  </Collection>\n</VTKFile>\n");
  return files;
}

}  // namespace fbi::post
