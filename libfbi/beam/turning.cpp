#include "beam/turning.hpp"

#include <cmath>

namespace fbi::beam {

Vec3 turn(const Vec3& a, const Vec3& b, const Vec3& v) {
  const double c = a.dot(b);
  const Vec3 axis = a.cross(b);
  return c * v + axis.cross(v) + axis * (axis.dot(v) / (1 + c));
}

Mat3 turn_derivative(const Vec3& a, const Vec3& b, const Vec3& v) {
  const double c = a.dot(b);
  const Vec3 axis = a.cross(b);
  const Mat3 axis_by_b = skew_matrix(a);
  Mat3 d = v * a.transpose() - skew_matrix(v) * axis_by_b + axis.dot(v) / (1 + c) * axis_by_b;
  d += axis * (v.transpose() * axis_by_b) / (1 + c);
  d -= axis * a.transpose() * (axis.dot(v) / ((1 + c) * (1 + c)));
  return d;
}

Mat3 rotation_matrix(const Vec3& psi) {
  const double square = psi.squaredNorm(), angle = std::sqrt(square);
  // sin(x)/x and (1 - cos(x))/x^2
  const double a = angle < 1e-4 ? 1 - square / 6 : std::sin(angle) / angle;
  const double half = std::sin(0.5 * angle);
  const double b = angle < 1e-4 ? 0.5 - square / 24 : 2 * half * half / square;
  const Mat3 s = skew_matrix(psi);
  return Mat3::Identity() + a * s + b * s * s;
}

Vec3 rotation_vector(const Mat3& rotation) {
  const Eigen::Quaterniond q(rotation);
  const double sine = q.vec().norm();
  if (sine < 1e-8) return 2.0 / q.w() * q.vec();
  const double angle = 2 * std::atan2(q.w() < 0 ? -sine : sine, std::abs(q.w()));
  return angle / sine * q.vec();
}

Mat3 right_tangent_inverse(const Vec3& psi) {
  const double square = psi.squaredNorm(), angle = std::sqrt(square);
  const double factor = angle < 1e-3 ? 1.0 / 12 + square / 720 : (1 - 0.5 * angle / std::tan(0.5 * angle)) / square;
  const Mat3 s = skew_matrix(psi);
  return Mat3::Identity() + 0.5 * s + factor * s * s;
}

}  // namespace fbi::beam
