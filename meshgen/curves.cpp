#include "meshgen/curves.hpp"

#include <cmath>

#include "base/error.hpp"
#include "fem/line_shapes.hpp"
#include "fem/quadrature.hpp"

namespace fbi::meshgen {

CurvePoint point_on(const mesh::CurveParameters& curve, double u) {
  const Vec3 direction = curve.to - curve.from;
  CurvePoint point;
  point.position = u == 1.0 ? curve.to : Vec3(curve.from + u * direction);
  point.tangent = direction / direction.norm();
  return point;
}

double consistent_length(const Vec3& x1, const Vec3& t1, const Vec3& x2, const Vec3& t2) {
  static const fem::QuadratureRule rule = fem::gauss_legendre(10);
  const double chord = (x2 - x1).norm();
  const double straight = 4 * std::numeric_limits<double>::epsilon();
  if ((chord * t1 - (x2 - x1)).norm() <= straight * chord && (chord * t2 - (x2 - x1)).norm() <= straight * chord)
    return chord;
  double length = chord;
  // Newton on f(l) = int |r'| dxi - l; df/dl = int r'.(H^t1' t1 + H^t2' t2)/(2 |r'|) dxi - 1.
  for (int iteration = 0; iteration < 100; ++iteration) {
    double arc = 0.0, slope = 0.0;
    for (std::size_t q = 0; q < rule.points.size(); ++q) {
      const std::array<double, 4> h = fem::hermite_first(rule.points[q]);
      const Vec3 tangential = 0.5 * (h[1] * t1 + h[3] * t2);
      const Vec3 derivative = h[0] * x1 + h[2] * x2 + length * tangential;
      const double norm = derivative.norm();
      arc += rule.weights[q] * norm;
      if (norm > 0.0) slope += rule.weights[q] * derivative.dot(tangential) / norm;
    }
    const double change = (arc - length) / (1.0 - slope);
    if (!std::isfinite(change)) break;
    length += change;
    if (length > 0.0 && std::abs(change) <= 1e-15 * length) return length;
    if (length > 0.0 && iteration > 20 && std::abs(change) <= 1e-13 * length) return length;
  }
  throw Error(ExitCode::geometry, "a fiber element has tangents that no arc length fits; use more elements");
}

}  // namespace fbi::meshgen
