// Pieces of the kernel against independent formulas: transformation, geometry, second derivatives, tau.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <functional>

#include "fem/hex8.hpp"
#include "fluid/hex8_kernel.hpp"
#include "fluid/stabilization.hpp"

namespace fbi::fluid::test {
namespace {

using Corners = Eigen::Matrix<double, 3, 8>;  // hex8 order

Corners skewed(int lane) {
  Corners x;
  for (int a = 0; a < 8; ++a)
    for (int i = 0; i < 3; ++i)
      x(i, a) = 0.5 * (1 + i * 0.3) * fem::hex8_corners[a][i] + 0.12 * std::sin(3.0 * a + 5 * i + lane);
  return x;
}

Corners box(int lane) {
  Corners x;
  for (int a = 0; a < 8; ++a)
    for (int i = 0; i < 3; ++i) x(i, a) = (0.3 + 0.1 * lane + 0.2 * i) * fem::hex8_corners[a][i] + lane;
  return x;
}

GeneralCells general_cells(const std::function<Corners(int)>& corners) {
  GeneralCells cells;
  for (int lane = 0; lane < 8; ++lane) {
    const Corners x = corners(lane);
    for (int i = 0; i < 3; ++i)
      for (int a = 0; a < 8; ++a) cells.modes[i][a].set(lane, x(i, corner_of_bits[a]));
  }
  for (int i = 0; i < 3; ++i) to_modes(cells.modes[i]);
  return cells;
}

Vec3 gauss_point(int q) { return gauss_scale * Vec3((q & 1) ? 1 : -1, (q & 2) ? 1 : -1, (q & 4) ? 1 : -1); }

// Physical gradient dv_i/dx_j by the plain formula.
Mat3 gradient(const Corners& x, const Corners& v, const Vec3& xi) {
  const Mat3 jacobian = x * fem::hex8_gradient(xi);
  return v * fem::hex8_gradient(xi) * jacobian.inverse();
}

// lap v + grad div v by central differences of the plain gradient, mapped back to x.
Vec3 viscous(const Corners& x, const Corners& v, const Vec3& xi) {
  const double step = 1e-5;
  const Mat3 inverse = (x * fem::hex8_gradient(xi)).inverse();  // dxi_k/dx_j
  Mat3 second[3];                                               // [k](i, j) = d/dx_k (dv_i/dx_j)
  for (Mat3& m : second) m.setZero();
  for (int d = 0; d < 3; ++d) {
    const Vec3 e = step * Vec3::Unit(d);
    const Mat3 difference = (gradient(x, v, xi + e) - gradient(x, v, xi - e)) / (2 * step);
    for (int k = 0; k < 3; ++k) second[k] += difference * inverse(d, k);
  }
  Vec3 result = Vec3::Zero();
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) result[i] += second[k](i, k) + second[i](k, k);
  return result;
}

template <class Geometry>
void check_point_state(const typename Geometry::Cells& cells, const std::function<Corners(int)>& corners) {
  Corners v[8];
  Batch f[4][8];
  for (int lane = 0; lane < 8; ++lane)
    for (int a = 0; a < 8; ++a) {
      for (int i = 0; i < 3; ++i) {
        v[lane](i, a) = std::cos(1.0 + 2 * a + 7 * i + lane);
        f[i][std::find(corner_of_bits.begin(), corner_of_bits.end(), a) - corner_of_bits.begin()].set(lane,
                                                                                                      v[lane](i, a));
      }
      f[3][a] = Batch(1.5);
    }
  const Geometry geometry(cells);
  const FieldAtPoints<true> field(f);
  for (int q = 0; q < 8; ++q) {
    const typename Geometry::At at(geometry, q);
    PointState<Batch> s;
    field.at(at, q, s);
    for (int lane = 0; lane < 8; ++lane) {
      const Corners x = corners(lane);
      const Vec3 xi = gauss_point(q);
      const std::array<double, 8> n = fem::hex8_shape(xi);
      const Vec3 value = v[lane] * Eigen::Map<const Eigen::Matrix<double, 8, 1>>(n.data());
      const Mat3 slope = gradient(x, v[lane], xi);
      const Vec3 second = viscous(x, v[lane], xi);
      EXPECT_NEAR(at.weight()[lane], (x * fem::hex8_gradient(xi)).determinant(), 1e-14);
      for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(s.velocity[i][lane], value[i], 1e-14);
        for (int j = 0; j < 3; ++j) EXPECT_NEAR(s.gradient[i][j][lane], slope(i, j), 1e-12);
        EXPECT_NEAR(s.viscous[i][lane], second[i], 1e-7 * (1 + second.norm()));
        EXPECT_NEAR(s.pressure_gradient[i][lane], 0.0, 1e-13);
      }
      EXPECT_NEAR(s.pressure[lane], 1.5, 1e-15);
    }
  }
}

