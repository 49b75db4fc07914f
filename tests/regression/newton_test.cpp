/// Convergence of the monolithic Newton iteration.
#include "record.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

/// Residuals of one strongly nonlinear step: flow of speed 20 around a fiber that bends by a good part of its length.
std::vector<double> residuals(Json json, const std::string& name, int before, int* newton = nullptr) {
  json["time"] = {{"step", 2e-3}, {"end", 0.1}, {"fluid", {{"theta", 1.0}}}, {"beam", {{"rho_inf", 1.0}}}};
  set_inflow(json, 20.0, 0.03);
  tighten(json, 1e-11, 1e-12);
  CoupledCase run(json);
  run.run(before);
  const fsi::StepReport result = run.step();
  std::vector<double> history;
  for (std::size_t k = 0; k < result.history.size(); ++k) {
    const fsi::ResidualNorms& norms = result.history[k];
    history.push_back(std::max({norms.fluid, norms.fiber, norms.constraint}));
    report(name + " r_" + std::to_string(k) + " fluid", norms.fluid);
    report(name + " r_" + std::to_string(k) + " fibers", norms.fiber);
    if (norms.constraint > 0.0) report(name + " r_" + std::to_string(k) + " constraint", norms.constraint);
  }
  report(name + " tip", run.tip().norm());
  if (newton != nullptr) *newton = result.newton;
  return history;
}

TEST(Newton, quadratic_with_fixed_geometry) {
  int iterations = 0;
  const std::vector<double> r = residuals(small_beam(), "lagged", 6, &iterations);
  report("lagged Newton iterations", iterations);
  EXPECT_LE(iterations, 4);
  ASSERT_GE(r.size(), 4u) << "the step must be nonlinear enough to show an order";
  double constant = 0.0;
  for (std::size_t k = 1; k < r.size(); ++k)
    if (r[k] > 1e-10) constant = std::max(constant, r[k] / (r[k - 1] * r[k - 1]));
  report("lagged C of r_k+1 = C r_k^2", constant);
  std::string norms;
  for (const double value : r) norms += (norms.empty() ? "" : ", ") + log::format("%.1e", value);
  record({.section = "Coupling",
          .check = "Newton, geometry and tau fixed in the step, Krylov 1e-12: residuals of the iterations, constant C of "
                   "r_(k+1) <= C r_k^2",
          .source = "quadratic",
          .ours_text = norms + log::format("; C = %.2f", constant),
          .bar = "at most 4 iterations, C <= 10, last 1e-10"});
  for (std::size_t k = 1; k < r.size(); ++k)
    EXPECT_LE(r[k], std::max(1e-10, 10.0 * r[k - 1] * r[k - 1])) << "iteration " << k;
  EXPECT_LE(r.back(), 1e-10);
}

TEST(Newton, linear_with_iterated_geometry) {
  Json json = small_beam();
  json["coupling"]["geometry_update"] = "iterated";
  int iterations = 0;
  const std::vector<double> r = residuals(json, "iterated", 6, &iterations);
  report("iterated Newton iterations", iterations);
  double factor = 0.0;
  for (std::size_t k = 3; k < r.size(); ++k)
    if (r[k] > 1e-10) factor = std::max(factor, r[k] / r[k - 1]);
  report("iterated linear factor", factor);
  record({.section = "Coupling",
          .check = "Newton, geometry iterated: linear factor",
          .source = "definition",
          .ours = factor,
          .bar = "0.5"});
  EXPECT_LT(factor, 0.5);
  EXPECT_LE(r.back(), 1e-10);
}

}  // namespace
}  // namespace fbi::test
