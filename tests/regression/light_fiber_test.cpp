/// Fibers much lighter than the fluid around them: the monolithic scheme does not care, and with equal impulses on
/// fluid and fibers the force does not alternate from step to step.
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

constexpr int settled = 20, steps = 40;

struct Record {
  int newton = 0, coupling = 0;             ///< the most of a step
  int failed_step = 0;                      ///< 0: all converged
  double residual = 0.0, relaxation = 0.0;  ///< of the last step
  /// max |x_{n+1} - 2 x_n + x_{n-1}| / max |x| over the steps after `settled`: x = every multiplier, x = drag.
  double lambda = 0.0, drag = 0.0;
};

Record run_fiber(Json json, int last = steps) {
  CoupledCase run(json);
  Record result;
  double second[2] = {0.0, 0.0}, largest[2] = {0.0, 0.0};
  Vec3 drag[3] = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  for (int step = 1; step <= last; ++step) {
    const std::vector<double> before = run.system().lambda_older();  // lambda_{n-1}
    const fsi::StepReport report = run.solve();
    result.newton = std::max(result.newton, report.newton);
    result.coupling = std::max(result.coupling, report.coupling_iterations);
    result.residual = report.residual;
    result.relaxation = report.relaxation;
    if (!report.converged) {
      result.failed_step = step;
      return result;
    }
    run.accept();
    for (int k = 0; k < 2; ++k) drag[k] = drag[k + 1];
    drag[2] = run.drag();
    const std::vector<double>&now = run.system().lambda_old(), &old = run.system().lambda_older();
    largest[1] = std::max(largest[1], drag[2].norm());
    for (const double value : now) largest[0] = std::max(largest[0], std::abs(value));
    if (step < settled + 3) continue;  // all three steps of a difference lie after `settled`
    for (std::size_t k = 0; k < now.size(); ++k)
      second[0] = std::max(second[0], std::abs(now[k] - 2 * old[k] + before[k]));
    second[1] = std::max(second[1], (drag[2] - 2 * drag[1] + drag[0]).norm());
  }
  result.lambda = run.comm().max(second[0]) / run.comm().max(largest[0]);
  result.drag = second[1] / largest[1];
  return result;
}

Json light(double density, const char* weight, double rho_inf = 1.0) {
  Json json = single_beam();
  json["fibers"][0]["material"]["density"] = density;
  json["coupling"]["weight"] = weight;
  json["time"]["beam"]["rho_inf"] = rho_inf;
  return json;
}

Record measure(const std::string& name, const Json& json) {
  const Record result = run_fiber(json);
  report(name + ", failed step", result.failed_step);
  report(name + ", most Newton iterations", result.newton);
  report(name + ", alternation of lambda", result.lambda);
  report(name + ", alternation of the drag", result.drag);
  return result;
}

// The stiffest modes of a fiber follow the trapezoidal rule (rho_inf = 1) without damping: the sudden acceleration of
// the flow at t = 0 leaves them ringing, most of all at the clamped foot. That is the fiber's own vibration and not one
// of the coupling: it goes away with rho_inf < 1 and does not show in the drag.
void check_fiber(double density) {
  const std::string name = "rho_b " + log::format("%g", density);
  const Record theta = measure(name + ", weight theta", light(density, "theta"));
  EXPECT_EQ(theta.failed_step, 0);
  EXPECT_LE(theta.newton, 4);
  EXPECT_LT(theta.drag, 0.05);
  const Record damped = measure(name + ", weight theta, rho_inf 0.8", light(density, "theta", 0.8));
  EXPECT_EQ(damped.failed_step, 0);
  EXPECT_LT(damped.lambda, 0.05);
  measure(name + ", weight 1-alpha_f", light(density, "1-alpha_f"));

  // Reported, not asked for: what the partitioned scheme does.
  Json json = light(density, "theta");
  json["coupling"]["scheme"] = "aitken";
  json["coupling"]["max_iterations"] = 200;
  const Record aitken = run_fiber(json, 2);
  report(name + ", aitken, most iterations", aitken.coupling);
  report(name + ", aitken, failed step", aitken.failed_step);
  report(name + ", aitken, residual", aitken.residual);
  report(name + ", aitken, relaxation factor", aitken.relaxation);
}

TEST(LightFiber, hundred_times_lighter) { check_fiber(0.1); }
TEST(LightFiber, thousand_times_lighter) { check_fiber(0.01); }

// A free fiber in a uniform flow that starts at once. Without stiffness against it, unequal impulses on fluid and fiber
// let the force alternate by a factor -1/(1 + 2 m_b/m_f) a step, m_b the fiber's mass and m_f the fluid's that the mesh
// adds to it, both per length: nearly undamped for a light fiber.
TEST(LightFiber, free_fiber_in_a_sudden_flow) {
  Json theta = light(0.1, "theta"), paper = light(0.1, "1-alpha_f");
  for (Json* json : {&theta, &paper}) {
    (*json)["channel"]["boundaries"]["xmin"]["velocity"] = {"5", "0", "0"};
    (*json)["fibers"][0]["curve"] =
        parse_json(R"({ "type": "line", "from": [1.51, 0.25, 0.03], "to": [1.51, 0.75, 0.03] })");
    (*json)["fibers"][0].erase("clamped");
  }
  const Record equal = measure("free fiber, weight theta", theta);
  const Record unequal = measure("free fiber, weight 1-alpha_f", paper);
  EXPECT_LT(equal.drag, 0.05);
  EXPECT_GT(unequal.drag, 1.0);
}

}  // namespace
}  // namespace fbi::test