TEST(FluidKernel, PointStateOfGeneralCellsIncludesTheHessianOfTheMap) {
  check_point_state<GeneralGeometry>(general_cells(skewed), skewed);
}

TEST(FluidKernel, PointStateOfBoxes) {
  BoxCells cells;
  for (int lane = 0; lane < 8; ++lane) {
    double volume = 1;
    for (int i = 0; i < 3; ++i) {
      const double h = 2 * (0.3 + 0.1 * lane + 0.2 * i);
      cells.scale[i].set(lane, 2 / (h * gauss_scale));
      volume *= h;
    }
    cells.weight.set(lane, volume / 8);
  }
  check_point_state<BoxGeometry>(cells, box);
  check_point_state<GeneralGeometry>(general_cells(box), box);
}

// v = (x y z, y z, x z) on the unit cube: div v = y z + z + x, grad div v = (1, z, y + 1), lap v = 0.
TEST(FluidKernel, ViscousResidualOfATrilinearFieldIsSymbolic) {
  Corners x;
  for (int a = 0; a < 8; ++a)
    for (int i = 0; i < 3; ++i) x(i, a) = 0.5 + 0.5 * fem::hex8_corners[a][i];
  const GeneralCells cells = general_cells([&](int) { return x; });
  Batch f[4][8];
  for (int b = 0; b < 8; ++b) {
    const Vec3 p = x.col(corner_of_bits[b]);
    f[0][b] = Batch(p[0] * p[1] * p[2]);
    f[1][b] = Batch(p[1] * p[2]);
    f[2][b] = Batch(p[0] * p[2]);
    f[3][b] = Batch(0.0);
  }
  const GeneralGeometry geometry(cells);
  const FieldAtPoints<true> field(f);
  for (int q = 0; q < 8; ++q) {
    PointState<Batch> s;
    field.at(GeneralGeometry::At(geometry, q), q, s);
    const Vec3 p = Vec3::Constant(0.5) + 0.5 * gauss_point(q);
    EXPECT_NEAR(s.viscous[0][0], 1.0, 1e-13);
    EXPECT_NEAR(s.viscous[1][3], p[2], 1e-13);
    EXPECT_NEAR(s.viscous[2][7], p[1] + 1, 1e-13);
  }
}

// The cell x = xi, y = eta, z = zeta (1 + a xi), xi, eta, zeta in [0,1], is no parallelepiped; f = zeta = z/(1 + a x)
// is trilinear on it and has f_xx = 2 a^2 z/(1 + a x)^3, f_xz = -a/(1 + a x)^2. With v = (A, B, C) f: lap v + grad div
// v = (2 A f_xx + C f_xz, B f_xx, C f_xx + A f_xz).
TEST(FluidKernel, ViscousResidualOnADistortedCellIsSymbolic) {
  const double slope = 0.7, factor[3] = {1.5, -2, 0.8};
  Corners x;
  for (int a = 0; a < 8; ++a) {
    for (int i = 0; i < 3; ++i) x(i, a) = 0.5 + 0.5 * fem::hex8_corners[a][i];
    x(2, a) *= 1 + slope * x(0, a);
  }
  const GeneralCells cells = general_cells([&](int) { return x; });
  Batch f[4][8];
  for (int b = 0; b < 8; ++b)
    for (int i = 0; i < 4; ++i)
      f[i][b] = Batch(i < 3 ? factor[i] * (0.5 + 0.5 * fem::hex8_corners[corner_of_bits[b]][2]) : 0.0);
  const GeneralGeometry geometry(cells);
  const FieldAtPoints<true> field(f);
  for (int q = 0; q < 8; ++q) {
    PointState<Batch> s;
    field.at(GeneralGeometry::At(geometry, q), q, s);
    const Vec3 p = Vec3::Constant(0.5) + 0.5 * gauss_point(q);
    const double stretch = 1 + slope * p[0];
    const double xx = 2 * slope * slope * p[2] / (stretch * stretch), xz = -slope / (stretch * stretch);
    EXPECT_NEAR(s.viscous[0][0], 2 * factor[0] * xx + factor[2] * xz, 1e-13);
    EXPECT_NEAR(s.viscous[1][3], factor[1] * xx, 1e-13);
    EXPECT_NEAR(s.viscous[2][7], factor[2] * xx + factor[0] * xz, 1e-13);
  }
}

