/// Integrals of one segment, a piece of a fiber element within one cell: pure functions (SPEC section 3).
///
///   D(p,q) = int Phi_p H_q ds,  M(p,r) = int Phi_p N_r ds,  kappa(p) = int Phi_p ds,  ds = |dr_0/dx| dx
///
/// Both functions below use the same points: `rule` on [begin, end].
#pragma once

#include <array>

#include "coupling/curve.hpp"
#include "coupling/multiplier.hpp"
#include "coupling/projection.hpp"
#include "fem/quadrature.hpp"

namespace fbi::coupling {

/// dr_0/dx of the reference curve in powers of x, by component: the measure of the integrals. Trivially copyable.
struct Measure {
  double c[3][3];
  /// |dr_0/dx| [length]
  double operator()(double x) const;
};
Measure make_measure(const Curve& reference);

/// Row sums of one segment on the fiber's side.
struct FiberIntegrals {
  std::array<double, rows_per_element> kappa{};             ///< [length]
  std::array<std::array<double, 4>, rows_per_element> d{};  ///< columns d_1, t_1, d_2, t_2 [length, length^2]
  double length = 0.0;                                      ///< int ds [length]
};

/// Adds D, kappa and the arc length of [begin, end] to `sums`.
/// @param half_length  l_ele/2, the factor of the tangent functions [length]
void integrate_fiber(const Measure& measure, double half_length, const fem::QuadratureRule& rule, double begin,
                     double end, FiberIntegrals& sums);

/// Adds M of [begin, end] to `m`, shape=(rows_per_element,8) [length]; the columns are the corners of the cell.
/// Returns false when a point could not be projected: the segment is not in this cell.
bool integrate_fluid(const Curve& curve, const Measure& measure, const Cell& cell, const fem::QuadratureRule& rule,
                     double begin, double end, std::array<std::array<double, 8>, rows_per_element>& m);

}  // namespace fbi::coupling
