/// One Newton loop on fluid, fibers and multipliers together, the fibers condensed (SPEC sections 4 and 5).
#pragma once

#include "fsi/system.hpp"

namespace fbi::fsi {

/// Solves one step whose begin_step was called. Each iteration condenses the fibers into S and g of S lambda = M v - g,
/// solves the fluid with the tangent A_FF + M^T S^-1 M, recovers lambda and then the fiber increments; with the
/// geometry lagged the constraint holds to round-off after every iteration. Also serves fluid alone (no multipliers)
/// and fixed fibers (S = kappa / epsilon). Fibers are settled by Newton iterations of their own, in the extrapolated
/// flow before the first linear solve and in the present one after each. Converged when the fluid and the fiber
/// residual both fell below newton_tolerance (fibers: at most 5e-3) times their first value, or below
/// newton_absolute_tolerance times the scale of forces; the first value of the fluid counts for no more than a
/// twentieth of the forces that change its momentum, unless the tolerance is at most 1e-3. With the convecting velocity
/// extrapolated there is exactly one linear solve: fluid, fibers linearised at their predictor and multipliers
/// together. What converges then is the residual of the fluid, which is linear; that of the fibers is nonlinear and
/// kept in the history. A failure is a report, not an exception. Collective.
StepReport solve_monolithic(System& system);

/// When a fluid solve ends: at `relative` of the reference, and at `force_share` of |D^T lambda| if that is less (0:
/// not asked for).
struct FluidTolerance {
  double relative = 0.0;
  double force_share = 0.0;
};

/// Fluid alone for given S and g (null: no multipliers): Newton on the fluid from its iterate, used by the partitioned
/// schemes. `lambda` returns S^-1 (M v - g). `reference` is raised to the first residual when that is larger (start a
/// step with 0). `geometry_changed`: what the solver knows of M is old; becomes false when it is renewed. Adds to the
/// counts of `report`. Returns false when it did not converge. Collective.
bool solve_fluid(System& system, const std::vector<double>* g, std::vector<double>& lambda, StepReport& report,
                 bool& geometry_changed, double& reference, const FluidTolerance& tolerance);

}  // namespace fbi::fsi
