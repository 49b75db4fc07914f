/// The circle over which the ring operator averages, and the law that keeps a fiber's own radius: pure functions.
///
///   R = max(a, h/2),  x_q = x_c + R (cos th_q n1 + sin th_q n2),  th_q = 2 pi (q + 1/2)/n,  n = max(8, ceil(4 pi R/h))
///
/// A force spread over the ring is a Stokes cylinder of radius R; trilinear elements with PSPG add b h to it. What is
/// missing between that radius and a is a local logarithm, put in series as a finite compliance:
///
///   a_t = R + b_t h,  b_t = 0.175 - 0.32 ct/sqrt(ct + 0.03) (+ 0.02 with grad-div),  ct = tau_M mu/h^2
///   a_a = R + b_a h,  b_a = 0.15 + 0.015 h/R
///   1/eps_t = ln(a_t/a)/(4 pi mu),  1/eps_a = ln(a_a/a)/(2 pi mu)
#pragma once

#include "base/types.hpp"
#include "coupling/projection.hpp"

namespace fbi::coupling {

/// The circle around one integration point.
struct Ring {
  double radius = 0.0;  ///< R [length]
  Index points = 0;     ///< n
  Vec3 first, second;   ///< n1, n2: unit vectors normal to the fiber and to each other
  /// x_q - x_c [length].
  Vec3 offset(Index q) const;
};

/// Largest extent of a cell's edges (through its middle) normal to a unit vector [length].
double size_across(const Cell& cell, const Vec3& tangent);

/// @param radius     a of the fiber [length]
/// @param cell_size  h [length]
/// @param tangent    unit tangent of the center line
Ring make_ring(double radius, double cell_size, const Vec3& tangent);

/// What the law needs to know of the stabilisation in a cell.
struct CellViscosity {
  double viscous_tau = 0.0;  ///< ct = tau_M mu/h^2
  double grad_div = 0.0;     ///< tau_C/mu
};

/// Compliances of the interface law, force per length and velocity inverted; not negative.
struct Compliance {
  double across = 0.0;  ///< 1/eps_t [length^2/(force time)]
  double along = 0.0;   ///< 1/eps_a
};

/// The law that gives a fiber of radius a its own resistance; all lengths in one unit.
/// @param viscosity  mu
/// The grad-div term counts as 0.02 tau_C/mu, at most 0.02. Compliances below 1e-6/mu become that: an infinite penalty.
Compliance own_radius_law(double radius, double ring_radius, double cell_size, double viscosity,
                          const CellViscosity& cell);

}  // namespace fbi::coupling
