/// Fibers under weight and following forces: S-D1 frequencies under gravity, S-B6 Greenhill, S-B7 catenary, follower
/// forces (Beck's column, elastica of a following force).
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "convergence/momenta.hpp"
#include "record.hpp"

namespace fbi::beam {
namespace {

using test::formulas;
using test::order;

Eigen::MatrixXd mass_matrix(const mesh::FiberMesh& mesh) {
  const ElementFormulation& formulation = *element_formulation(Formulation::torsion_free);
  Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(6 * mesh.nodes(), 6 * mesh.nodes());
  ElementProperties element;
  element.mass_per_length = 1.0;
  for (Index e = 0; e < mesh.elements(); ++e) {
    element.length = mesh.element_length[e];
    Eigen::Matrix<double, 12, 12, Eigen::RowMajor> block;
    formulation.mass(element, block.data());
    mass.block<12, 12>(6 * e, 6 * e) += block;
  }
  return mass;
}

// Eigenvalues 1/omega^2 of K^-1 M of motions along y, K at the straight equilibrium of a cantilever along x with
// EI = rho A = L = 1 under the axial weight gamma and the axial follower force `push`.
Eigen::VectorXcd compliances(double gamma, double push, Index elements) {
  const mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, elements);
  FiberParameters group = test::stiffness(1e8, 1.0);
  group.start = EndCondition::clamped;
  if (push != 0.0) {
    Load load = test::load(LoadType::force, {-push, 0, 0});
    load.follower = true;
    group.loads = {load};
  }
  BeamTimeParameters time;
  time.scheme = TimeScheme::static_;
  BeamField field(mesh, {group}, time, {gamma, 0, 0});
  field.initialize({});
  field.begin_step(1.0, 1.0);
  EXPECT_GE(field.solve_step({}), 0);
  field.linearize();
  const Eigen::MatrixXd mass = mass_matrix(mesh);
  const Eigen::Index size = mass.rows(), across = size / 3;
  Eigen::MatrixXd inverse(across, across);
  for (Eigen::Index j = 0; j < across; ++j) {
    Eigen::VectorXd column = mass.col(3 * j + 1);
    field.solve(0, column.data());
    for (Eigen::Index i = 0; i < across; ++i) inverse(i, j) = column[3 * i + 1];
  }
  return inverse.eigenvalues();
}

std::vector<double> frequencies(double gamma, Index elements) {
  const Eigen::VectorXcd values = compliances(gamma, 0.0, elements);
  std::vector<double> omega;
  for (Eigen::Index i = 0; i < values.size(); ++i)
    if (values[i].real() > 1e-12) omega.push_back(1 / std::sqrt(values[i].real()));
  std::sort(omega.begin(), omega.end());
  return omega;
}

// ---------------------------------------------------------------------------------------------------------------- S-D1

TEST(HeavyCantilever, FrequenciesUnderGravity) {
  struct Row {
    double gamma;
    std::vector<double> omega;
  };
  const Row table[] = {{1, {3.73263, 22.22980, 61.89904}},
                       {10, {5.29179, 23.91200, 63.68155}},
                       {100, {12.86874, 36.50917, 78.98033}},
                       {-1, {3.28493, 21.83734, 61.49461}},
                       {-4, {2.46297}},
                       {-7, {1.15156}}};
  for (const Row& row : table) {
    const std::vector<double> coarse = frequencies(row.gamma, 6), middle = frequencies(row.gamma, 12),
                              fine = frequencies(row.gamma, 48);
    for (std::size_t mode = 0; mode < row.omega.size(); ++mode) {
      const double slope = order(std::abs(coarse[mode] - fine[mode]), std::abs(middle[mode] - fine[mode]));
      const double error = fine[mode] / row.omega[mode] - 1;
      std::printf("gamma %4g, mode %zu: omega %.6f, table %.5f, relative error %.1e, order %.2f\n", row.gamma, mode + 1,
                  fine[mode], row.omega[mode], error, slope);
      EXPECT_NEAR(fine[mode], row.omega[mode], 2e-5 * std::max(1.0, row.omega[mode]));
      EXPECT_GE(slope, 3.6);  // two parts of opposite sign, each of fourth order
      test::record({.section = "Fibers: dynamics",
                    .id = "S-D1",
                    .check = "cantilever under its weight, gamma " + std::to_string(static_cast<int>(row.gamma)) +
                             ", frequency " + std::to_string(mode + 1) + ", 48 elements",
                    .source = "Chebyshev collocation",
                    .reference = row.omega[mode],
                    .ours = fine[mode],
                    .order = slope,
                    .bar = "2e-5, order 3.6"});
    }
  }
}

// ---------------------------------------------------------------------------------------------------------------- S-B6

TEST(Greenhill, CriticalWeightOfAnUprightColumn) {
  // omega^2 of the lowest mode, negative beyond the critical weight: secant
  const auto lowest = [](double gamma, Index elements) {
    const Eigen::VectorXcd values = compliances(gamma, 0.0, elements);
    double largest = 0.0;
    for (Eigen::Index i = 0; i < values.size(); ++i)
      if (std::abs(values[i].real()) > std::abs(largest)) largest = values[i].real();
    return 1 / largest;
  };
  const double exact = 7.8373474389;
  std::vector<double> error;
  double critical = 0.0;
  for (const Index elements : {4, 8, 16}) {
    double a = -7.0, b = -7.5, fa = lowest(a, elements), fb = lowest(b, elements);
    for (int k = 0; k < 8 && std::abs(fb) > 1e-8 && fb != fa; ++k) {
      const double c = b - fb * (b - a) / (fb - fa);
      a = b;
      fa = fb;
      b = c;
      fb = lowest(b, elements);
    }
    critical = -b;
    error.push_back(std::abs(critical / exact - 1));
  }
  std::printf("Greenhill: q_cr %.8f (%.10f), errors %.1e %.1e %.1e, orders %.2f %.2f\n", critical, exact, error[0],
              error[1], error[2], order(error[0], error[1]), order(error[1], error[2]));
  EXPECT_LE(error[2], 2e-6);
  EXPECT_GE(order(error[0], error[1]), 3.7);
  test::record({.section = "Fibers: statics",
                .id = "S-B6",
                .check = "critical weight of an upright clamped column, q L^3/EI, 16 elements",
                .source = "Greenhill 1881",
                .reference = exact,
                .ours = critical,
                .order = order(error[0], error[1]),
                .bar = "2e-6, order 3.7"});
}

// ---------------------------------------------------------------------------------------------------------------- S-B7

TEST(Catenary, LimitOfAFiberWithoutBendingStiffness) {
  struct Row {
    double length, sag, pull;
  };
  for (const Row& row : {Row{1.2, 0.29234379760, 0.46954152313}, Row{2.0, 0.79638835586, 0.22964021508}}) {
    std::vector<double> error, pull_error;
    double sag = 0.0, pull = 0.0;
    for (const double bending : {1e-4, 1e-5, 1e-6}) {
      const mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, row.length, 40);
      FiberParameters group = test::stiffness(1e6, bending);
      group.start = EndCondition::pinned;
      Support end;
      end.at = End::end;
      end.motion = formulas(std::to_string(1 - row.length) + "*max(0,2*t-1)", "0", "0");
      group.supports = {end};
      group.loads = {test::load(LoadType::line, {0, -1, 0})};
      BeamTimeParameters time;
      time.scheme = TimeScheme::static_;
      time.max_iterations = 200;
      BeamField field(mesh, {group}, time, Vec3::Zero());
      field.initialize({});
      const int steps = 80;
      for (int n = 1; n <= steps; ++n) {
        field.begin_step(n / double(steps), 1.0 / steps);
        ASSERT_GE(field.solve_step({}), 0) << "step " << n;
        field.accept_step();
      }
      sag = -field.dofs()[6 * 20 + 1];
      const std::vector<double> r = field.reactions({});
      pull = -r[0];
      error.push_back(std::abs(sag / row.sag - 1));
      pull_error.push_back(std::abs(pull / row.pull - 1));
      EXPECT_NEAR(r[0] + r[6 * 40], 0.0, 1e-6);
      EXPECT_NEAR(r[1] + r[6 * 40 + 1], row.length, 1e-6);
    }
    std::printf(
        "catenary of length %.1f: sag %.8f, errors for EI/(w L^3) = 1e-4, 1e-5, 1e-6: %.1e %.1e %.1e; pull %.8f, "
        "errors %.1e %.1e %.1e\n",
        row.length, sag, error[0], error[1], error[2], pull, pull_error[0], pull_error[1], pull_error[2]);
    EXPECT_LE(error[2], 2e-4);
    EXPECT_LE(pull_error[2], 2e-3);
    EXPECT_LE(error[2], 0.4 * error[1]);
    for (const bool is_sag : {true, false})
      test::record({.section = "Fibers: statics",
                    .id = "S-B7",
                    .check = std::string("hanging fiber of length ") + (row.length < 1.5 ? "1.2" : "2.0") +
                             ", EI/(w L^3) = 1e-6, " + (is_sag ? "sag" : "horizontal reaction"),
                    .source = "catenary",
                    .reference = is_sag ? row.sag : row.pull,
                    .ours = is_sag ? sag : pull,
                    .bar = is_sag ? "2e-4, falling with EI" : "2e-3"});
  }
}

