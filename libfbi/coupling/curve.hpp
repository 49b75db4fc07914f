/// The center line of one fiber element as a cubic polynomial, and the crossings of cubics with given values.
#pragma once

#include "base/types.hpp"
#include "search/aabb.hpp"

namespace fbi::coupling {

/// c[0] + c[1] x + c[2] x^2 + c[3] x^3 on x in [-1, 1].
struct Cubic {
  double c[4];
  double value(double x) const { return c[0] + x * (c[1] + x * (c[2] + x * c[3])); }
  double slope(double x) const { return c[1] + x * (2.0 * c[2] + x * 3.0 * c[3]); }
  bool operator==(const Cubic&) const = default;
};

/// Center line r(x), x in [-1, 1], of one element, by component [length]. Trivially copyable: it travels between ranks.
struct Curve {
  Cubic component[3];
  Vec3 point(double x) const { return {component[0].value(x), component[1].value(x), component[2].value(x)}; }
  Vec3 slope(double x) const { return {component[0].slope(x), component[1].slope(x), component[2].slope(x)}; }
  /// The cubic n.r(x).
  Cubic along(const Vec3& n) const {
    Cubic result{};
    for (int k = 0; k < 4; ++k)
      result.c[k] = n[0] * component[0].c[k] + n[1] * component[1].c[k] + n[2] * component[2].c[k];
    return result;
  }
  bool operator==(const Curve&) const = default;
};

/// r(x) of SPEC section 2 in powers of x.
/// @param dofs1, dofs2  x, y, z, tx, ty, tz of the two nodes, shape=(6) [length, -]
/// @param length        l_ele [length]
Curve hermite_curve(const double* dofs1, const double* dofs2, double length);

/// Box of the four Bezier control points: it holds the whole curve, however much it is bent.
search::Aabb curve_box(const Curve& curve);

/// [-1, 1] cut at the extrema of a cubic: monotone in each piece.
struct MonotonePieces {
  explicit MonotonePieces(const Cubic& cubic);
  Cubic cubic;
  int count = 1;        ///< pieces, 1 to 3
  double x[4];          ///< ends of the pieces, ascending, x[0] = -1, x[count] = 1
  double value[4];      ///< the cubic there
  double low() const;   ///< smallest value on [-1, 1]
  double high() const;  ///< largest value on [-1, 1]
  /// Writes all x in [-1, 1] with cubic(x) = level, ascending, at most one for each piece; returns their number.
  int crossings(double level, double* roots) const;
};

}  // namespace fbi::coupling
