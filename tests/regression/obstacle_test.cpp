/// The first steps of the obstacle in the duct: ramp, mass balance, symmetry.
#include "record.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

TEST(Obstacle, ramp_mass_and_symmetry) {
  Json json = read_case("obstacle");
  const double dt = 1e-3;  // ten times that of the case
  json["time"]["step"] = dt;
  const double tolerance = 1e-6;
  json["solver"]["newton_tolerance"] = tolerance;
  CoupledCase run(json);
  double worst_net = 0.0, worst_inflow = 0.0, last_x = 0.0;
  constexpr int steps = 20;
  for (int step = 1; step <= steps && !HasFailure(); ++step) {
    run.step();
    const auto [net, given, all] = run.fluid().boundary_flow();
    // The trapezoidal rule on 11 intervals gives int y (1-y) = (1 - 1/121)/6.
    const double inflow =
        1600.0 * std::pow((1.0 - 1.0 / 121.0) / 6.0, 2) * 0.5 * (1.0 - std::cos(M_PI * step * dt / 0.05));
    worst_inflow = std::max(worst_inflow, std::abs(given / inflow - 1.0));
    worst_net = std::max(worst_net, std::abs(net) / inflow);
    EXPECT_GT(all, 1.9 * inflow) << "what comes in must go out";
    EXPECT_GT(run.tip()[0], last_x) << "the growing flow bends the fiber further";
    last_x = run.tip()[0];
  }
  report("net flow over inflow", worst_net);
  report("inflow, error", worst_inflow);
  report("tip x", run.tip()[0]);
  report("tip z over x", std::abs(run.tip()[2] / run.tip()[0]));
  record({.section = "Coupling",
          .check = "obstacle in a duct: net flow through the boundary over the inflow, 20 steps",
          .source = "conservation of mass",
          .reference = 0.0,
          .ours = worst_net,
          .bar = "1e-6"});
  EXPECT_LE(worst_inflow, 1e-9);
  EXPECT_LE(worst_net, tolerance);
  EXPECT_LE(std::abs(run.tip()[2]), 1e-8 * run.tip()[0]);
}

}  // namespace
}  // namespace fbi::test
