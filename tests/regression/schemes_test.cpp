/// Monolithic and partitioned solution reach the same step.
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

void compare(const std::string& name, Json json, int steps, double tolerance) {
  json["coupling"]["scheme"] = "monolithic";
  tighten(json, tolerance);
  CoupledCase monolithic(json);
  json["coupling"]["scheme"] = "aitken";
  json["coupling"]["max_iterations"] = 200;
  tighten(json, tolerance);
  CoupledCase aitken(json);
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
  EXPECT_LE(worst[0], 1e-8);
  EXPECT_LE(worst[1], 1e-8);
  EXPECT_LE(worst[2], 1e-8);
}

Json geometry(Json json, const char* update) {
  json["coupling"]["geometry_update"] = update;
  return json;
}

// In the first steps the tip moves by some 1e-6, so that round-off in the axial force of the fiber, about 1e-16 EA times
// coordinate/element length, is near 1e-11 of the force: a tolerance below that cannot be reached.
TEST(Schemes, single_beam_lagged) { compare("single-beam lagged", geometry(single_beam(), "lagged"), 4, 2e-11); }
TEST(Schemes, single_beam_iterated) { compare("single-beam iterated", geometry(single_beam(), "iterated"), 4, 2e-11); }

// Coarse in space and time: the fiber moves through several cells.
Json fast() {
  Json json = small_beam(R"({ "time": { "step": 5e-4, "end": 0.02 } })");
  set_inflow(json, 40.0, 0.02);
  return json;
}
TEST(Schemes, large_steps_lagged) { compare("large steps lagged", geometry(fast(), "lagged"), 12, 1e-11); }
TEST(Schemes, large_steps_iterated) { compare("large steps iterated", geometry(fast(), "iterated"), 12, 1e-11); }

}  // namespace
}  // namespace fbi::test
