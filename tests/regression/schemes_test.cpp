/// Monolithic and partitioned solution reach the same step.
#include "record.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

/// Compares `steps` steps of both schemes after `before` steps at usual tolerances.
void compare(const std::string& name, Json json, int before, int steps) {
  json["coupling"]["scheme"] = "monolithic";
  CoupledCase start(json);
  start.run(before);
  tighten(json);
  CoupledCase monolithic(json);
  monolithic.continue_from(start);
  json["coupling"]["scheme"] = "aitken";
  json["coupling"]["max_iterations"] = 200;
  tighten(json);
  CoupledCase aitken(json);
  aitken.continue_from(start);
  int iterations = 0;
  double worst[3] = {0.0, 0.0, 0.0};
  for (int step = 0; step < steps && !::testing::Test::HasFailure(); ++step) {
    monolithic.step();
    iterations = std::max(iterations, aitken.step().coupling_iterations);
    const Snapshot a = monolithic.snapshot(), b = aitken.snapshot();
    worst[0] = std::max(worst[0], relative_difference(b.displacement, a.displacement));
    worst[1] = std::max(worst[1], relative_difference(b.velocity, a.velocity));
    worst[2] = std::max(worst[2], relative_difference(b.lambda, a.lambda));
  }
  report(name + " displacement", worst[0]);
  report(name + " fluid velocity", worst[1]);
  report(name + " lambda", worst[2]);
  report(name + " most aitken iterations", iterations);
  report(name + " tip", monolithic.tip().norm());
  record({.section = "Coupling",
          .check = "monolithic and aitken reach the same step, " + name +
                   ": difference of displacement, fluid velocity, lambda",
          .source = "each other",
          .reference = 0.0,
          .ours_text = log::format("%.0e, %.0e, %.0e", worst[0], worst[1], worst[2]),
          .bar = "1e-8"});
  EXPECT_LE(worst[0], 1e-8);
  EXPECT_LE(worst[1], 1e-8);
  EXPECT_LE(worst[2], 1e-8);
}

Json geometry(Json json, const char* update) {
  json["coupling"]["geometry_update"] = update;
  return json;
}

// Not the first steps: there the tip moves by some 1e-7, and round-off in the axial force of the fiber, about 1e-16 EA
// times coordinate/element length, is not far below the forces themselves.
TEST(Schemes, single_beam_lagged) { compare("single-beam lagged", geometry(single_beam(), "lagged"), 50, 4); }
TEST(Schemes, single_beam_iterated) { compare("single-beam iterated", geometry(single_beam(), "iterated"), 50, 4); }

// Coarse in space and time: the fiber moves through several cells.
Json fast() {
  Json json = small_beam(R"({ "time": { "step": 5e-4, "end": 0.02 } })");
  set_inflow(json, 40.0, 0.02);
  return json;
}
TEST(Schemes, large_steps_lagged) { compare("large steps lagged", geometry(fast(), "lagged"), 0, 12); }
TEST(Schemes, large_steps_iterated) { compare("large steps iterated", geometry(fast(), "iterated"), 0, 12); }

}  // namespace
}  // namespace fbi::test
