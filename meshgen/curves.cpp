#include "meshgen/curves.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/error.hpp"
#include "base/log.hpp"
#include "fem/line_shapes.hpp"
#include "fem/quadrature.hpp"
#include "meshgen/smooth_curve.hpp"
#include "meshgen/spline.hpp"

namespace fbi::meshgen {
namespace {

class Line final : public CenterLine {
 public:
  Line(const Vec3& from, const Vec3& to) : from_(from), to_(to), direction_(to - from) {
    const double scale = std::max(from.cwiseAbs().maxCoeff(), to.cwiseAbs().maxCoeff());
    if (!(direction_.norm() > 1e-12 * scale))
      throw Error(ExitCode::geometry,
                  "has zero length: its curve begins and ends at the same point; move \"to\" away from \"from\"");
  }
  double length() const override { return direction_.norm(); }
  CurvePoint at(double u) const override {
    return {u == 1.0 ? to_ : Vec3(from_ + u * direction_), direction_ / direction_.norm()};
  }

 private:
  Vec3 from_, to_, direction_;
};

/// center + radius (cos(phi) e1 + sin(phi) e2), phi from 0 to `angle`.
class Arc final : public CenterLine {
 public:
  Arc(const Vec3& from, const Vec3& center, const Vec3& normal, double angle) : center_(center), angle_(angle) {
    const double size = normal.norm();
    if (!(size > 0.0))
      throw Error(ExitCode::geometry, "is an arc whose \"normal\" is zero; give the axis it turns about");
    const Vec3 arm = from - center, axis = normal / size;
    radius_ = arm.norm();
    if (!(radius_ > 1e-12 * std::max(from.cwiseAbs().maxCoeff(), center.cwiseAbs().maxCoeff())))
      throw Error(ExitCode::geometry,
                  "has zero length: its arc begins at the center; move \"from\" away from \"center\"");
    if (std::abs(arm.dot(axis)) > 1e-6 * radius_)
      throw Error(ExitCode::geometry,
                  log::format("is an arc whose start lies %.3g off the plane through \"center\" normal to \"normal\"; "
                              "move \"from\" or \"center\" into one plane, or turn \"normal\"",
                              std::abs(arm.dot(axis))));
    first_ = (arm - arm.dot(axis) * axis).normalized();
    second_ = axis.cross(first_);
  }
  double length() const override { return radius_ * std::abs(angle_); }
  CurvePoint at(double u) const override {
    const double phi = u * angle_, c = std::cos(phi), s = std::sin(phi);
    return {center_ + radius_ * (c * first_ + s * second_), (angle_ < 0 ? -1.0 : 1.0) * (c * second_ - s * first_)};
  }

 private:
  Vec3 center_, first_, second_;
  double radius_ = 0.0, angle_;
};

std::unique_ptr<CenterLine> arc_through(const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 u = b - a, v = c - a, normal = u.cross(v);
  const double size = normal.norm(), scale = std::max({u.norm(), v.norm(), (c - b).norm()});
  if (!(size > 1e-9 * scale * scale))
    throw Error(ExitCode::geometry,
                "is an arc whose points \"from\", \"through\" and \"to\" lie on one line or coincide; use \"type\": "
                "\"line\", or \"center\", \"normal\" and \"angle\" for a full circle");
  const Vec3 arm = (v.squaredNorm() * normal.cross(u) - u.squaredNorm() * normal.cross(v)) / (2 * size * size);
  const Vec3 axis = normal / size, first = -arm, last = c - (a + arm);
  double angle = std::atan2(axis.dot(first.cross(last)), first.dot(last));
  if (angle < 0) angle += 2 * std::numbers::pi;
  return std::make_unique<Arc>(a, a + arm, axis, angle);
}

}  // namespace

std::unique_ptr<CenterLine> make_center_line(const mesh::CurveParameters& curve) {
  switch (curve.type) {
    case mesh::CurveType::line:
      break;
    case mesh::CurveType::arc:
      if (curve.through_points) return arc_through(curve.from, curve.through, curve.to);
      return std::make_unique<Arc>(curve.from, curve.center, curve.normal, curve.angle);
    case mesh::CurveType::expression: {
      const input::VectorExpression& r = curve.position;
      const auto position = [&r](double t) { return Vec3(r[0](0, 0, 0, t), r[1](0, 0, 0, t), r[2](0, 0, 0, t)); };
      return std::make_unique<SmoothCurve>(position, std::vector<double>{curve.begin, curve.end});
    }
    case mesh::CurveType::spline: {
      const Spline spline(curve.points);
      return std::make_unique<SmoothCurve>([&spline](double t) { return spline(t); }, spline.knots());
    }
  }
  return std::make_unique<Line>(curve.from, curve.to);
}

double consistent_length(const Vec3& x1, const Vec3& t1, const Vec3& x2, const Vec3& t2) {
  static const fem::QuadratureRule rule = fem::gauss_legendre(10);
  const double chord = (x2 - x1).norm();
  const double straight = 4 * std::numeric_limits<double>::epsilon();
  if (chord > 0.0 && (chord * t1 - (x2 - x1)).norm() <= straight * chord &&
      (chord * t2 - (x2 - x1)).norm() <= straight * chord)
    return chord;
  double length = chord;
  // Newton on f(l) = int |r'| dxi - l; df/dl = int r'.(H^t1' t1 + H^t2' t2)/(2 |r'|) dxi - 1.
  for (int iteration = 0; chord > 0.0 && iteration < 100; ++iteration) {
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
  throw Error(ExitCode::geometry, "has an element with tangents that no arc length fits; use more elements");
}

}  // namespace fbi::meshgen
