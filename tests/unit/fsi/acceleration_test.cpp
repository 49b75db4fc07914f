/// The schemes of the partitioned loop on maps whose behaviour is known: x = A x + b with vectors spread over the
/// ranks.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

#include "fsi/aitken.hpp"
#include "fsi/constant_relaxation.hpp"
#include "fsi/iqn_ils.hpp"
#include "fsi/newton_krylov.hpp"

namespace fbi::fsi {
namespace {

using Vector = std::vector<double>;

/// H(x) = A x + b of dimension n; entry i lives on rank i mod size, the last rank may have none.
struct LinearMap {
  Comm comm;
  Eigen::MatrixXd a;
  Eigen::VectorXd b;

  explicit LinearMap(int n) : a(n, n), b(n) {
    for (int i = 0; i < n; ++i) {
      b[i] = std::cos(3.0 * i);
      for (int j = 0; j < n; ++j) a(i, j) = std::sin(1.0 + 7 * i + 3 * j * j) - (i == j ? 4.0 : 0.0);
    }
  }
  bool is_mine(int i) const { return i % comm.size() == comm.rank(); }
  Vector local(const Eigen::VectorXd& all) const {
    Vector mine;
    for (int i = 0; i < all.size(); ++i)
      if (is_mine(i)) mine.push_back(all[i]);
    return mine;
  }
  Eigen::VectorXd global(const Vector& mine) const {
    Eigen::VectorXd all = Eigen::VectorXd::Zero(b.size());
    std::size_t k = 0;
    for (int i = 0; i < all.size(); ++i)
      if (is_mine(i)) all[i] = mine[k++];
    comm.sum(all.data(), static_cast<int>(all.size()));
    return all;
  }
  Vector operator()(const Vector& x) const { return local(a * global(x) + b); }
  Eigen::VectorXd solution() const {
    return (Eigen::MatrixXd::Identity(a.rows(), a.cols()) - a).partialPivLu().solve(b);
  }
};

/// Iterates until |r| <= tolerance |r_0|; returns the evaluations of H, those of differences included.
int solve(Acceleration& scheme, const LinearMap& map, Vector& x, double tolerance, int most = 200) {
  int evaluations = 0;
  double first = 0.0;
  const NearbyMap nearby = [&](const Vector& at, Vector& h) {
    ++evaluations;
    h = map(at);
    return true;
  };
  scheme.begin_step();
  for (int k = 0; k < most; ++k) {
    ++evaluations;
    const Vector h = map(x);
    Vector r(x.size());
    for (std::size_t i = 0; i < x.size(); ++i) r[i] = h[i] - x[i];
    const double norm = std::sqrt(dot(map.comm, r, r));
    if (k == 0) first = norm;
    if (norm <= tolerance * first) return evaluations;
    EXPECT_TRUE(scheme.advance(x, r, nearby));
  }
  return most;
}

Vector zeros(const LinearMap& map) { return map.local(Eigen::VectorXd::Zero(map.b.size())); }

double error_of(const LinearMap& map, const Vector& x) {
  const Eigen::VectorXd exact = map.solution();
  return (map.global(x) - exact).norm() / exact.norm();
}

TEST(Acceleration, ConstantRelaxationShrinksByTheKnownFactor) {
  LinearMap map(4);
  map.a = -3.0 * Eigen::MatrixXd::Identity(4, 4);
  ConstantRelaxation scheme(0.2);  // 1 - 0.2 (1 + 3) = 0.2 an iteration
  Vector x = zeros(map);
  EXPECT_EQ(solve(scheme, map, x, 1.0001 * std::pow(0.2, 6)), 7);
  EXPECT_EQ(scheme.relaxation(), 0.2);
}

TEST(Acceleration, AitkenIsExactForOneEigenvalue) {
  LinearMap map(5);
  map.a = -9.0 * Eigen::MatrixXd::Identity(5, 5);
  Aitken scheme(map.comm, 0.5);  // diverges with this factor alone: 1 - 0.5 * 10 = -4
  Vector x = zeros(map);
  EXPECT_EQ(solve(scheme, map, x, 1e-13), 3);
  EXPECT_NEAR(scheme.relaxation(), 0.1, 1e-15);
  EXPECT_LE(error_of(map, x), 1e-14);
}

TEST(Acceleration, NewtonKrylovNeedsOneEvaluationForEachDimension) {
  const int n = 7;
  const LinearMap map(n);
  NewtonKrylov scheme(map.comm, 1e-3, 1e-12, 50);
  Vector x = zeros(map);
  EXPECT_LE(solve(scheme, map, x, 1e-10), n + 2);  // the last one finds out
  EXPECT_LE(scheme.krylov_iterations(), n);
  EXPECT_LE(error_of(map, x), 1e-10);
}

TEST(Acceleration, NewtonKrylovStepIsThatOfEquation17) {
  const LinearMap map(3);
  const double gamma = 0.01;
  NewtonKrylov scheme(map.comm, gamma, 1e-12, 1);
  Vector x = map.local(Eigen::Vector3d(1.0, 2.0, -2.0)), r(x.size());
  const Vector h = map(x);
  for (std::size_t i = 0; i < x.size(); ++i) r[i] = h[i] - x[i];
  const double size = std::sqrt(dot(map.comm, r, r));
  scheme.advance(x, r, [&](const Vector& at, Vector& value) {
    Vector moved = map.local(Eigen::Vector3d(1.0, 2.0, -2.0));
    for (std::size_t i = 0; i < moved.size(); ++i) {  // y = -r/|r| is the first vector of the Krylov space
      const double delta = gamma * (gamma + 3.0);
      EXPECT_NEAR(at[i], moved[i] - delta * r[i] / size, 1e-15);
    }
    value = map(at);
    return true;
  });
}

TEST(Acceleration, NewtonKrylovReportsWhatCannotBeEvaluated) {
  const LinearMap map(3);
  NewtonKrylov scheme(map.comm, 1e-3, 1e-6, 5);
  Vector x = zeros(map);
  const Vector r = map.local(Eigen::Vector3d(1, 2, 3)), before = x;
  EXPECT_FALSE(scheme.advance(x, r, [](const Vector&, Vector&) { return false; }));
  EXPECT_EQ(x, before);
}

TEST(Acceleration, GmresOfASingularMatrix) {
  const Comm comm;
  Vector x;
  const InterfaceSolve zero = interface_gmres(
      comm, [](const Vector& y, Vector& out) { return out = y, true; }, Vector(2, 0.0), 1e-8, 5, x);
  EXPECT_EQ(zero.iterations, 0);
  EXPECT_EQ(x, Vector(2, 0.0));
  const InterfaceSolve nothing = interface_gmres(
      comm, [](const Vector& y, Vector& out) { return out.assign(y.size(), 0.0), true; }, Vector(2, 1.0), 1e-8, 5, x);
  EXPECT_TRUE(nothing.evaluated);
  EXPECT_EQ(x, Vector(2, 0.0));
}

TEST(Acceleration, IqnNeedsOneEvaluationForEachDimension) {
  const int n = 7;
  const LinearMap map(n);
  IqnIls scheme(map.comm, 0.1, 0, 1e-10);
  Vector x = zeros(map);
  EXPECT_LE(solve(scheme, map, x, 1e-8), n + 2);
  EXPECT_LE(error_of(map, x), 1e-7);
  EXPECT_LE(scheme.columns(), static_cast<std::size_t>(n));
}

TEST(Acceleration, IqnWithColumnsOfTheStepBeforeNeedsTwo) {
  LinearMap map(5);
  IqnIls scheme(map.comm, 0.1, 3, 1e-10), forgetful(map.comm, 0.1, 0, 1e-10);
  Vector x = zeros(map), y = x;
  solve(scheme, map, x, 1e-9);
  solve(forgetful, map, y, 1e-9);
  map.b *= -2.0;
  EXPECT_EQ(solve(scheme, map, x, 1e-6), 2);
  EXPECT_GT(solve(forgetful, map, y, 1e-6), 4);
  for (int step = 0; step < 4; ++step) scheme.begin_step();
  EXPECT_EQ(scheme.columns(), 0u);
}

TEST(Acceleration, IqnDropsWhatIsNotIndependent) {
  LinearMap map(6);
  map.a = Eigen::MatrixXd::Zero(6, 6);
  map.a(0, 0) = -5.0;
  map.a(1, 1) = -2.0;  // the residual lives in two dimensions after one full step
  IqnIls scheme(map.comm, 1.0, 5, 1e-6);
  Vector x = zeros(map);
  for (int step = 0; step < 4; ++step) {
    map.b *= 1.5;
    solve(scheme, map, x, 1e-9, 20);
    EXPECT_LE(scheme.columns(), 6u);
  }
  EXPECT_LE(error_of(map, x), 1e-8);
}

TEST(Acceleration, IqnGoesOnBitwiseFromItsHistory) {
  LinearMap map(6);
  IqnIls scheme(map.comm, 0.1, 4, 1e-3), restarted(map.comm, 0.1, 4, 1e-3);
  Vector x = zeros(map);
  solve(scheme, map, x, 1e-3);
  map.b *= 1.1;
  solve(scheme, map, x, 1e-3);
  restarted.set_history(scheme.history());
  const auto from = scheme.state(), to = restarted.state();
  ASSERT_EQ(from.size(), to.size());
  EXPECT_GT(from.size(), 0u);
  for (std::size_t k = 0; k < from.size(); ++k) {
    EXPECT_EQ(from[k].first, to[k].first);
    *to[k].second = *from[k].second;
  }
  Vector y = x;
  map.b *= 1.3;
  EXPECT_EQ(solve(scheme, map, x, 1e-6), solve(restarted, map, y, 1e-6));
  EXPECT_EQ(x, y);
  EXPECT_EQ(scheme.history(), restarted.history());
}

}  // namespace
}  // namespace fbi::fsi
