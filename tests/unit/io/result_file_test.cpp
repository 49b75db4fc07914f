/// Field output: the same file whatever the ranks, an index and an XDMF file that name what exists.
#include "io/result_file.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "example_case.hpp"
#include "io/checkpoint.hpp"
#include "io/format.hpp"
#include "io/history.hpp"
#include "io/pending_file.hpp"
#include "scratch.hpp"

namespace fbi::io {
namespace {

using test::error_of;
using test::expect_contains;
using test::Scratch;

// Fields of one step on this rank's nodes, functions of position and time only.
struct Fields {
  Fields(const mesh::HexMesh& fluid, const mesh::FiberMesh& fibers, double time) {
    for (Index n = 0; n < fluid.owned_nodes; ++n) {
      const double* x = fluid.node(n);
      state.insert(state.end(), {x[0] + time, 2.0 * x[1], -x[2], 10.0 * x[0] + x[1] * x[2] + time});
    }
    dofs = fibers.reference_dofs();
    for (std::size_t n = 0; n < dofs.size() / 6; ++n) {
      dofs[6 * n] += time * dofs[6 * n + 1] * dofs[6 * n + 1];  // x bends with y squared: exact in cubic Hermite
      dofs[6 * n + 3] = 2.0 * time * dofs[6 * n + 1];
      velocity.insert(velocity.end(), {dofs[6 * n + 1], 0.0, 0.0, 1.0, 0.0, 0.0});
      force.insert(force.end(), {0.0, 3.0 * dofs[6 * n + 1], 1.0});
    }
  }
  std::vector<NodeField> fluid_fields() const {
    return {{"velocity", 3, 4, 0, state.data()}, {"pressure", 1, 4, 3, state.data()}};
  }
  FiberState fiber_state() const { return {&dofs, &velocity, &force}; }
  std::vector<double> state, dofs, velocity, force;
};

struct Scene {
  explicit Scene(const Comm& comm)
      : content(test::example_case()),
        fluid(test::distribute_mesh(comm, content)),
        fibers(test::distribute_fibers(comm, content, &fluid)) {}
  CaseFile content;
  mesh::HexMesh fluid;
  mesh::FiberMesh fibers;
  Provenance provenance(const Comm& comm) const {
    return {content.json, content.json_name, "fbi-run 0.1.0", "fbi-run example.h5", comm.size()};
  }
};

void write_steps(const Comm& comm, const Scene& scene, ResultWriter& writer, const std::vector<GlobalIndex>& steps) {
  for (const GlobalIndex step : steps) {
    const Fields fields(scene.fluid, scene.fibers, 0.1 * static_cast<double>(step));
    writer.write_step(step, 0.1 * static_cast<double>(step), fields.fluid_fields(), fields.fiber_state());
  }
  MPI_Barrier(comm.get());
}

// Tags of an XML text that are well formed: every element closed in order. Returns the number of elements, -1 when not.
int well_formed_elements(const std::string& text) {
  std::vector<std::string> open;
  int elements = 0;
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at)) {
    const std::size_t end = text.find('>', at);
    if (end == std::string::npos) return -1;
    const std::string tag = text.substr(at + 1, end - at - 1);
    at = end;
    if (tag.empty() || tag.find('<') != std::string::npos) return -1;
    if (tag[0] == '?') continue;
    const std::string name = tag.substr(tag[0] == '/' ? 1 : 0, tag.find_first_of(" /", 1) - (tag[0] == '/' ? 1 : 0));
    if (tag[0] == '/') {
      if (open.empty() || open.back() != tag.substr(1)) return -1;
      open.pop_back();
      continue;
    }
    if (std::count(tag.begin(), tag.end(), '"') % 2) return -1;
    ++elements;
    if (tag.back() != '/') open.push_back(name);
  }
  return open.empty() ? elements : -1;
}

