/// Fibers much lighter than the fluid around them: the monolithic scheme does not care, and the multipliers do not
/// alternate from step to step when fluid and fibers receive the same impulse.
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

constexpr int settled = 20, steps = 40;

/// max |lambda_{n+1} - 2 lambda_n + lambda_{n-1}| / max |lambda| over the steps after `settled`.
struct Alternation {
  bool converged = true;
  int newton = 0, coupling = 0;  ///< the most of a step
  double ratio = 0.0;
  int failed_step = 0;
};

Alternation run_fiber(double density, const char* scheme, const char* weight, int last = steps) {
  Json json = single_beam();
  json["fibers"][0]["material"]["density"] = density;
  json["coupling"]["scheme"] = scheme;
  json["coupling"]["weight"] = weight;
  CoupledCase run(json);
  Alternation result;
  double second = 0.0, largest = 0.0;
  for (int step = 1; step <= last; ++step) {
    const std::vector<double> before = run.system().lambda_older();  // lambda_{n-1}
    const fsi::StepReport report = run.solve();
    result.newton = std::max(result.newton, report.newton);
    result.coupling = std::max(result.coupling, report.coupling_iterations);
    if (!report.converged) {
      result.converged = false;
      result.failed_step = step;
      return result;
    }
    run.accept();
    const std::vector<double>&now = run.system().lambda_old(), &last_one = run.system().lambda_older();
    for (std::size_t k = 0; k < now.size(); ++k) {
      largest = std::max(largest, std::abs(now[k]));
      // All three steps of the difference lie after `settled`.
      if (step > settled + 2) second = std::max(second, std::abs(now[k] - 2 * last_one[k] + before[k]));
    }
  }
  second = run.comm().max(second);
  largest = run.comm().max(largest);
  result.ratio = second / largest;
  return result;
}

void check_fiber(double density) {
  const std::string name = "rho_b " + log::format("%g", density);
  const Alternation theta = run_fiber(density, "monolithic", "theta");
  ASSERT_TRUE(theta.converged);
  report(name + ", weight theta, alternation", theta.ratio);
  report(name + ", weight theta, most Newton iterations", theta.newton);
  EXPECT_LT(theta.ratio, 0.05);
  EXPECT_LE(theta.newton, 4);

  const Alternation paper = run_fiber(density, "monolithic", "1-alpha_f");
  report(name + ", weight 1-alpha_f, converged", paper.converged);
  report(name + ", weight 1-alpha_f, alternation", paper.ratio);
  report(name + ", weight 1-alpha_f, most Newton iterations", paper.newton);

  const Alternation aitken = run_fiber(density, "aitken", "theta", 5);
  report(name + ", aitken, converged", aitken.converged);
  report(name + ", aitken, most iterations", aitken.coupling);
  report(name + ", aitken, failed step", aitken.failed_step);
}

TEST(LightFiber, as_heavy_as_in_the_paper) { check_fiber(10.0); }
TEST(LightFiber, hundred_times_lighter) { check_fiber(0.1); }
TEST(LightFiber, thousand_times_lighter) { check_fiber(0.01); }

}  // namespace
}  // namespace fbi::test
