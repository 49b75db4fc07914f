/// Integrals over pieces of fiber elements: pure functions (SPEC section 3).
///
///   D(p,q) = int Phi_p H_q ds,  M(p,r) = int Phi_p N_r ds,  kappa(p) = int Phi_p ds,  ds = |dr_0/dx| dx
///
/// All three are sums over the same integration points.
#pragma once

#include <array>
#include <vector>

#include "coupling/curve.hpp"
#include "coupling/multiplier.hpp"
#include "coupling/projection.hpp"
#include "coupling/segmentation.hpp"
#include "fem/quadrature.hpp"

namespace fbi::coupling {

/// dr_0/dx of the reference curve in powers of x, by component: the measure of the integrals. Trivially copyable.
struct Measure {
  double c[3][3];
  double constant = -1.0;  ///< of a straight element, negative otherwise [length]
  /// |dr_0/dx| [length]
  double operator()(double x) const;
};
Measure make_measure(const Curve& reference);

/// An integration point of an element.
struct IntegrationPoint {
  double x = 0.0;    ///< in [-1, 1]
  double ds = 0.0;   ///< weight times |dr_0/dx| [length]
  Index number = 0;  ///< within the element, along it
};

/// Appends the integration points of a segment: `rule` on [begin, end], or one point of `rule` on the whole element.
void integration_points(const Measure& measure, const fem::QuadratureRule& rule, const Segment& segment,
                        std::vector<IntegrationPoint>& points);

/// Row sums of one element on the fiber's side; rows are those of the element.
struct ElementIntegrals {
  std::vector<double> kappa;             ///< [length]
  std::vector<std::array<double, 4>> d;  ///< columns d_1, t_1, d_2, t_2 [length, length^2]
  double length = 0.0;                   ///< int ds [length]

  /// Zeros for `rows` rows.
  void reset(Index rows);
};

/// Adds D, kappa and the arc length of some points to `sums`.
/// @param half_length  l_ele/2, the factor of the tangent functions [length]
void integrate_fiber(const Basis& basis, double half_length, const std::vector<IntegrationPoint>& points,
                     ElementIntegrals& sums);

/// Adds M of some points within one cell to `m`, shape=(rows of the element,8) [length]; columns are the corners of the
/// cell. Returns false when a point could not be projected: it is not in this cell.
bool integrate_fluid(const Basis& basis, const Curve& curve, const Cell& cell,
                     const std::vector<IntegrationPoint>& points, std::vector<std::array<double, 8>>& m);

}  // namespace fbi::coupling
