/// A run that is restarted at half time goes on as if nothing had happened: bitwise on as many ranks, to solver
/// tolerance on others.
#include "case/checkpoints.hpp"
#include "regression/case_fixture.hpp"
#include "unit/io/scratch.hpp"

namespace fbi::test {
namespace {

constexpr int half = 6, whole = 12;

Json fast(const std::string& scheme) {
  Json json = small_beam(R"({ "time": { "step": 1e-3, "end": 0.012 } })");
  set_inflow(json, 20.0, 0.01);
  json["coupling"]["scheme"] = scheme;
  return json;
}

/// Runs to the end, with a checkpoint at half time.
void run_with_checkpoint(CoupledCase& run, const io::RunPaths& paths) {
  run.run(half);
  cases::save_checkpoint(run.setup, paths, run.text(), run.steps_done(), run.time());
  run.run(whole - half);
}

/// Restores the checkpoint and goes on to the end.
void run_restarted(CoupledCase& run, const io::RunPaths& paths) {
  const GlobalIndex step = cases::load_checkpoint(run.setup, paths, run.text(), std::to_string(half));
  EXPECT_EQ(step, half);
  run.set_step(step);
  run.run(whole - half);
}

/// Files of a run in a folder of its own, which is there. Collective.
io::RunPaths paths_in(const Scratch& scratch) {
  const io::RunPaths paths = io::run_paths(scratch / "case.run.h5");
  const Comm world;
  if (world.rank() == 0) std::filesystem::create_directories(paths.directory);
  MPI_Barrier(world.get());
  return paths;
}

/// Bitwise: the state vectors of both fields, on every rank.
void expect_identical(CoupledCase& a, CoupledCase& b) {
  const auto fluid_a = a.fluid().state(), fluid_b = b.fluid().state();
  ASSERT_EQ(fluid_a.size(), fluid_b.size());
  for (std::size_t k = 0; k < fluid_a.size(); ++k) {
    fluid::LocalArray x(fluid_a[k].second), y(fluid_b[k].second);
    Index different = 0;
    for (std::size_t i = 0; i < 4 * static_cast<std::size_t>(a.setup.fluid_mesh->owned_nodes); ++i)
      different += x[i] != y[i];
    EXPECT_EQ(different, 0) << "fluid " << fluid_a[k].first;
  }
  const auto beam_a = a.beams().state(), beam_b = b.beams().state();
  ASSERT_EQ(beam_a.size(), beam_b.size());
  for (std::size_t k = 0; k < beam_a.size(); ++k) EXPECT_EQ(*beam_a[k].second, *beam_b[k].second) << beam_a[k].first;
  EXPECT_EQ(a.system().lambda_old(), b.system().lambda_old());
  EXPECT_EQ(a.system().force_old(), b.system().force_old());
  EXPECT_EQ(a.system().force_older(), b.system().force_older());
  EXPECT_EQ(a.system().force_oldest(), b.system().force_oldest());
  EXPECT_EQ(a.system().last_motion(), b.system().last_motion());
}

void check_bitwise(const Json& json) {
  const Scratch scratch{Comm()};
  const io::RunPaths paths = paths_in(scratch);
  CoupledCase straight(json);
  run_with_checkpoint(straight, paths);
  CoupledCase restarted(json);
  run_restarted(restarted, paths);
  EXPECT_GT(straight.tip().norm(), 0.01);
  expect_identical(straight, restarted);
}

TEST(Restart, monolithic_is_bitwise) { check_bitwise(fast("monolithic")); }
TEST(Restart, triads_are_bitwise) {
  Json json = fast("monolithic");
  json["fibers"][0]["formulation"] = "simo_reissner";
  json["fibers"][0]["material"]["poisson"] = 0.3;
  check_bitwise(json);
}
TEST(Restart, aitken_is_bitwise) { check_bitwise(fast("aitken")); }
TEST(Restart, partitioned_schemes_are_bitwise) {
  Json json = fast("aitken");
  json["coupling"]["force_predictor"] = "quadratic";
  check_bitwise(json);
  json = fast("newton_krylov");
  json["coupling"]["differences"] = "nonlinear";
  json["coupling"]["geometry_update"] = "iterated";
  check_bitwise(json);
  for (const int reuse : {0, 3}) {
    json = fast("iqn_ils");
    json["coupling"]["reuse"] = reuse;
    json["coupling"]["implicit_penalty"] = reuse > 0;
    check_bitwise(json);
  }
}
TEST(Restart, extrapolated_geometry_is_bitwise) {
  for (const char* scheme : {"monolithic", "iqn_ils"}) {
    Json json = fast(scheme);
    json["coupling"]["geometry_update"] = "extrapolated";
    check_bitwise(json);
  }
}
TEST(Restart, one_way_coupling_is_bitwise) {
  for (const char* direction : {"fluid_only", "fiber_only"}) {
    Json json = fast("monolithic");
    json["fibers"][0]["loads"] = {{{"type", "force"}, {"value", {0.05, 0, 0}}}};
    json["coupling"]["direction"] = direction;
    json["coupling"]["geometry_update"] = "extrapolated";
    check_bitwise(json);
  }
}
TEST(Restart, rows_that_change_from_step_to_step_are_bitwise) {
  Json json = fast("monolithic");
  json["coupling"]["multiplier"] = "gauss_point";
  json["coupling"]["operator"] = "ring";
  json["coupling"]["penalty"] = "auto";
  json["coupling"]["gauss_points"] = 2;
  check_bitwise(json);
}
TEST(Restart, trapezoidal_rule_is_bitwise) {
  Json json = fast("monolithic");
  json["time"]["fluid"]["theta"] = 0.5;
  json["time"]["beam"]["rho_inf"] = 0.8;
  check_bitwise(json);
}
TEST(Restart, bdf2_is_bitwise) {
  Json json = fast("monolithic");
  json["time"]["fluid"] = {{"scheme", "bdf2"}};
  check_bitwise(json);
}
TEST(Restart, linearized_is_bitwise) {
  Json json = fast("monolithic");
  json["solver"]["nonlinear"] = "linearized";
  check_bitwise(json);
}
TEST(Restart, midpoint_scheme_with_a_moved_clamp_and_a_follower_load_is_bitwise) {
  Json json = fast("monolithic");
  json["time"]["beam"] = {{"scheme", "midpoint"}};
  json["fibers"][0].erase("clamped");
  json["fibers"][0]["supports"] = {{{"at", "start"},
                                    {"type", "clamped"},
                                    {"motion", {"0.01*sin(200*t)^2", 0, 0}},
                                    {"direction", {"0.1*sin(200*t)", 1, 0}}}};
  json["fibers"][0]["loads"] = {{{"type", "force"}, {"value", {1e-3, 0, 0}}, {"follower", true}}};
  check_bitwise(json);
}
TEST(Restart, rigid_fiber_is_bitwise) {
  Json json = fast("monolithic");
  json["fibers"][0].erase("clamped");
  json["fibers"][0]["material"].erase("young");
  json["fibers"][0]["formulation"] = "rigid";
  json["fibers"][0]["pinned"] = "start";
  check_bitwise(json);
}
TEST(Restart, iterated_geometry_on_a_general_mesh_is_bitwise) {
  Json json = fast("monolithic");
  json["coupling"]["geometry_update"] = "iterated";
  json["channel"]["general"] = true;
  check_bitwise(json);
}

// The checkpoint of one rank is taken up by all, and the other way round.
TEST(Restart, on_another_number_of_ranks) {
  Json json = fast("monolithic");
  tighten(json, 1e-11, 1e-8);
  const Comm world;
  linalg::initialize_petsc();  // on all ranks, before rank 0 works alone
  const Scratch scratch(world);
  const io::RunPaths paths = paths_in(scratch);
  if (world.rank() == 0) {
    CoupledCase serial(json, MPI_COMM_SELF);
    serial.run(half);
    cases::save_checkpoint(serial.setup, paths, serial.text(), half, serial.time());
  }
  MPI_Barrier(world.get());
  CoupledCase straight(json);
  straight.run(whole);
  CoupledCase restarted(json);
  run_restarted(restarted, paths);
  const Snapshot a = straight.snapshot(), b = restarted.snapshot();
  const double velocity = relative_difference(b.velocity, a.velocity);
  const double displacement = relative_difference(b.displacement, a.displacement);
  const double lambda = relative_difference(b.lambda, a.lambda);
  report("restart on other ranks, velocity", velocity);
  report("restart on other ranks, displacement", displacement);
  report("restart on other ranks, lambda", lambda);
  EXPECT_LE(velocity, 1e-8);
  EXPECT_LE(displacement, 1e-8);
  EXPECT_LE(lambda, 1e-8);

  const Scratch other(world);
  const io::RunPaths other_paths = paths_in(other);
  CoupledCase parallel(json);
  parallel.run(half);
  cases::save_checkpoint(parallel.setup, other_paths, parallel.text(), half, parallel.time());
  Snapshot c;
  if (world.rank() == 0) {
    CoupledCase serial(json, MPI_COMM_SELF);
    run_restarted(serial, other_paths);
    c = serial.snapshot();
    EXPECT_LE(relative_difference(c.velocity, a.velocity), 1e-8);
    EXPECT_LE(relative_difference(c.displacement, a.displacement), 1e-8);
    EXPECT_LE(relative_difference(c.lambda, a.lambda), 1e-8);
  }
  MPI_Barrier(world.get());
}

}  // namespace
}  // namespace fbi::test