// ------------------------------------------------------------------------------------------------------- following
// forces

// Two frequencies meet at the critical axial force that follows the tip.
TEST(Follower, CriticalForceOfBecksColumn) {
  const auto flutters = [](double push, Index elements) {
    const Eigen::VectorXcd values = compliances(0.0, push, elements);
    double largest = 0.0, imaginary = 0.0;
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      largest = std::max(largest, std::abs(values[i]));
      imaginary = std::max(imaginary, std::abs(values[i].imag()));
    }
    return imaginary > 1e-7 * largest;
  };
  const double exact = 20.0509536;
  double critical = 0.0;
  for (const Index elements : {8, 16}) {
    double stable = 15, unstable = 25;
    for (int k = 0; k < 30; ++k) {
      const double middle = 0.5 * (stable + unstable);
      (flutters(middle, elements) ? unstable : stable) = middle;
    }
    critical = 0.5 * (stable + unstable);
    std::printf("Beck's column, %d elements: critical force %.6f, exact %.6f\n", elements, critical, exact);
  }
  EXPECT_NEAR(critical / exact, 1.0, 1e-5);
  test::record({.section = "Fibers: statics",
                .id = "",
                .check = "axial force that follows the tip of a cantilever: flutter load P L^2/EI, 16 elements",
                .source = "Beck 1952",
                .reference = exact,
                .ours = critical,
                .bar = "1e-5"});
}

