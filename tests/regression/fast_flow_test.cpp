// Krylov iterations do not run away with the CFL number: convection and grad-div are in the pressure's part of the
// preconditioner, and its velocity block is solved further where flow is fast. Nor with what stiff fibers under a large
// penalty add to fast and viscous flow, on ranks that share them.
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

/// Iterations of a linear solve to 1e-4 once the flow has developed, of the small canopy on a coarse grid.
double iterations(double step, double viscosity = 0.004, double penalty = 100, double density = 10) {
  Json json = read_case("canopy-small");
  json["channel"]["elements"] = {60, 16, 8};
  json["fluid"]["viscosity"] = viscosity;
  json["coupling"]["penalty"] = penalty;
  json["fibers"][0]["material"]["young"] = 1e10;
  json["fibers"][0]["material"]["density"] = density;
  json["time"]["beam"]["rho_inf"] = 0.5;
  json["time"]["step"] = step;
  json["solver"]["krylov_tolerance"] = 1e-4;
  json["solver"]["newton_tolerance"] = 1e-3;
  CoupledCase coupled(json);
  coupled.run(4);
  int krylov = 0, solves = 0;
  for (int k = 0; k < 5; ++k) {
    const fsi::StepReport report = coupled.step();
    krylov += report.krylov;
    solves += report.newton;
  }
  return static_cast<double>(krylov) / solves;
}

TEST(FastFlow, IterationsAtLargeSteps) {
  const double slow = iterations(2e-4), fast = iterations(1.6e-3);  // CFL 0.5 and 3.5
  report("iterations at CFL 0.5", slow);
  report("iterations at CFL 3.5", fast);
  EXPECT_LT(slow, 8.0);
  EXPECT_LT(fast, 1.5 * slow);
  // CFL 4.7 and 0.5, mu dt/(rho h^2) 0.9 and 1
  const double light = iterations(2e-3, 1.3, 1e4, 0.01), viscous = iterations(2e-4, 14, 1e4, 0.01);
  report("iterations at CFL 4.7, light stiff fibers, viscosity and penalty", light);
  report("iterations at CFL 0.5, the same", viscous);
  EXPECT_LT(light, 1.5 * slow);
  EXPECT_LT(viscous, 1.5 * slow);
}

}  // namespace
}  // namespace fbi::test
