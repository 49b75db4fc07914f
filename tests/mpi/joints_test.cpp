/// Joined fibers in a fluid: partitioned and monolithic agree, on any number of ranks, and a restart is bitwise.
#include "case/checkpoints.hpp"
#include "record.hpp"
#include "regression/case_fixture.hpp"
#include "unit/io/scratch.hpp"

namespace fbi::test {
namespace {

/// A post, an arm rigidly joined to its top and a thread that hangs on a hinge at the arm's end; a second post alone.
/// `sheared`: post and arm with shear and torsion.
Json flag(bool sheared = false) {
  Json json = small_beam(R"({ "time": { "step": 1e-3, "end": 0.012 } })");
  set_inflow(json, 20.0, 0.01);
  const auto shape = [](double x0, double y0, double x1, double y1) {
    return Json{{"type", "line"}, {"from", {x0, y0, 0.031}}, {"to", {x1, y1, 0.031}}};
  };
  Json post = json["fibers"][0], arm = post, thread = post, alone = post;
  arm.erase("clamped");
  thread.erase("clamped");
  post["name"] = "post";
  arm["name"] = "arm";
  thread["name"] = "thread";
  alone["name"] = "alone";
  post["curve"] = shape(1.41, 0, 1.41, 0.4);
  alone["curve"] = shape(0.71, 0, 0.71, 0.5);
  arm["curve"] = shape(1.41, 0.4, 1.61, 0.45);
  thread["curve"] = shape(1.61, 0.45, 1.61, 0.2);
  if (sheared)
    for (Json* fiber : {&post, &arm}) {
      (*fiber)["formulation"] = "simo_reissner";
      (*fiber)["section"] = {{"radius", 5.6419e-3}};
      (*fiber)["material"]["poisson"] = 0.3;
    }
  json["fibers"] = Json::array({thread, alone, arm, post});
  json["joints"] =
      Json::array({Json{{"a", "post"}, {"b", "arm"}, {"type", "rigid"}}, Json{{"a", "arm"}, {"b", "thread"}}});
  return json;
}

void broadcast(std::vector<double>& values) {
  long long size = static_cast<long long>(values.size());
  MPI_Bcast(&size, 1, MPI_LONG_LONG, 0, MPI_COMM_WORLD);
  values.resize(static_cast<std::size_t>(size));
  MPI_Bcast(values.data(), static_cast<int>(size), MPI_DOUBLE, 0, MPI_COMM_WORLD);
}

void same_on_all_ranks(Json json) {
  tighten(json, 1e-11, 1e-8);
  Snapshot expected;
  const Comm world;
  linalg::initialize_petsc();
  if (world.rank() == 0) {
    CoupledCase run(json, MPI_COMM_SELF);
    run.run(10);
    expected = run.snapshot();
  }
  for (std::vector<double>* values : {&expected.velocity, &expected.displacement, &expected.lambda}) broadcast(*values);
  CoupledCase run(json);
  run.run(10);
  const Snapshot found = run.snapshot();
  const double differences[3] = {relative_difference(found.velocity, expected.velocity),
                                 relative_difference(found.displacement, expected.displacement),
                                 relative_difference(found.lambda, expected.lambda)};
  for (const double difference : differences) {
    report("joined fibers, ranks", difference);
    EXPECT_LE(difference, 1e-8);
  }
  EXPECT_GT(run.comm().max(std::abs(run.tip(2)[0])), 1e-3);
}

TEST(JointsInFluid, SameOnAllRanks) {
  for (const bool sheared : {false, true}) same_on_all_ranks(flag(sheared));
}

void monolithic_and_aitken_agree(Json json, const std::string& name) {
  tighten(json, 1e-11, 1e-8);
  CoupledCase together(json);
  json["coupling"]["scheme"] = "aitken";
  tighten(json, 1e-11, 1e-8);
  CoupledCase in_turns(json);
  together.run(4);
  in_turns.run(4);
  const Snapshot a = together.snapshot(), b = in_turns.snapshot();
  const double velocity = relative_difference(a.velocity, b.velocity),
               displacement = relative_difference(a.displacement, b.displacement);
  report("joined fibers, monolithic against aitken, velocity", velocity);
  report("joined fibers, monolithic against aitken, displacement", displacement);
  EXPECT_LE(velocity, 1e-8);
  EXPECT_LE(displacement, 1e-8);
  record({.section = "Coupling",
          .id = "",
          .check = name + " with a rigid joint and a hinge in a reversing flow: monolithic against aitken, 4 steps",
          .source = "identity",
          .error = std::max(velocity, displacement),
          .bar = "1e-8"});
}

TEST(JointsInFluid, MonolithicAndAitkenAgree) {
  monolithic_and_aitken_agree(flag(), "fibers");
  if (Comm().size() == 1) monolithic_and_aitken_agree(flag(true), "two simo_reissner fibers and a torsion_free one");
}

void restart_is_bitwise(const Json& json) {
  const Comm world;
  const Scratch scratch(world);
  const io::RunPaths paths = io::run_paths(scratch / "case.run.h5");
  if (world.rank() == 0) std::filesystem::create_directories(paths.directory);
  MPI_Barrier(world.get());
  CoupledCase whole(json);
  whole.run(4);
  cases::save_checkpoint(whole.setup, paths, whole.text(), whole.steps_done(), whole.time());
  whole.run(4);
  CoupledCase again(json);
  again.set_step(cases::load_checkpoint(again.setup, paths, again.text(), "4"));
  again.run(4);
  const auto a = whole.beams().state(), b = again.beams().state();
  for (std::size_t k = 0; k < a.size(); ++k) EXPECT_EQ(*a[k].second, *b[k].second) << a[k].first;
  EXPECT_EQ(whole.system().lambda_old(), again.system().lambda_old());
}

TEST(JointsInFluid, RestartIsBitwise) {
  for (const bool sheared : {false, true}) restart_is_bitwise(flag(sheared));
}

}  // namespace
}  // namespace fbi::test
