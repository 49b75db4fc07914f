/// What the images of a point force in a periodic cube add to its velocity field (Hasimoto 1959), by Ewald's sums.
#pragma once

#include <cmath>
#include <numbers>

#include "base/types.hpp"

namespace fbi::test {

/// G_per(r) - G_free(r) times 8 pi mu, for a cube of side 1 around which the mean velocity is zero.
inline Mat3 image_velocity(const Vec3& r) {
  const double pi = std::numbers::pi, xi = std::sqrt(pi);
  Mat3 sum = Mat3::Zero();
  for (int i = -3; i <= 3; ++i)
    for (int j = -3; j <= 3; ++j)
      for (int k = -3; k <= 3; ++k) {
        const Vec3 x = r + Vec3(i, j, k);
        const double d = x.norm(), gauss = std::exp(-xi * xi * d * d);
        const bool self = i == 0 && j == 0 && k == 0;
        if (self && d < 1e-6) {
          sum -= 4 * xi / std::sqrt(pi) * Mat3::Identity();
        } else {
          const Mat3 shape = d * d * Mat3::Identity() + x * x.transpose();
          sum += 2 * (xi * gauss / (std::sqrt(pi) * d * d) + std::erfc(xi * d) / (2 * d * d * d)) * shape -
                 4 * xi / std::sqrt(pi) * gauss * Mat3::Identity();
          if (self) sum -= shape / (d * d * d);
        }
        if (self) continue;
        const Vec3 wave = 2 * pi * Vec3(i, j, k);
        const double q = wave.squaredNorm();
        sum += 8 * pi * (1 + q / (4 * xi * xi)) * std::exp(-q / (4 * xi * xi)) / (q * q) * std::cos(wave.dot(r)) *
               (q * Mat3::Identity() - wave * wave.transpose());
      }
  return sum;
}

/// Its mean over a straight fiber that carries a uniform force, along and across: 8 pi mu (1/F - 1/F_alone) for length
/// `length` along `direction`.
inline Mat3 image_velocity_of_fiber(double length, const Vec3& direction) {
  Mat3 sum = Mat3::Zero();
  constexpr int points = 64;  // midpoint rule
  for (int p = 0; p < points; ++p) {
    const double s = (p + 0.5) / points;
    sum += 2 * (1 - s) / points * image_velocity(s * length * direction);
  }
  return sum;
}

}  // namespace fbi::test
