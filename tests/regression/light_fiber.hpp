/// Fibers lighter than the fluid around them, and how much their force alternates from step to step.
#pragma once

#include "record.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {

inline constexpr int settled = 20, short_run = 40;

struct FiberRun {
  int newton = 0, coupling = 0;             ///< the most of a step
  int failed_step = 0;                      ///< 0: all converged
  double residual = 0.0, relaxation = 0.0;  ///< of the last step
  /// max |x_{n+1} - 2 x_n + x_{n-1}| / max |x| over the steps after `settled`: x = every multiplier, x = drag.
  double lambda = 0.0, drag = 0.0;
};

inline FiberRun run_fiber(const Json& json, int last = short_run) {
  CoupledCase run(json);
  FiberRun result;
  double second[2] = {0.0, 0.0}, largest[2] = {0.0, 0.0};
  std::vector<double> now, old;  // lambda_{n+1}, lambda_n
  Vec3 drag[3] = {Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
  for (int step = 1; step <= last; ++step) {
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
    const std::vector<double> before = std::move(old);  // lambda_{n-1}
    old = std::move(now);
    now = run.system().lambda_old();
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

inline Json light(double density, const char* weight, double rho_inf = 1.0) {
  Json json = single_beam();
  json["fibers"][0]["material"]["density"] = density;
  json["coupling"]["coupling_weight"] = weight;
  json["time"]["beam"]["rho_inf"] = rho_inf;
  return json;
}

inline FiberRun measure(const std::string& name, const Json& json, int last = short_run, const char* bar = "reported") {
  const FiberRun result = run_fiber(json, last);
  report(name + ", failed step", result.failed_step);
  report(name + ", most Newton iterations", result.newton);
  report(name + ", alternation of lambda", result.lambda);
  report(name + ", alternation of the drag", result.drag);
  record({.section = "Coupling",
          .check = "light fibers, " + name + log::format(", steps %d to %d: ", settled + 1, last) +
                   "second difference of lambda, of the drag, over the largest; Newton iterations",
          .source = "smooth force",
          .reference = 0.0,
          .ours_text = log::format("%.3f, %.2g; at most %d", result.lambda, result.drag, result.newton),
          .bar = bar});
  return result;
}

}  // namespace fbi::test
