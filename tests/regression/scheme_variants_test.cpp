/// Every partitioned scheme reaches the step of the monolithic one, on any number of ranks; geometry extrapolated in
/// time.
#include "record.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

// Coarse in space and time: the fiber moves through several cells.
Json fast() {
  Json json = small_beam(R"({ "time": { "step": 5e-4, "end": 0.02 } })");
  set_inflow(json, 40.0, 0.02);
  return json;
}

Json merged(Json json, const Json& changes) {
  json.merge_patch(changes);
  return json;
}

/// Largest relative differences of displacement, fluid velocity and lambda to the monolithic step.
void compare(const std::string& name, const Json& variant, const Json& common = Json::object()) {
  const int before = 6, steps = 2;
  const Json json = merged(fast(), common);
  CoupledCase start(json);
  start.run(before);
  Json tight = json;
  tighten(tight);
  CoupledCase monolithic(tight);
  monolithic.continue_from(start);
  tight = merged(json, {{"coupling", variant}});
  tight["coupling"]["max_iterations"] = 200;
  tighten(tight);
  CoupledCase other(tight);
  other.continue_from(start);
  double worst[3] = {0.0, 0.0, 0.0};
  int evaluations = 0;
  for (int step = 0; step < steps && !::testing::Test::HasFailure(); ++step) {
    monolithic.step();
    const fsi::StepReport found = other.step();
    evaluations = std::max(evaluations, found.evaluations);
    EXPECT_GE(found.evaluations, found.coupling_iterations);
    EXPECT_EQ(found.interface_krylov > 0, variant["scheme"] == "newton_krylov");
    const Snapshot a = monolithic.snapshot(), b = other.snapshot();
    worst[0] = std::max(worst[0], relative_difference(b.displacement, a.displacement));
    worst[1] = std::max(worst[1], relative_difference(b.velocity, a.velocity));
    worst[2] = std::max(worst[2], relative_difference(b.lambda, a.lambda));
  }
  report(name + ", most evaluations", evaluations);
  record({.section = "Coupling",
          .check = "the step of " + name + " is that of monolithic: difference of displacement, fluid velocity, lambda",
          .source = "each other",
          .reference = 0.0,
          .ours_text = log::format("%.0e, %.0e, %.0e; %d evaluations", worst[0], worst[1], worst[2], evaluations),
          .bar = "1e-8"});
  for (const double difference : worst) EXPECT_LE(difference, 1e-8) << name;
}

// A heavy fiber: light ones leave a constant factor hundreds of iterations.
TEST(SchemeVariants, Constant) {
  Json heavy = fast()["fibers"];
  heavy[0]["material"]["density"] = 200;
  compare("constant", {{"scheme", "constant"}, {"relaxation", 0.3}}, {{"fibers", heavy}});
}
TEST(SchemeVariants, Aitken) { compare("aitken", {{"scheme", "aitken"}, {"force_predictor", "quadratic"}}); }
TEST(SchemeVariants, NewtonKrylov) { compare("newton_krylov", {{"scheme", "newton_krylov"}}); }
TEST(SchemeVariants, NewtonKrylovNonlinear) {
  compare("newton_krylov, nonlinear differences, iterated geometry",
          {{"scheme", "newton_krylov"}, {"differences", "nonlinear"}, {"gamma", 1e-4}},
          {{"coupling", {{"geometry_update", "iterated"}}}});
}
TEST(SchemeVariants, Iqn) { compare("iqn_ils", {{"scheme", "iqn_ils"}, {"force_predictor", "constant"}}); }
TEST(SchemeVariants, IqnIteratedGeometry) {
  compare("iqn_ils, iterated geometry", {{"scheme", "iqn_ils"}}, {{"coupling", {{"geometry_update", "iterated"}}}});
}
TEST(SchemeVariants, IqnExtrapolatedGeometry) {
  compare("iqn_ils, extrapolated geometry", {{"scheme", "iqn_ils"}},
          {{"coupling", {{"geometry_update", "extrapolated"}}}});
}
TEST(SchemeVariants, ImplicitPenalty) {
  for (const char* scheme : {"aitken", "newton_krylov", "iqn_ils"})
    compare(std::string(scheme) + ", implicit penalty", {{"scheme", scheme}, {"implicit_penalty", true}});
}
TEST(SchemeVariants, OtherRows) {
  compare("iqn_ils, gauss_point multipliers, iterated geometry", {{"scheme", "iqn_ils"}, {"implicit_penalty", true}},
          {{"coupling", {{"multiplier", "gauss_point"}, {"geometry_update", "iterated"}}}});
}

}  // namespace
}  // namespace fbi::test
