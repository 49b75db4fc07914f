// Krylov iterations do not run away with the CFL number: convection and grad-div are in the pressure's part of the
// preconditioner, and its velocity block is solved further where flow is fast.
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

/// Iterations of a linear solve to 1e-4 once the flow has developed, of the small canopy on a coarse grid.
double iterations(double step) {
  Json json = read_case("canopy-small");
  json["channel"]["elements"] = {60, 16, 8};
  json["fibers"][0]["material"]["young"] = 1e10;
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
}

}  // namespace
}  // namespace fbi::test
