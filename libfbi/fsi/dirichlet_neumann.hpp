/// The partitioned loop: velocity of the fibers to the fluid, force of the fluid to the fibers (paper, section 4).
#pragma once

#include "fsi/acceleration.hpp"
#include "fsi/system.hpp"

namespace fbi::fsi {

/// Solves one step whose begin_step was called, by fixed-point iteration on the interaction force f = D^T lambda with
/// an acceleration scheme: x_k -> fibers -> (geometry) -> S = kappa/epsilon, g = D v_b -> fluid -> lambda -> H(x_k) =
/// D^T lambda. Stops when |H - x| <= tolerance |H| or <= absolute_tolerance sqrt(N). `time` and `dt` restart the trial
/// solves of the fibers from t_n, so that H is a function of x only. A failure is a report. Collective.
StepReport solve_dirichlet_neumann(System& system, Acceleration& acceleration, double time, double dt);

}  // namespace fbi::fsi
