/// Center lines and their Hermite interpolation.
#pragma once

#include <functional>

#include "base/types.hpp"
#include "mesh/parameters.hpp"

namespace fbi::meshgen {

/// A point of a center line and the unit tangent there.
struct CurvePoint {
  Vec3 position;
  Vec3 tangent;
};

/// The point at the fraction u in [0, 1] of the arc length; the line from a to b must not have zero length.
CurvePoint point_on(const mesh::CurveParameters& curve, double u);

/// Length l for which the cubic Hermite element with nodes x1, x2, unit tangents t1, t2 and tangent scale l/2 has arc
/// length l: int |r'(xi)| dxi = l by a 10-point Gauss rule, as the element of Hagemeyer, Mayr, Popp 2024, Appendix A,
/// has it (a finer rule changes that strongly bent element by 2e-6 of its length). The chord for a straight element.
/// Throws Error(geometry) when there is none.
double consistent_length(const Vec3& x1, const Vec3& t1, const Vec3& x2, const Vec3& t2);

}  // namespace fbi::meshgen
