/// The time loop: steps the system with the chosen scheme until the end, a failure or a stop.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "fsi/acceleration.hpp"
#include "fsi/system.hpp"

namespace fbi::fsi {

/// Where in time a run is: step n ends at n dt.
struct StepClock {
  GlobalIndex step = 0;
  double time = 0.0;
  double dt = 0.0;
};

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

/// Steps from `first` (exclusive) to `last` (inclusive) with constant dt (0: one steady solution). `failure` receives
/// the report of a step that failed. Collective.
LoopEnd run_time_loop(System& system, Acceleration* acceleration, GlobalIndex first, GlobalIndex last, double dt,
                      const StepObserver& after_step, std::string& failure);

}  // namespace fbi::fsi
