/// Center lines and their Hermite interpolation.
#pragma once

#include <memory>

#include "base/types.hpp"
#include "mesh/parameters.hpp"

namespace fbi::meshgen {

/// A point of a center line and the unit tangent there.
struct CurvePoint {
  Vec3 position;
  Vec3 tangent;
};

/// A smooth center line, described by its arc length.
class CenterLine {
 public:
  virtual ~CenterLine() = default;
  /// Its length [length].
  virtual double length() const = 0;
  /// The point at the fraction u in [0, 1] of the arc length.
  virtual CurvePoint at(double u) const = 0;
};

/// The center line that the parameters describe. Throws Error(geometry) when they describe none: no length, three
/// points of an arc on a line, a formula that is not finite, has a kink or stands still; the text goes after the
/// fiber's name.
std::unique_ptr<CenterLine> make_center_line(const mesh::CurveParameters& curve);

/// Length l for which the cubic Hermite element with nodes x1, x2, unit tangents t1, t2 and tangent scale l/2 has arc
/// length l: int |r'(xi)| dxi = l by a 10-point Gauss rule, as the element of Hagemeyer, Mayr, Popp 2024, Appendix A,
/// has it (a finer rule changes that strongly bent element by 2e-6 of its length). The chord for a straight element.
/// Throws Error(geometry) when there is none.
double consistent_length(const Vec3& x1, const Vec3& t1, const Vec3& x2, const Vec3& t2);

}  // namespace fbi::meshgen