// Transverse force that follows the tip. Seen from the tip the turn phi(sigma) at the distance sigma obeys
// phi'' = alpha cos(phi), phi(0) = phi'(0) = 0: an initial value problem.
Vec3 following_elastica(double alpha) {
  const int steps = 20000;
  const double h = 1.0 / steps;
  double y[4] = {0, 0, 0, 0};  // phi, phi', and the point seen from the tip frame
  const auto rate = [&](const double* s, double* d) {
    d[0] = s[1];
    d[1] = alpha * std::cos(s[0]);
    d[2] = std::cos(s[0]);
    d[3] = -std::sin(s[0]);
  };
  for (int n = 0; n < steps; ++n) {
    double k[4][4], at[4];
    rate(y, k[0]);
    for (int stage = 1; stage < 4; ++stage) {
      for (int i = 0; i < 4; ++i) at[i] = y[i] + (stage == 3 ? h : 0.5 * h) * k[stage - 1][i];
      rate(at, k[stage]);
    }
    for (int i = 0; i < 4; ++i) y[i] += h / 6 * (k[0][i] + 2 * k[1][i] + 2 * k[2][i] + k[3][i]);
  }
  // from the tip frame, whose first axis is the tip tangent, to that of the clamp: turned by phi(1)
  const double c = std::cos(y[0]), s = std::sin(y[0]);
  return {c * y[2] - s * y[3], s * y[2] + c * y[3], y[0]};
}

TEST(Follower, ElasticaOfAForceThatStaysNormal) {
  for (const double alpha : {2.0, 10.0, 30.0}) {
    const Vec3 exact = following_elastica(alpha);
    std::vector<double> error;
    for (const Index elements : {8, 16, 32}) {
      FiberParameters group = test::stiffness(1e8, 1.0);
      group.start = EndCondition::clamped;
      Load load = test::load(LoadType::force, {0, alpha, 0});
      load.follower = true;
      group.loads = {load};
      const test::StaticSolution s =
          test::solve_static(test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, elements), group, 30);
      ASSERT_TRUE(s.converged);
      error.push_back(std::hypot(s.tip()[0] - exact[0], s.tip()[1] - exact[1]));
    }
    std::printf("following force alpha %g: tip (%.6f, %.6f) turned by %.4f, errors %.1e %.1e %.1e, order %.2f\n", alpha,
                exact[0], exact[1], exact[2], error[0], error[1], error[2], order(error[1], error[2]));
    EXPECT_LE(error[2], 3e-5);
    EXPECT_GE(order(error[1], error[2]), 3.8);
    test::record({.section = "Fibers: statics",
                  .id = "",
                  .check = "transverse force that stays normal to the tip, F L^2/EI = " +
                           std::to_string(static_cast<int>(alpha)) + ", tip, 32 elements",
                  .source = "elastica as initial value problem",
                  .reference = 0.0,
                  .ours = error[2],
                  .order = order(error[1], error[2]),
                  .bar = "3e-5, order 3.8"});
  }
}

}  // namespace
}  // namespace fbi::beam
