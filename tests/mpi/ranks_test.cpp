/// The answer of a coupled run does not depend on the number of ranks: every run is compared with one on rank 0 alone.
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

void broadcast(std::vector<double>& values) {
  long long size = static_cast<long long>(values.size());
  MPI_Bcast(&size, 1, MPI_LONG_LONG, 0, MPI_COMM_WORLD);
  values.resize(static_cast<std::size_t>(size));
  MPI_Bcast(values.data(), static_cast<int>(size), MPI_DOUBLE, 0, MPI_COMM_WORLD);
}

/// What a run of the case on rank 0 alone gives, on every rank.
Snapshot serial_run(const Json& json, int steps) {
  Snapshot result;
  const Comm world;
  linalg::initialize_petsc();  // on all ranks, before rank 0 works alone
  if (world.rank() == 0) {
    CoupledCase run(json, MPI_COMM_SELF);
    run.run(steps);
    result = run.snapshot();
  }
  broadcast(result.velocity);
  broadcast(result.pressure);
  broadcast(result.displacement);
  broadcast(result.lambda);
  return result;
}

void expect_equal(const std::string& name, CoupledCase& run, const Snapshot& expected, double tolerance = 1e-8) {
  const Snapshot found = run.snapshot();
  const double velocity = relative_difference(found.velocity, expected.velocity);
  const double pressure = relative_difference(found.pressure, expected.pressure);
  const double displacement = relative_difference(found.displacement, expected.displacement);
  const double lambda = relative_difference(found.lambda, expected.lambda);
  report(name + ", velocity", velocity);
  report(name + ", pressure", pressure);
  report(name + ", displacement", displacement);
  report(name + ", lambda", lambda);
  EXPECT_LE(velocity, tolerance);
  EXPECT_LE(pressure, tolerance);
  EXPECT_LE(displacement, tolerance);
  EXPECT_LE(lambda, tolerance);
}

Json fast() {
  Json json = small_beam(R"({ "time": { "step": 1e-3, "end": 0.02 } })");
  set_inflow(json, 20.0, 0.01);
  tighten(json, 1e-11, 1e-8);
  return json;
}

TEST(Ranks, single_beam) {
  Json json = single_beam();
  tighten(json, 2e-11, 1e-6);
  const Snapshot expected = serial_run(json, 3);
  CoupledCase run(json);
  run.run(3);
  expect_equal("single-beam", run, expected);
}

// One fiber on one rank: the others have none, and hold cells that it crosses or not.
TEST(Ranks, reversing_flow_with_ranks_without_fibers) {
  const Snapshot expected = serial_run(fast(), 12);
  CoupledCase run(fast());
  run.run(12);
  const GlobalIndex without = run.comm().sum(static_cast<GlobalIndex>(run.fibers().fibers() == 0));
  EXPECT_EQ(without, run.comm().size() - 1);
  expect_equal("rank without fibers", run, expected);
}

TEST(Ranks, aitken) {
  Json json = fast();
  json["coupling"]["scheme"] = "aitken";
  tighten(json, 1e-11, 1e-8);
  const Snapshot expected = serial_run(json, 5);
  CoupledCase run(json);
  run.run(5);
  expect_equal("aitken", run, expected);
}

TEST(Ranks, bdf2_linearized) {
  Json json = fast();
  json["time"]["fluid"] = {{"scheme", "bdf2"}};
  json["solver"]["nonlinear"] = "linearized";
  const Snapshot expected = serial_run(json, 5);
  CoupledCase run(json);
  run.run(5);
  expect_equal("bdf2, linearized", run, expected);
}

TEST(Ranks, iterated_geometry_on_a_general_mesh) {
  Json json = fast();
  json["coupling"]["geometry_update"] = "iterated";
  json["channel"]["general"] = true;
  const Snapshot expected = serial_run(json, 5);
  CoupledCase run(json);
  run.run(5);
  expect_equal("general mesh", run, expected);
}

// x = 1.5 is the plane between two ranks and a cell face, z = 0.03 another face: the fiber stands on an edge of cells
// and on the boundary of ranks, where each piece must belong to exactly one cell.
TEST(Ranks, fiber_on_faces_edges_and_rank_boundary) {
  Json json = fast();
  json["fibers"][0]["curve"] = parse_json(R"({ "type": "line", "from": [1.5, 0, 0.03], "to": [1.5, 0.5, 0.03] })");
  Json second = json["fibers"][0];
  second["name"] = "wall";  // on the wall z = 0, in a face x = const
  second["curve"] = parse_json(R"({ "type": "line", "from": [0.75, 0, 0], "to": [0.75, 0.5, 0] })");
  Json third = json["fibers"][0];
  third["name"] = "floor";  // along an edge of the floor
  third["curve"] = parse_json(R"({ "type": "line", "from": [1.25, 0, 0.03], "to": [1.75, 0, 0.03] })");
  third["pinned"] = "both";
  third.erase("clamped");
  json["fibers"].push_back(second);
  json["fibers"].push_back(third);
  const Snapshot expected = serial_run(json, 6);
  CoupledCase run(json);
  run.run(6);
  EXPECT_NEAR(run.coupling().coverage().covered, 1.5, 1e-12);
  EXPECT_LE(run.coupling().coverage().identity_error, 1e-12);
  expect_equal("faces and edges", run, expected);
}

/// Number of multiplier rows that cells of this rank touch.
GlobalIndex touched_rows(CoupledCase& run) { return static_cast<GlobalIndex>(run.coupling().local_m().row.size()); }

// A soft fiber beside the plane x = 1.5 between two ranks bends through it.
TEST(Ranks, fiber_that_crosses_a_rank_boundary) {
  Json json = fast();
  json["fibers"][0]["curve"] =
      parse_json(R"({ "type": "line", "from": [1.495, 0, 0.031], "to": [1.495, 0.5, 0.031] })");
  json["fibers"][0]["material"] = {{"young", 1e6}, {"density", 10}};
  const int steps = 15;
  const Snapshot expected = serial_run(json, steps);
  CoupledCase run(json);
  run.step();
  const GlobalIndex before = touched_rows(run);
  double right = 1.0;
  bool changed = false;
  for (int step = 1; step < steps; ++step) {
    run.step();
    right = std::max(right, 1.495 + run.tip()[0]);
    changed = changed || touched_rows(run) != before;
  }
  report("crossing, rightmost tip", right);
  EXPECT_GT(right, 1.52);
  // With two ranks or more some rank holds other pieces of the fiber than at the start.
  if (run.comm().size() == 2 || run.comm().size() == 4) {
    EXPECT_TRUE(run.comm().any(changed));
  }
  expect_equal("crossing", run, expected);
}

}  // namespace
}  // namespace fbi::test