// Every "file:/dataset" of the XDMF text with its Dimensions is in the files.
int check_items(const std::string& text, const std::string& directory) {
  int items = 0;
  for (std::size_t at = text.find("<DataItem"); at != std::string::npos; at = text.find("<DataItem", at + 1)) {
    const std::size_t begin = text.find('>', at) + 1;
    const std::string place = text.substr(begin, text.find('<', begin) - begin);
    const std::size_t colon = place.find(':');
    const std::size_t dimensions = text.find("Dimensions=\"", at) + 12;
    const std::string extent = text.substr(dimensions, text.find('"', dimensions) - dimensions);
    const File file = File::open(directory + "/" + place.substr(0, colon), "");
    const std::array<GlobalIndex, 2> shape = file.shape(place.substr(colon + 1));
    EXPECT_EQ(extent, std::to_string(shape[0]) + (shape[1] > 1 ? " " + std::to_string(shape[1]) : "")) << place;
    ++items;
  }
  return items;
}

TEST(Result, StepsHoldTheFieldsInFileOrder) {
  const Comm comm;
  const Scratch scratch(comm);
  const Scene scene(comm);
  const RunPaths paths = run_paths(scratch / "example.run.h5");
  ResultWriter writer(comm, paths, &scene.fluid, &scene.fibers, scene.provenance(comm), 4);
  write_steps(comm, scene, writer, {0, 5});
  if (comm.rank() != 0) return;
  const File mesh = open_kind(paths.mesh(), FileKind::mesh);
  EXPECT_EQ(mesh.read<double>("/fluid/nodes"), scene.content.mesh.nodes);
  EXPECT_EQ(mesh.read<GlobalIndex>("/fluid/cells"), scene.content.mesh.cells);
  EXPECT_EQ(mesh.read<double>("/fluid/box/y"), scene.content.mesh.box->coordinates[1]);
  EXPECT_EQ(mesh.read_strings("/fibers/names", 0, 7), scene.content.fibers.name);
  EXPECT_EQ(mesh.read<GlobalIndex>("/fibers/first_point"), (std::vector<GlobalIndex>{0, 13, 26, 39, 52, 65, 78}));
  const std::vector<double> reference = mesh.read<double>("/fibers/reference_dofs");
  ASSERT_EQ(reference.size(), 6u * 28u);
  for (std::size_t n = 0; n < 28; ++n)
    for (int d = 0; d < 3; ++d) {
      EXPECT_EQ(reference[6 * n + d], scene.content.fibers.position[3 * n + d]);
      EXPECT_EQ(reference[6 * n + 3 + d], scene.content.fibers.tangent[3 * n + d]);
    }
  const std::vector<GlobalIndex> polylines = mesh.read<GlobalIndex>("/fibers/polylines");
  ASSERT_EQ(polylines.size(), 7u * 15u);
  for (GlobalIndex f = 0; f < 7; ++f) {
    EXPECT_EQ(polylines[15 * f], 2);
    EXPECT_EQ(polylines[15 * f + 1], 13);
    for (GlobalIndex k = 0; k < 13; ++k) EXPECT_EQ(polylines[15 * f + 2 + k], 13 * f + k);
  }

  const File step = open_kind(paths.step(5), FileKind::step);
  EXPECT_EQ(step.number_attribute("/", "time"), 0.5);
  EXPECT_EQ(step.integer_attribute("/", "step"), 5);
  const std::vector<double> velocity = step.read<double>("/fluid/velocity"),
                            pressure = step.read<double>("/fluid/pressure");
  const std::vector<double>& x = scene.content.mesh.nodes;
  ASSERT_EQ(velocity.size(), x.size());
  ASSERT_EQ(pressure.size(), x.size() / 3);
  for (std::size_t n = 0; n < pressure.size(); ++n) {
    EXPECT_EQ(velocity[3 * n], x[3 * n] + 0.5);
    EXPECT_EQ(velocity[3 * n + 1], 2.0 * x[3 * n + 1]);
    EXPECT_EQ(velocity[3 * n + 2], -x[3 * n + 2]);
    EXPECT_EQ(pressure[n], 10.0 * x[3 * n] + x[3 * n + 1] * x[3 * n + 2] + 0.5);
  }
  const std::vector<double> position = step.read<double>("/fibers/position"),
                            rate = step.read<double>("/fibers/velocity"), force = step.read<double>("/fibers/force");
  ASSERT_EQ(position.size(), 3u * 7u * 13u);
  for (std::size_t p = 0; p < 7 * 13; ++p) {
    const double y = 0.3 * static_cast<double>(p % 13) / 12.0, x0 = 0.1 + 2.8 * static_cast<double>(p / 13) / 7.0;
    EXPECT_NEAR(position[3 * p], x0 + 0.5 * y * y, 1e-15);
    EXPECT_NEAR(position[3 * p + 1], y, 1e-15);
    EXPECT_NEAR(rate[3 * p], y, 1e-15);
    EXPECT_NEAR(force[3 * p + 1], 3.0 * y, 1e-15);
    EXPECT_NEAR(force[3 * p + 2], 1.0, 1e-15);
  }
}

