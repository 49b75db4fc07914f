#include "fsi/time_loop.hpp"

#include <cmath>

#include "base/log.hpp"
#include "base/timer.hpp"
#include "fsi/dirichlet_neumann.hpp"
#include "fsi/monolithic.hpp"
#include "fsi/one_way.hpp"
#include "fsi/steady.hpp"

namespace fbi::fsi {
namespace {

/// Fibers alone: Newton per fiber without coupling force.
StepReport solve_fibers(System& system) {
  StepReport report;
  report.coupling_iterations = 1;
  report.evaluations = 1;
  const int iterations = system.beams().solve_step(std::vector<double>(system.force_old().size(), 0.0));
  report.converged = iterations >= 0;
  report.newton = iterations;
  return report;
}

}  // namespace

std::string describe(const StepReport& report, const StepClock& clock) {
  std::string text = log::format(
      "step %lld (t = %.6g) did not converge: %s residual %.3e after %d nonlinear, %d Krylov and %d "
      "coupling iterations",
      static_cast<long long>(clock.step), clock.time,
      std::isfinite(report.residual) ? "" : "a non-finite number appeared;", report.residual, report.newton,
      report.krylov, report.coupling_iterations);
  if (!report.history.empty()) {
    const ResidualNorms& last = report.history.back();
    text +=
        log::format(" (relative: fluid %.2e, fibers %.2e, constraint %.2e)", last.fluid, last.fiber, last.constraint);
  }
  return text;
}

std::string remedy(const StepClock& clock) {
  if (clock.dt == 0.0)
    return "; the flow may have no steady state: give a closer fluid.initial_velocity, or run in time and let "
           "time.steady_tolerance end the run";
  return "; try a smaller time.step or more time.halvings, or raise solver.newton_iterations, solver.krylov_iterations "
         "or coupling.max_iterations if the residual was still falling";
}

StepReport solve_step(System& system, Acceleration* acceleration, const StepClock& clock) {
  Timed timed("step");
  system.begin_step(clock.time, clock.dt);
  if (!system.has_fluid()) return solve_fibers(system);
  if (system.fluid().is_steady()) return solve_steady(system);
  if (system.is_coupled() && system.scheme().direction == Direction::fiber_only) return solve_fiber_only(system);
  if (system.is_coupled() && system.scheme().direction == Direction::fluid_only) return solve_fluid_only(system);
  if (acceleration != nullptr && system.is_coupled() && system.fibers_move())
    return solve_dirichlet_neumann(system, *acceleration, clock.time, clock.dt);
  return solve_monolithic(system);
}

LoopEnd run_time_loop(System& system, Acceleration* acceleration, StepControl& control, GlobalIndex first,
                      GlobalIndex last, double dt, const StepObserver& after_step, std::string& failure) {
  for (GlobalIndex step = first + 1; step <= last; ++step) {
    StepClock clock{step, static_cast<double>(step) * dt, dt};
    StepReport report;
    if (!control.advance(system, acceleration, clock, report, failure)) return LoopEnd::failed;
    if (after_step(clock, report)) return LoopEnd::stopped;
  }
  return LoopEnd::finished;
}

}  // namespace fbi::fsi
