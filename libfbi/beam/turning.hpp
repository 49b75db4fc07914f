/// Rotations of vectors: smallest rotations between directions, rotation matrices and vectors.
#pragma once

#include <Eigen/Geometry>

#include "base/types.hpp"

namespace fbi::beam {

inline Mat3 skew_matrix(const Vec3& a) {
  Mat3 m;
  m << 0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0;
  return m;
}

/// The smallest rotation that carries the unit vector a to the unit vector b, applied to v:
/// c v + (a x b) x v + (a x b) ((a x b).v)/(1 + c) with c = a.b; not a number for b = -a.
Vec3 turn(const Vec3& a, const Vec3& b, const Vec3& v);
/// Derivative of `turn` by b.
Mat3 turn_derivative(const Vec3& a, const Vec3& b, const Vec3& v);

/// Rotation matrix of the rotation vector psi (Rodrigues).
Mat3 rotation_matrix(const Vec3& psi);
/// Rotation vector of a rotation matrix, of length up to pi.
Vec3 rotation_vector(const Mat3& rotation);
/// Inverse of the tangent map: d psi = T^-1 theta where exp(psi + d psi) = exp(psi) exp(theta).
Mat3 right_tangent_inverse(const Vec3& psi);

}  // namespace fbi::beam