// Integrals of a flux that is constant: out_a = w int N_a + F . int grad N_a, by the plain formula.
TEST(FluidKernel, FluxIntegralsMatchThePlainSum) {
  const GeneralCells cells = general_cells(skewed);
  const GeneralGeometry geometry(cells);
  FluxIntegral integral;
  double w[8][4], g[8][4][3];
  for (int q = 0; q < 8; ++q) {
    PointFlux<Batch> flux;
    for (int c = 0; c < 4; ++c) {
      w[q][c] = std::sin(1.0 + q + 8 * c);
      (c < 3 ? flux.w[c] : flux.q) = Batch(w[q][c]);
      for (int j = 0; j < 3; ++j) {
        g[q][c][j] = std::cos(2.0 * q + c - j);
        (c < 3 ? flux.grad_w[c][j] : flux.grad_q[j]) = Batch(g[q][c][j]);
      }
    }
    integral.set(GeneralGeometry::At(geometry, q), q, flux);
  }
  Batch out[4][8];
  integral.integrate(out);
  for (int lane = 0; lane < 8; ++lane) {
    const Corners x = skewed(lane);
    for (int b = 0; b < 8; ++b)
      for (int c = 0; c < 4; ++c) {
        const int a = corner_of_bits[b];
        double sum = 0;
        for (int q = 0; q < 8; ++q) {
          const Vec3 xi = gauss_point(q);
          const Mat3 jacobian = x * fem::hex8_gradient(xi);
          const Eigen::Matrix<double, 8, 3> slope = fem::hex8_gradient(xi) * jacobian.inverse();
          double value = w[q][c] * fem::hex8_shape(xi)[a];
          for (int j = 0; j < 3; ++j) value += g[q][c][j] * slope(a, j);
          sum += value * jacobian.determinant();
        }
        EXPECT_NEAR(out[c][b][lane], sum, 1e-13);
      }
  }
}

TEST(FluidKernel, GatherAndScatterAreTransposed) {
  double array[80], sum[80] = {};
  for (int k = 0; k < 80; ++k) array[k] = 3 * k + 1;
  const Index node[8] = {7, 2, 2, 19, 0, 11, 5, 3};
  Batch four[4];
  fem::gather_four(array, node, four);
  for (int lane = 0; lane < 8; ++lane)
    for (int c = 0; c < 4; ++c) EXPECT_EQ(four[c][lane], array[4 * node[lane] + c]);
  fem::scatter_add_four(four, node, 7, sum);  // the last lane is spare
  for (int n = 0; n < 20; ++n)
    for (int c = 0; c < 4; ++c) {
      const double times = n == 2 ? 2 : (n == 7 || n == 19 || n == 0 || n == 11 || n == 5) ? 1 : 0;
      EXPECT_EQ(sum[4 * n + c], times * array[4 * n + c]);
    }
}

TEST(FluidStabilization, LimitsOfFrancaValentin) {
  const double rho = 2, mu = 0.5, h = 0.1;
  // diffusion, no time term: h^2/(12 mu)
  EXPECT_DOUBLE_EQ(franca_valentin(rho, mu, 0, 0, h, h).pressure, h * h / (12 * mu));
  // slow time steps: both diffusive limits
  EXPECT_DOUBLE_EQ(franca_valentin(rho, mu, 1e-3, 0, h, h).pressure, h * h / (24 * mu));
  // small time steps: 1/(rho sigma) up to diffusion
  EXPECT_NEAR(franca_valentin(rho, mu, 1e9, 0, h, h).pressure * rho * 1e9, 1, 1e-6);
  // convection: h/(2 rho |v|), tau_C = rho |v| h/2
  const CellTau fast = franca_valentin(rho, 1e-9, 0, 3, h, 2 * h);
  EXPECT_NEAR(fast.convection, h / (2 * rho * 3), 1e-9);
  EXPECT_NEAR(fast.pressure, 2 * h / (2 * rho * 3), 1e-9);
  EXPECT_NEAR(fast.divergence, 0.5 * rho * 3 * 2 * h, 1e-9);
  // tau_C at low Reynolds number: rho |v| h Re2/2, Re2 = rho |v| h/(6 mu)
  const CellTau slow = franca_valentin(rho, mu, 0, 0.3, h, h);
  EXPECT_NEAR(slow.divergence, 0.5 * rho * 0.3 * h * (rho * 0.3 * h / (6 * mu)), 1e-15);
}

TEST(FluidStabilization, StreamlineLength) {
  const double k[9] = {2 / 0.1, 0, 0, 0, 2 / 0.2, 0, 0, 0, 2 / 0.4};  // a box 0.1 x 0.2 x 0.4
  const double x[3] = {1, 0, 0}, z[3] = {0, 0, 1}, d[3] = {0.6, 0, 0.8};
  EXPECT_DOUBLE_EQ(streamline_length(k, x), 0.1);
  EXPECT_DOUBLE_EQ(streamline_length(k, z), 0.4);
  double sum = 0;  // sum_a |d . grad N_a| with grad N_a = s_a/(4 h) at the center
  for (const auto& s : fem::hex8_corners) sum += std::abs(0.6 * s[0] / 0.4 + 0.8 * s[2] / 1.6);
  EXPECT_DOUBLE_EQ(streamline_length(k, d), 2 / sum);
}

}  // namespace
}  // namespace fbi::fluid::test
