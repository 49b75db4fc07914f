/// Rotations in space: unit quaternions, rotation vectors and the derivatives that join them.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "base/types.hpp"

namespace fbi::beam {

using Quaternion = Eigen::Quaterniond;

/// Skew matrix of a, hat(a) b = a x b.
inline Mat3 hat(const Vec3& a) {
  Mat3 matrix;
  matrix << 0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0;
  return matrix;
}

/// q / |q|; not a number stays so.
inline Quaternion normalized(const Quaternion& q) {
  const double inverse = 1.0 / std::sqrt(q.w() * q.w() + q.x() * q.x() + q.y() * q.y() + q.z() * q.z());
  return {q.w() * inverse, q.x() * inverse, q.y() * inverse, q.z() * inverse};
}

/// Rotation by the vector `a` [rad].
inline Quaternion exponential(const Vec3& a) {
  const double half = 0.5 * a.norm();
  // sin(half)/(2 half)
  const double factor = std::isgreater(half, 1e-4) ? 0.5 * std::sin(half) / half : 0.5 - half * half / 12;
  return {std::cos(half), factor * a[0], factor * a[1], factor * a[2]};
}

/// Rotation vector of a unit quaternion, of length at most pi.
inline Vec3 logarithm(const Quaternion& q) {
  const double sign = std::isless(q.w(), 0.0) ? -1.0 : 1.0;
  const Vec3 v = sign * Vec3(q.x(), q.y(), q.z());
  const double n = v.norm();
  return (std::isgreater(n, 0.0) ? 2 * std::atan2(n, sign * q.w()) / n : 2.0) * v;
}

/// Coefficients of the maps below as functions of the squared angle s, with their derivatives by s.
///
/// With hat = hat(psi): exp(psi)^T d exp(psi) = T(psi) d psi, T = I - b hat + c hat^2, T^-1 = I + hat/2 + e hat^2,
/// b = (1 - cos)/s, c = (angle - sin)/angle^3, e = (1 - (angle/2) cot(angle/2))/s. Power series, to round-off for
/// angles up to pi.
struct RotationCoefficient {
  double value, slope;
};

namespace detail {
inline constexpr int terms = 15;
using Series = std::array<double, terms>;

constexpr Series inverse_factorials(int first) {  // (-1)^k/(2k+first)!
  Series series{};
  double factorial = 1.0;
  for (int i = 2; i <= first; ++i) factorial *= i;
  for (int k = 0; k < terms; ++k) {
    series[k] = (k % 2 == 0 ? 1.0 : -1.0) / factorial;
    factorial *= (2.0 * k + first + 1) * (2.0 * k + first + 2);
  }
  return series;
}
constexpr Series derivative(const Series& series) {
  Series result{};
  for (int k = 1; k < terms; ++k) result[k - 1] = k * series[k];
  return result;
}
constexpr Series combination() {  // (b - a/2)/s with a = sin/angle
  const Series b = inverse_factorials(2), a = inverse_factorials(1);
  Series result{};
  for (int k = 1; k < terms; ++k) result[k - 1] = b[k] - 0.5 * a[k];
  return result;
}
inline RotationCoefficient evaluate(const Series& series, double s) {
  double value = 0.0, slope = 0.0;
  for (int k = terms - 1; k >= 0; --k) {
    slope = slope * s + value;
    value = value * s + series[k];
  }
  return {value, slope};
}
inline constexpr Series series_b = inverse_factorials(2), series_c = inverse_factorials(3),
                        series_db = derivative(series_b), series_dc = derivative(series_c), series_n = combination();
}  // namespace detail

inline RotationCoefficient coefficient_b(double s) { return detail::evaluate(detail::series_b, s); }
inline RotationCoefficient coefficient_c(double s) { return detail::evaluate(detail::series_c, s); }
/// db/ds and dc/ds.
inline RotationCoefficient coefficient_db(double s) { return detail::evaluate(detail::series_db, s); }
inline RotationCoefficient coefficient_dc(double s) { return detail::evaluate(detail::series_dc, s); }
inline RotationCoefficient coefficient_e(double s) {
  const RotationCoefficient n = detail::evaluate(detail::series_n, s), b = coefficient_b(s);
  const double value = n.value / b.value;
  return {value, (n.slope - value * b.slope) / b.value};
}

/// T^-1(psi): change of the rotation vector per turn that follows it, log(exp(psi) exp(a)) = psi + T^-1 a + O(a^2).
inline Mat3 inverse_tangent_map(const Vec3& psi) {
  const Mat3 skew = hat(psi);
  return Mat3::Identity() + 0.5 * skew + coefficient_e(psi.squaredNorm()).value * skew * skew;
}

/// The coordinate axis most normal to a unit vector; of nearly equal ones the first.
inline Vec3 axis_across(const Vec3& tangent) {
  int smallest = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(tangent[k]) < std::abs(tangent[smallest]) - 1e-9) smallest = k;
  return Vec3::Unit(smallest);
}

/// The triad whose first axis is the unit vector `to`, reached from `triad` by the smallest rotation.
inline Quaternion turned_to(const Quaternion& triad, const Vec3& to) {
  return normalized(Quaternion::FromTwoVectors(triad * Vec3(1, 0, 0), to) * triad);
}

}  // namespace fbi::beam
