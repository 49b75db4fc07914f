#include "fsi/step_control.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/counters.hpp"
#include "base/error.hpp"
#include "base/log.hpp"
#include "fsi/saved_state.hpp"
#include "fsi/time_loop.hpp"

namespace fbi::fsi {
namespace {

/// Adds what one attempt cost; the rest of the report is that of the last attempt.
void add(const StepReport& attempt, StepReport& sum) {
  sum.newton += attempt.newton;
  sum.krylov += attempt.krylov;
  sum.coupling_iterations += attempt.coupling_iterations;
  sum.evaluations += attempt.evaluations;
  sum.interface_krylov += attempt.interface_krylov;
  sum.relaxation = attempt.relaxation;
  sum.history = attempt.history;
}

/// One attempt; `problem` is empty when it converged. Errors that a smaller step may mend are problems, too.
StepReport attempt(System& system, Acceleration* acceleration, const StepClock& clock, std::string& problem,
                   std::string& hint) {
  StepReport report;
  hint.clear();
  try {
    report = solve_step(system, acceleration, clock);
    if (!report.converged) {
      problem = describe(report, clock);
      hint = remedy(clock);
    }
  } catch (const Error& error) {
    if (error.code() != ExitCode::diverged) throw;
    problem = log::format("step %lld (t = %.6g): %s", static_cast<long long>(clock.step), clock.time, error.what());
  }
  return report;
}

}  // namespace

bool StepControl::advance(System& system, Acceleration* acceleration, StepClock& clock, StepReport& report,
                          std::string& failure) {
  const GlobalIndex whole = GlobalIndex{1} << most_;  // the step in its smallest parts
  const double dt = clock.dt, grid_time = clock.time;
  const double level_at_start = level_, successes_at_start = successes_;
  const SavedAcceleration acceleration_at_start(acceleration);
  std::optional<SavedState> start;
  report = StepReport();
  report.parts = 0;
  level_ = std::min(level_, static_cast<double>(most_));
  for (GlobalIndex done = 0; done < whole;) {
    GlobalIndex size = whole >> static_cast<int>(level_);
    if (level_ > 0.0 && successes_ >= restore_after && done % (2 * size) == 0) {
      level_ -= 1.0;
      successes_ = 0.0;
      size *= 2;
    }
    if (size < whole && !start) start.emplace(system);
    const double share = static_cast<double>(size) / static_cast<double>(whole);
    StepClock part{clock.step, grid_time, dt};
    if (size < whole) {
      part.dt = share * dt;
      part.time = (static_cast<double>(clock.step - 1) + static_cast<double>(done + size) / whole) * dt;
    }
    const SavedAcceleration before(acceleration);
    std::string problem, hint;
    const StepReport result = attempt(system, acceleration, part, problem, hint);
    if (problem.empty() && refuse && refuse(part)) problem = "refused";
    add(result, report);
    if (problem.empty()) {
      system.accept_step();
      report.residual = std::max(report.residual, result.residual);
      clock.dt = std::min(clock.dt, part.dt);
      ++report.parts;
      successes_ = level_ > 0.0 ? successes_ + 1.0 : 0.0;
      done += size;
      continue;
    }
    before.restore();
    ++report.failures;
    count("steps repeated");
    if (static_cast<Index>(level_) < most_) {
      level_ += 1.0;
      successes_ = 0.0;
      log::warning("%s; repeated with dt = %.6g", problem.c_str(), 0.5 * part.dt);
      continue;
    }
    failure = size < whole ? log::format("step %lld (t = %.6g) did not converge, not even in parts of %.6g: %s",
                                         static_cast<long long>(clock.step), grid_time, part.dt, problem.c_str())
                           : problem;
    failure += hint;
    if (start) start->restore();
    acceleration_at_start.restore();
    level_ = level_at_start;
    successes_ = successes_at_start;
    return false;
  }
  if (report.parts > 1) count("parts of divided steps", report.parts);
  report.converged = true;
  return true;
}

}  // namespace fbi::fsi
