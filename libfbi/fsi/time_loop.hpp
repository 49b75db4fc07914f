/// The time loop: steps the system with the chosen scheme until the end, a failure or a stop.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "fsi/acceleration.hpp"
#include "fsi/step_control.hpp"
#include "fsi/system.hpp"

namespace fbi::fsi {

/// Why the loop ended.
enum class LoopEnd {
  finished,  ///< the last step is done
  stopped,   ///< the observer asked for it
  failed     ///< a step did not converge or met a non-finite number; fields are those of the last accepted step
};

/// Called after every accepted step, on every rank; returns true to stop (the same on every rank).
using StepObserver = std::function<bool(const StepClock&, const StepReport&)>;

/// Solves one step of whatever is there: both fields, the fluid alone, or fibers alone. Does not accept it. Collective.
StepReport solve_step(System& system, Acceleration* acceleration, const StepClock& clock);

/// Why a step failed, and, as the end of that sentence, what can be done about it.
std::string describe(const StepReport& report, const StepClock& clock);
std::string remedy(const StepClock& clock);

/// Steps from `first` (exclusive) to `last` (inclusive) on a grid of constant dt (0: one steady solution); where a step
/// does not converge `control` divides it. `failure` receives the report of a step that failed. Collective.
LoopEnd run_time_loop(System& system, Acceleration* acceleration, StepControl& control, GlobalIndex first,
                      GlobalIndex last, double dt, const StepObserver& after_step, std::string& failure);

}  // namespace fbi::fsi
