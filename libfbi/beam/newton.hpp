/// Newton's method for the step of one fiber.
#pragma once

#include "beam/fiber_equations.hpp"

namespace fbi::beam {

/// Sets the first iterate of a step in time: d_n + dt v_n, or d_n where that gives the smaller residual.
///
/// Moving on is better for the slow motion, standing still for stiff modes (omega dt > 1) that the loads have set
/// ringing; a term dt^2/2 a_n would multiply those by (omega dt)^2.
void predict(FiberEquations& equations, Index fiber);
/// The same for all fibers in batches.
void predict_batches(FiberEquations& equations);

/// Solves G_b(d_{n+1}) = force for one fiber from the current iterate; `force`, shape=(nodes,6) of all fibers or empty.
///
/// Converged when the largest residual is below tolerance times the largest single force, one correction after it met
/// the level of its round-off, or when the correction is below tolerance times the change over the step. Where Newton
/// fails, the residual at d_n is removed in portions: G_b(d) - force = (1 - theta) (G_b(d_n) - force), theta from 0 to
/// 1, halving its step on failure. Returns the number of linear solves, or -1 (not converged, singular or not finite).
int solve_fiber(FiberEquations& equations, Index fiber, const std::vector<double>& force);

}  // namespace fbi::beam
