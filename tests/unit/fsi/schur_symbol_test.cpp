// What the pressure's part of the preconditioner stands for, on a lattice of cubes in a uniform flow along x: the
// symbol of the Schur complement of the stabilised equations, written down from one-dimensional stencils. The numbers
// of docs/theory.md, "Why these parts of the pressure".
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>

#include "fluid/stabilization.hpp"

namespace fbi::test {
namespace {

using Complex = std::complex<double>;
using ComplexMatrix = Eigen::Matrix3cd;

/// Cells of size 1, density 1, speed 1: 1/dt = 1/CFL. `viscosity` is mu/(rho a h).
struct Lattice {
  double cfl = 1.0, viscosity = 6.4e-4;
};

/// One mode: masses, derivatives and Laplacian of the lattice, and the Schur complement S = tau K - D A^-1 G.
struct Mode {
  double mass = 0.0, laplacian = 0.0;
  Complex convection, schur;
};

Mode mode(const Lattice& lattice, const fluid::CellTau& tau, const std::array<double, 3>& angle) {
  const double sigma = 1.0 / lattice.cfl;
  double m[3], k[3];
  Complex c[3];
  for (int d = 0; d < 3; ++d) {
    m[d] = (2.0 + std::cos(angle[d])) / 3.0;
    k[d] = 2.0 - 2.0 * std::cos(angle[d]);
    c[d] = Complex(0.0, std::sin(angle[d]));
  }
  const double mass = m[0] * m[1] * m[2];
  // int N_a dN_b/dx_j, and int dN_a/dx_i dN_b/dx_j
  const auto derivative = [&](int j) { return c[j] * m[(j + 1) % 3] * m[(j + 2) % 3]; };
  const auto stiffness = [&](int i, int j) {
    return i == j ? Complex(k[i] * m[(i + 1) % 3] * m[(i + 2) % 3]) : -c[i] * c[j] * m[3 - i - j];
  };
  const double laplacian = (stiffness(0, 0) + stiffness(1, 1) + stiffness(2, 2)).real();
  ComplexMatrix momentum;
  Eigen::Vector3cd gradient, divergence;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) momentum(i, j) = tau.divergence * stiffness(i, j);
    momentum(i, i) += sigma * mass + derivative(0) + lattice.viscosity * laplacian +
                      tau.convection * (-sigma * derivative(0) + stiffness(0, 0));
    gradient[i] = derivative(i) + tau.convection * stiffness(0, i);
    divergence[i] = derivative(i) + tau.pressure * (-sigma * derivative(i) + stiffness(i, 0));
  }
  const Eigen::Vector3cd velocity = momentum.inverse() * gradient;
  Mode result;
  result.mass = mass;
  result.laplacian = laplacian;
  result.convection = derivative(0);
  result.schur = tau.pressure * laplacian - (divergence.transpose() * velocity)(0);
  return result;
}

struct Spread {
  double smallest = 1e300, largest = 0.0, angle = 0.0;
};

/// Eigenvalues of (sigma + convection C/M)/K + (viscous mu + grad_div tau_C)/M times S; lumped: M is 1 beside sigma
/// and K.
Spread spread(const Lattice& lattice, double convection, double grad_div, bool lumped, double viscous = 1.0) {
  const double sigma = 1.0 / lattice.cfl;
  const fluid::CellTau tau = fluid::franca_valentin(1.0, lattice.viscosity, sigma, 1.0, 1.0, 1.0);
  constexpr int n = 24;
  Spread result;
  for (int i = -n; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (int k = 0; k < n; ++k) {
        const auto angle = [](int number) { return (number + 0.5) / n * std::numbers::pi; };
        const Mode at = mode(lattice, tau, {angle(i), angle(j), angle(k)});
        const double mass = lumped ? 1.0 : at.mass;
        const Complex value = ((sigma + convection * at.convection / mass) / at.laplacian +
                               (viscous * lattice.viscosity + grad_div * tau.divergence) / mass) *
                              at.schur;
        result.smallest = std::min(result.smallest, std::abs(value));
        result.largest = std::max(result.largest, std::abs(value));
        result.angle = std::max(result.angle, std::abs(std::arg(value)));
      }
  std::printf("CFL %g, mu dt/(rho h^2) %.2g, convection %g, tau_C %g, mu %g%s: sizes %.3f to %.3f, angles to %.2f\n",
              lattice.cfl, lattice.cfl * lattice.viscosity, convection, grad_div, viscous, lumped ? ", lumped" : "",
              result.smallest, result.largest, result.angle);
  return result;
}

void expect(const Spread& found, double smallest, double largest, double angle) {
  EXPECT_NEAR(found.smallest, smallest, 0.01);
  EXPECT_NEAR(found.largest, largest, 0.01);
  EXPECT_NEAR(found.angle, angle, 0.01);
}

TEST(SchurSymbol, OfTimeStepAlone) {
  expect(spread({.cfl = 0.4}, 0.0, 0.0, false), 0.425, 0.998, 0.41);
  expect(spread({.cfl = 4.8}, 0.0, 0.0, false), 0.052, 0.930, 1.02);
}

TEST(SchurSymbol, WithConvectionAndGradDiv) {
  expect(spread({.cfl = 0.4}, 1.0, 0.4, false), 0.830, 1.981, 0.17);
  expect(spread({.cfl = 4.8}, 1.0, 0.4, false), 0.632, 2.828, 0.28);
}

// As it is used: what matters is that the sizes come together as the flow gets faster.
TEST(SchurSymbol, AsUsed) {
  for (const double cfl : {0.4, 1.0, 2.3, 4.8}) {
    const Spread before = spread({.cfl = cfl}, 0.0, 0.0, true), now = spread({.cfl = cfl}, 0.35, 0.85, true, 2.0);
    EXPECT_LT(now.largest / now.smallest, before.largest / before.smallest);
    EXPECT_LT(now.angle, before.angle);
  }
}

// Lumped masses are too large on short waves, also beside mu: twice mu brings the sizes together.
TEST(SchurSymbol, ViscousAsUsed) {
  for (const double number : {0.3, 1.0, 7.0}) {
    const Lattice lattice = {.cfl = 0.4, .viscosity = number / 0.4};
    const Spread once = spread(lattice, 0.35, 0.85, true, 1.0), twice = spread(lattice, 0.35, 0.85, true, 2.0);
    EXPECT_LT(twice.largest / twice.smallest, once.largest / once.smallest);
  }
}

}  // namespace
}  // namespace fbi::test
