/// Checkpoints: bitwise on any number of ranks, the last two are kept, another case is refused.
#include "io/checkpoint.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "example_case.hpp"
#include "io/pending_file.hpp"
#include "scratch.hpp"

namespace fbi::io {
namespace {

using test::error_of;
using test::expect_contains;
using test::Scratch;

// A number that depends on the file number, the component and the array, and uses all bits.
double value(GlobalIndex id, int component, int salt) {
  return std::sin(1.0 + static_cast<double>(id) * 12.9898 + component * 78.233 + salt) * 1e3;
}

struct Scene {
  explicit Scene(const Comm& comm)
      : content(test::example_case()),
        fluid(test::distribute_mesh(comm, content)),
        fibers(test::distribute_fibers(comm, content, &fluid)) {}
  CaseFile content;
  mesh::HexMesh fluid;
  mesh::FiberMesh fibers;

  std::vector<double> fluid_values(int salt) const {
    std::vector<double> values;
    for (Index n = 0; n < fluid.owned_nodes; ++n)
      for (int c = 0; c < 4; ++c) values.push_back(value(fluid.node_id[n], c, salt));
    return values;
  }
  std::vector<double> fiber_values(int components, int salt) const {
    std::vector<double> values;
    for (Index f = 0; f < fibers.fibers(); ++f)
      for (Index n = 0; n < fibers.first_node[f + 1] - fibers.first_node[f]; ++n)
        for (int c = 0; c < components; ++c) values.push_back(value(fibers.first_node_id[f] + n, c, salt));
    return values;
  }
};

CheckpointHeader header_of(GlobalIndex step) {
  CheckpointHeader header;
  header.step = step;
  header.time = 0.1 * static_cast<double>(step);
  header.case_fingerprint = fingerprint("the case");
  header.numbers = {{"dt", 1.0 / 3.0}, {"relaxation", 0.1}};
  header.vectors = {{"relaxation_history", {0.1, 0.2, 0.7}}, {"nothing", {}}};
  return header;
}

void write(const Comm& comm, const RunPaths& paths, Scene& scene, GlobalIndex step) {
  std::vector<double> now = scene.fluid_values(1), before = scene.fluid_values(2), dofs = scene.fiber_values(6, 3),
                      multiplier = scene.fiber_values(3, 4);
  write_checkpoint(comm, paths, header_of(step), &scene.fluid, {{"now", 4, &now}, {"before", 4, &before}},
                   &scene.fibers, {{"dofs", 6, &dofs}, {"multiplier", 3, &multiplier}});
}

void read_and_compare(const Comm& comm, const RunPaths& paths, GlobalIndex step) {
  const Scene scene(comm);
  std::vector<double> now, before, dofs, multiplier;
  const CheckpointHeader header = read_checkpoint(comm, paths, step, fingerprint("the case"), &scene.fluid,
                                                  {{"now", 4, &now}, {"before", 4, &before}}, &scene.fibers,
                                                  {{"dofs", 6, &dofs}, {"multiplier", 3, &multiplier}});
  EXPECT_EQ(header.step, step);
  EXPECT_EQ(header.time, header_of(step).time);
  EXPECT_EQ(header.numbers, header_of(step).numbers);
  EXPECT_EQ(header.vectors, header_of(step).vectors);
  EXPECT_EQ(now, scene.fluid_values(1));
  EXPECT_EQ(before, scene.fluid_values(2));
  EXPECT_EQ(dofs, scene.fiber_values(6, 3));
  EXPECT_EQ(multiplier, scene.fiber_values(3, 4));
}

RunPaths make_run(const Comm& comm, const Scratch& scratch) {
  const RunPaths paths = run_paths(scratch / "example.run.h5");
  if (comm.rank() == 0) make_directory(paths.directory);
  MPI_Barrier(comm.get());
  return paths;
}

TEST(Checkpoint, ComesBackBitwiseOnEqualAndOtherRanks) {
  const Comm comm;
  const Scratch scratch(comm);
  const RunPaths paths = make_run(comm, scratch);
  Scene scene(comm);
  write(comm, paths, scene, 50);
  read_and_compare(comm, paths, 50);
  // On fewer ranks: all but the last one, and rank 0 alone.
  for (const int ranks : {1, comm.size() - 1}) {
    if (ranks < 1) continue;
    MPI_Comm part;
    MPI_Comm_split(comm.get(), comm.rank() < ranks ? 0 : MPI_UNDEFINED, comm.rank(), &part);
    if (part == MPI_COMM_NULL) continue;
    read_and_compare(Comm(part), paths, 50);
    MPI_Comm_free(&part);
  }
  // Written by one rank, read by all.
  MPI_Barrier(comm.get());
  if (comm.rank() == 0) {
    const Comm alone(MPI_COMM_SELF);
    Scene whole(alone);
    write(alone, paths, whole, 60);
  }
  MPI_Barrier(comm.get());
  read_and_compare(comm, paths, 60);
}

TEST(Checkpoint, TheLastTwoAreKeptAndFound) {
  const Comm comm;
  const Scratch scratch(comm);
  const RunPaths paths = make_run(comm, scratch);
  expect_contains(error_of([&] { find_checkpoint(comm, paths, "last"); }), "without --restart");
  Scene scene(comm);
  for (const GlobalIndex step : {10, 20, 30, 40}) write(comm, paths, scene, step);
  MPI_Barrier(comm.get());
  EXPECT_EQ(paths.checkpoints(), (std::vector<GlobalIndex>{30, 40}));
  EXPECT_EQ(find_checkpoint(comm, paths, "last"), 40);
  EXPECT_EQ(find_checkpoint(comm, paths, "30"), 30);
  expect_contains(error_of([&] { find_checkpoint(comm, paths, "20"); }), "there are: 30, 40");
  expect_contains(error_of([&] { find_checkpoint(comm, paths, "first"); }, ExitCode::usage), "\"first\"");
  // Going on from step 30: what came after it is another story.
  MPI_Barrier(comm.get());
  write(comm, paths, scene, 35);
  MPI_Barrier(comm.get());
  EXPECT_EQ(paths.checkpoints(), (std::vector<GlobalIndex>{30, 35}));
}

TEST(Checkpoint, AnotherCaseAndBrokenFilesAreRefused) {
  const Comm comm;
  const Scratch scratch(comm);
  const RunPaths paths = make_run(comm, scratch);
  Scene scene(comm);
  write(comm, paths, scene, 5);
  const auto read = [&](const std::string& text, const StateArray& array) {
    return error_of([&] { read_checkpoint(comm, paths, 5, fingerprint(text), &scene.fluid, {array}, nullptr, {}); });
  };
  std::vector<double> values;
  expect_contains(read("an edited case", {"now", 4, &values}), "belongs to another case");
  expect_contains(read("the case", {"later", 4, &values}), "cannot read /fluid/later");
  expect_contains(read("the case", {"now", 3, &values}), "but this case needs 105 x 3");
  MPI_Barrier(comm.get());
  if (comm.rank() == 0) std::filesystem::resize_file(paths.checkpoint(5), 1000);
  MPI_Barrier(comm.get());
  expect_contains(read("the case", {"now", 4, &values}), "truncated or damaged; restart from another step");
}

TEST(Checkpoint, AFullDiskLeavesTheOlderOnes) {
  const Comm comm;
  const Scratch scratch(comm);
  const RunPaths paths = make_run(comm, scratch);
  Scene scene(comm);
  write(comm, paths, scene, 1);
  write(comm, paths, scene, 2);
  MPI_Barrier(comm.get());
  {
    const test::FileSizeLimit limit(16384);
    expect_contains(error_of([&] { write(comm, paths, scene, 3); }), "cannot write");
  }
  MPI_Barrier(comm.get());
  EXPECT_EQ(paths.checkpoints(), (std::vector<GlobalIndex>{1, 2}));
  read_and_compare(comm, paths, 2);
}

TEST(Checkpoint, FingerprintsTellTextsApart) {
  EXPECT_EQ(fingerprint(""), "cbf29ce484222325");  // the offset basis of 64-bit FNV-1a
  EXPECT_EQ(fingerprint("a"), "af63dc4c8601ec8c");
  EXPECT_NE(fingerprint("step: 1"), fingerprint("step: 2"));
}

}  // namespace
}  // namespace fbi::io