TEST(Result, IndexAndXdmfNameWhatExists) {
  const Comm comm;
  const Scratch scratch(comm);
  const Scene scene(comm);
  const RunPaths paths = run_paths(scratch / "example.run.h5");
  ResultWriter writer(comm, paths, &scene.fluid, &scene.fibers, scene.provenance(comm), 8);
  const auto complete = [&] {
    return open_kind(paths.index, FileKind::result).integer_attribute("/provenance", "complete");
  };
  for (const GlobalIndex step : {0, 10, 20}) {
    write_steps(comm, scene, writer, {step});
    if (comm.rank() == 0) {
      const std::string text = read_text_file(paths.xdmf);
      EXPECT_GT(well_formed_elements(text), 0);
      EXPECT_EQ(check_items(text, scratch.path()), 8 * static_cast<int>(step / 10 + 1));
      EXPECT_EQ(complete(), 0);
    }
    MPI_Barrier(comm.get());
  }
  {
    History history(comm, paths.csv, "title", standard_history_columns());
    for (int step = 1; step <= 3; ++step) history.write(std::vector<double>(standard_history_columns().size(), step));
  }
  writer.finish();
  if (comm.rank() != 0) return;
  EXPECT_EQ(complete(), 1);
  const File index = open_kind(paths.index, FileKind::result);
  EXPECT_EQ(index.read_text("/input"), scene.content.json);
  EXPECT_EQ(index.text_attribute("/provenance", "command"), "fbi-run example.h5");
  EXPECT_EQ(index.integer_attribute("/provenance", "ranks"), comm.size());
  EXPECT_EQ(index.read<GlobalIndex>("/steps/number"), (std::vector<GlobalIndex>{0, 10, 20}));
  EXPECT_EQ(index.read<double>("/steps/time"), (std::vector<double>{0.0, 1.0, 2.0}));
  EXPECT_EQ(index.shape("/outputs/000010/fluid/velocity"), (std::array<GlobalIndex, 2>{105, 3}));  // through the link
  EXPECT_EQ(index.shape("/mesh/fluid/cells"), (std::array<GlobalIndex, 2>{48, 8}));
  EXPECT_EQ(index.shape("/history/rows"), (std::array<GlobalIndex, 2>{3, 11}));
  EXPECT_EQ(index.read_strings("/history/columns", 0, 2), (std::vector<std::string>{"step", "time"}));
  for (const auto& entry : std::filesystem::recursive_directory_iterator(scratch.path()))
    EXPECT_EQ(entry.path().filename().string().find(".tmp."), std::string::npos);
}

TEST(Result, ARestartKeepsEarlierOutputsAndANewRunNone) {
  const Comm comm;
  const Scratch scratch(comm);
  const Scene scene(comm);
  const RunPaths paths = run_paths(scratch / "example.run.h5");
  {
    ResultWriter writer(comm, paths, &scene.fluid, &scene.fibers, scene.provenance(comm), 8);
    write_steps(comm, scene, writer, {0, 10, 20, 30});
    write_checkpoint(comm, paths, {}, nullptr, {}, nullptr, {});
  }
  MPI_Barrier(comm.get());
  if (comm.rank() == 0) write_text_file(paths.directory + "/000040.h5.tmp.12345", "left by a kill");
  {
    ResultWriter writer(comm, paths, &scene.fluid, &scene.fibers, scene.provenance(comm), 8, 20);
    MPI_Barrier(comm.get());
    EXPECT_EQ(paths.steps(), (std::vector<GlobalIndex>{0, 10, 20}));
    EXPECT_EQ(paths.checkpoints().size(), 1u);
    MPI_Barrier(comm.get());
    write_steps(comm, scene, writer, {25});
  }
  if (comm.rank() == 0) {
    const File index = open_kind(paths.index, FileKind::result);
    EXPECT_EQ(index.read<GlobalIndex>("/steps/number"), (std::vector<GlobalIndex>{0, 10, 20, 25}));
    EXPECT_EQ(index.read<double>("/steps/time"), (std::vector<double>{0.0, 1.0, 2.0, 2.5}));
    EXPECT_EQ(check_items(read_text_file(paths.xdmf), scratch.path()), 32);
    EXPECT_FALSE(std::filesystem::exists(paths.directory + "/000040.h5.tmp.12345"));
  }
  MPI_Barrier(comm.get());
  const ResultWriter fresh(comm, paths, &scene.fluid, &scene.fibers, scene.provenance(comm), 8);
  MPI_Barrier(comm.get());
  EXPECT_TRUE(paths.steps().empty());
  EXPECT_TRUE(paths.checkpoints().empty());
}

