/// The fibers condensed into the interface: their compliance in S, their free motion in g (SPEC section 4).
#pragma once

#include <vector>

#include "coupling/interface_operator.hpp"
#include "fsi/system.hpp"

namespace fbi::fsi {

/// S += c w D K_b^-1 D^T of every fiber that moves, at its last linearisation, with c = gamma/(beta dt). `s` holds the
/// interface law of the present operators. Not factorised.
void add_compliance(const System& system, coupling::InterfaceOperator& s);

/// S and g of the condensed fibers at the current, linearised iterate: S = law + c w D K_b^-1 D^T,
/// g = D v_b + c D K_b^-1 ((1-w) D^T lambda_n - G_b), shape=(rows,3) [velocity length]. Fibers that do not feel the
/// fluid leave S alone and give g = D v_b. False on all ranks when a block is singular. Collective.
bool condense(System& system, std::vector<double>& g);

/// lambda = S^-1 (M u - g) at the iterate of the fluid, shape=(rows,3) [force/length]. Collective.
void multipliers(System& system, const std::vector<double>& g, std::vector<double>& lambda);
/// The same with M u at hand, shape=(rows,3) [length^2/time].
void multipliers(System& system, const std::vector<double>& interpolated, const std::vector<double>& g,
                 std::vector<double>& lambda);

/// 2-norm of the fibers' residual G_b - force at the linearised iterate, without what supports carry, with the moments
/// of triads and the gaps of joints; `force` of shape=(fiber nodes,6). Collective.
double fiber_residual(const System& system, const std::vector<double>& force);

/// What round-off, or newton_absolute_tolerance, leaves in fiber_residual [force]. Collective.
double fiber_round_off(const System& system);

/// Increments d by K_b^-1 (force - G_b) for every moving fiber and returns that, shape=(fiber nodes,6). Needs the
/// linearisation at the current iterate.
std::vector<double> move_fibers(System& system, const std::vector<double>& force);

/// Residuals, tangents and factors of the fibers at the iterate, unless they are there.
void linearize_fibers(System& system);
/// The residuals alone: tangents follow where the step goes on.
void evaluate_fibers(System& system);

/// Newton iterations of the fibers and multipliers in the present flow: what is nonlinear about fibers is settled where
/// it costs little, before the flow is solved again. A fiber whose residual would grow stays where it was. Leaves the
/// residual of the last positions, but tangents, S and g of those before. False on all ranks if S is singular.
/// Collective.
/// @param most    number of iterations
/// @param enough  fiber_residual to reach [force]
/// @param condensed  tangents, S, g and lambda are those of the present positions and flow
/// @param lambda  multipliers, shape=(rows,3) [force/length]
/// @param norm    fiber_residual before and after [force]
bool correct_fibers(System& system, int most, double enough, bool condensed, std::vector<double>& g,
                    std::vector<double>& lambda, double& norm);

/// 2-norm of nodal values of all ranks. Collective.
double interface_norm(const Comm& comm, const std::vector<double>& values);

}  // namespace fbi::fsi
