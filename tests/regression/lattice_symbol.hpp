/// What a line force along z does to the discrete fluid on a periodic lattice of N x N square cells, mode by mode:
/// bilinear velocity and pressure with PSPG, written down from the one-dimensional stencils. It shares nothing with the
/// solver and gives the reference numbers of the tests on the radius that the mesh gives a fiber.
#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "base/types.hpp"

namespace fbi::test {

/// Cells of size 1 and viscosity 1; velocities in units of force per length over viscosity.
struct Lattice {
  int cells = 32;                   ///< N
  double position[2] = {0.0, 0.0};  ///< of the fiber in its cell, x being the direction of a transverse force
  double tau = 1.0 / 12.0;          ///< tau_M mu/h^2
  double tau_c = 0.0;               ///< tau_C/mu
  bool viscous_residual = false;    ///< mixed second derivatives in the residual of PSPG
  double sigma = 0.0;               ///< rho h^2/(mu dt): implicit Euler from rest
  bool inertia_in_residual = true;  ///< rho dv/dt in the residual of PSPG
  bool projection = false;          ///< pressure projection instead of PSPG
};

/// Mean over the modes k != 0 of the velocity that a unit force per length causes at its own place (all modes when
/// there is inertia): {along x, along z}.
inline std::array<double, 2> lattice_velocity(const Lattice& l) {
  using Complex = std::complex<double>;
  const int n = l.cells;
  const Complex i(0.0, 1.0);
  double across = 0.0, along = 0.0;
  for (int a = 0; a < n; ++a)
    for (int b = 0; b < n; ++b) {
      if (a == 0 && b == 0 && l.sigma == 0.0) continue;
      const double angle[2] = {2 * std::numbers::pi * a / n, 2 * std::numbers::pi * b / n};
      double m[2], k[2], s[2], weight = 1.0;  // mass, stiffness, i * derivative; |shape functions at the fiber|^2
      for (int d = 0; d < 2; ++d) {
        m[d] = (2 + std::cos(angle[d])) / 3;
        k[d] = 2 - 2 * std::cos(angle[d]);
        s[d] = std::sin(angle[d]);
        const double x = l.position[d];
        weight *= (1 - x) * (1 - x) + x * x + 2 * x * (1 - x) * std::cos(angle[d]);
      }
      const double mass = l.sigma * m[0] * m[1], laplacian = k[0] * m[1] + m[0] * k[1];
      along += weight / (mass + laplacian);
      const double shear = (1 + l.tau_c) * s[0] * s[1];
      const double a11 = mass + laplacian + (1 + l.tau_c) * k[0] * m[1],
                   a22 = mass + laplacian + (1 + l.tau_c) * k[1] * m[0];
      const Complex g1 = i * s[0] * m[1], g2 = i * s[1] * m[0];  // -(div w, p) as well as (q, div v)
      Complex d1 = g1, d2 = g2;
      if (l.inertia_in_residual) d1 -= l.tau * l.sigma * g1, d2 -= l.tau * l.sigma * g2;
      if (l.viscous_residual) d1 -= l.tau * i * s[0] * k[1], d2 -= l.tau * i * s[1] * k[0];
      double c = l.tau * laplacian;
      if (l.projection) {  // (q - mean, p - mean)
        d1 = g1, d2 = g2;
        c = m[0] * m[1] - 0.25 * (1 + std::cos(angle[0])) * (1 + std::cos(angle[1]));
      }
      if (a == 0 && b == 0) {
        across += weight / mass;
        continue;
      }
      // Pressure p = -(d.v)/c, then the first component of the inverse of A - g d^T/c.
      const Complex b11 = a11 - g1 * d1 / c, b12 = shear - g1 * d2 / c, b21 = shear - g2 * d1 / c,
                    b22 = a22 - g2 * d2 / c;
      across += weight * (b22 / (b11 * b22 - b12 * b21)).real();
    }
  return {across / (n * n), along / (n * n)};
}

/// Velocity along z that a unit force per length along z causes at its own place, on the axis of a square duct of N x N
/// cells with walls at rest (viscosity 1): sums of sines.
inline double duct_velocity(int n) {
  double sum = 0.0;
  for (int a = 1; a < n; ++a)
    for (int b = 1; b < n; ++b) {
      double shape = 2.0 / n, m[2], k[2];
      const int mode[2] = {a, b};
      for (int d = 0; d < 2; ++d) {
        const double angle = std::numbers::pi * mode[d] / n;
        m[d] = (2 + std::cos(angle)) / 3;
        k[d] = 2 - 2 * std::cos(angle);
        const double below = std::sin(angle * (n / 2)), above = std::sin(angle * ((n + 1) / 2));
        shape *= 0.5 * (below + above);
      }
      sum += shape * shape / (k[0] * m[1] + m[0] * k[1]);
    }
  return sum;
}

/// Velocity that a uniform unit force per length along (1,1,0) causes at its own place in a periodic cube of n^3 cells
/// of size 1, force and velocity spread over a ring of radius 1/2 with 8 points; the line lies at height z over the
/// nodes. Trilinear functions and PSPG with tau_M mu/h^2 = 1/12.
inline Mat3 oblique_ring_velocity(int n, double z) {
  using Complex = std::complex<double>;
  constexpr int along = 60, around = 8;
  const double pi = std::numbers::pi, half = std::numbers::sqrt2 / 2;
  std::vector<Vec3> points;  // one period of the line
  for (int s = 0; s < along; ++s)
    for (int q = 0; q < around; ++q) {
      const double angle = 2 * pi * (q + 0.5) / around, x = (s + 0.5) / along;
      points.push_back(Vec3(x, x, z) +
                       0.5 * (std::cos(angle) * Vec3(half, -half, 0) + std::sin(angle) * Vec3::UnitZ()));
    }
  Mat3 sum = Mat3::Zero();
  for (int a = 0; a < n; ++a)
    for (int c = 0; c < n; ++c) {
      const int mode[3] = {a, (n - a) % n, c};  // those that are constant along the line
      if (a == 0 && c == 0) continue;
      Vec3 angle, m, k, s;
      for (int d = 0; d < 3; ++d) {
        angle[d] = 2 * pi * mode[d] / n;
        m[d] = (2 + std::cos(angle[d])) / 3;
        k[d] = 2 - 2 * std::cos(angle[d]);
        s[d] = std::sin(angle[d]);
      }
      Complex weight = 0.0;
      for (const Vec3& point : points) {
        Complex shape = 1.0;
        for (int d = 0; d < 3; ++d) {
          const double cell = std::floor(point[d]), x = point[d] - cell;
          shape *= std::polar(1.0, -angle[d] * cell) * ((1 - x) + x * std::polar(1.0, -angle[d]));
        }
        weight += shape / static_cast<double>(points.size());
      }
      const Vec3 stiffness(k[0] * m[1] * m[2], m[0] * k[1] * m[2], m[0] * m[1] * k[2]);
      const Vec3 slope(s[0] * m[1] * m[2], m[0] * s[1] * m[2], m[0] * m[1] * s[2]);
      Mat3 matrix = slope * slope.transpose() * 12 / stiffness.sum();
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          matrix(i, j) += i == j ? stiffness.sum() + stiffness[i] : s[i] * s[j] * m[3 - i - j];
      sum += std::norm(weight) * matrix.inverse();
    }
  return sum * std::numbers::sqrt2 / (n * n);
}

/// Radius over h of a fiber held in a square array of side N h, from ln(N h/a) = 4 pi mu U/F + 1.3105329259 (Hasimoto
/// 1959), U being the mean velocity.
inline double lattice_radius(const Lattice& l) {
  return l.cells * std::exp(-4 * std::numbers::pi * lattice_velocity(l)[0] - 1.3105329259);
}

}  // namespace fbi::test