TEST(Result, FluidAloneAndFibersAlone) {
  const Comm comm;
  const Scratch scratch(comm);
  const Scene scene(comm);
  const Fields fields(scene.fluid, scene.fibers, 1.0);
  const RunPaths fluid = run_paths(scratch / "fluid.run.h5"), fibers = run_paths(scratch / "fibers.run.h5");
  ResultWriter(comm, fluid, &scene.fluid, nullptr, scene.provenance(comm), 8)
      .write_step(1, 1.0, fields.fluid_fields(), {});
  ResultWriter(comm, fibers, nullptr, &scene.fibers, scene.provenance(comm), 8)
      .write_step(1, 1.0, {}, {&fields.dofs, nullptr, nullptr});
  if (comm.rank() != 0) return;
  EXPECT_EQ(check_items(read_text_file(fluid.xdmf), scratch.path()), 4);
  EXPECT_EQ(check_items(read_text_file(fibers.xdmf), scratch.path()), 2);
  EXPECT_GT(well_formed_elements(read_text_file(fibers.xdmf)), 0);
}

TEST(Result, AFullDiskLeavesEarlierOutputsReadable) {
  const Comm comm;
  const Scratch scratch(comm);
  const Scene scene(comm);
  const RunPaths paths = run_paths(scratch / "example.run.h5");
  ResultWriter writer(comm, paths, &scene.fluid, &scene.fibers, scene.provenance(comm), 8);
  write_steps(comm, scene, writer, {1});
  MPI_Barrier(comm.get());
  {
    const test::FileSizeLimit limit(8192);
    expect_contains(error_of([&] { write_steps(comm, scene, writer, {2}); }), "cannot write");
    expect_contains(
        error_of([&] { ResultWriter(comm, paths, &scene.fluid, &scene.fibers, scene.provenance(comm), 8); }),
        "cannot write");
  }
  MPI_Barrier(comm.get());
  if (comm.rank() != 0) return;
  EXPECT_EQ(paths.steps(), std::vector<GlobalIndex>{1});
  EXPECT_EQ(open_kind(paths.index, FileKind::result).read<GlobalIndex>("/steps/number"), std::vector<GlobalIndex>{1});
  EXPECT_EQ(check_items(read_text_file(paths.xdmf), scratch.path()), 8);
}

TEST(RunPaths, FollowTheNameOfTheCase) {
  const RunPaths paths = run_paths_of_case("cases/canopy.h5");
  EXPECT_EQ(paths.index, "cases/canopy.run.h5");
  EXPECT_EQ(paths.xdmf, "cases/canopy.run.xdmf");
  EXPECT_EQ(paths.csv, "cases/canopy.run.csv");
  EXPECT_EQ(paths.step(50), "cases/canopy.run/000050.h5");
  EXPECT_EQ(paths.checkpoint(1234567), "cases/canopy.run/restart-1234567.h5");
  EXPECT_EQ(paths.folder_name(), "canopy.run");
  EXPECT_EQ(run_paths_of_case("cases/canopy.h5", "out").index, "out/canopy.run.h5");
  EXPECT_EQ(error_of([] { run_paths("canopy.json"); }, ExitCode::usage).empty(), false);
}

}  // namespace
}  // namespace fbi::io
