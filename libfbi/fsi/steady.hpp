/// Steady flow, alone or past fixed fibers.
#pragma once

#include "fsi/system.hpp"

namespace fbi::fsi {

/// Solves the steady equations from the iterate of begin_step; tau follows the iterate.
///
/// Direct solver: two iterations with the convecting velocity frozen (Picard), then Newton; where Newton does not lower
/// the residual its step is taken back and three Picard iterations come before the next attempt. `picard` stays with
/// Picard. At most ten times newton_iterations.
///
/// Iterative solver: implicit pseudo-time steps with one linear solve each (Kelley, Keyes 1998). The step grows while
/// the linear systems stay easy, and shrinks where the residual rises.
///
/// Converged when the residual fell below newton_tolerance times the first, or below the absolute tolerance. A failure
/// is a report, not an exception. Collective.
StepReport solve_steady(System& system);

}  // namespace fbi::fsi
