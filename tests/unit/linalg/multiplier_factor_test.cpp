/// The Woodbury factor against a dense inverse.
#include "linalg/multiplier_factor.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <random>

namespace fbi::linalg {
namespace {

struct Problem {
  MultiplierRows m;
  Eigen::MatrixXd dense_m, w, s;  // rows ordered (row, direction), columns (column, direction)
  std::vector<double> block, local;
  std::vector<InterfaceBlock> blocks;
};

/// Seven rows in two fibers: the first with a dense block, the second with a 3 x 3 matrix for each; one column without
/// weight in y.
Problem make_problem(double asymmetry) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(0.1, 1.0);
  Problem problem;
  const Index rows = 7, columns = 10, first_rows = 4;
  problem.dense_m = Eigen::MatrixXd::Zero(3 * rows, 3 * columns);
  problem.w = Eigen::MatrixXd::Zero(3 * columns, 3 * columns);
  problem.m.begin.push_back(0);
  for (Index p = 0; p < rows; ++p) {
    for (Index c = p; c < std::min<Index>(p + 4, columns); ++c) {
      problem.m.column.push_back(c);
      problem.m.value.push_back(uniform(random));
      for (int i = 0; i < 3; ++i) problem.dense_m(3 * p + i, 3 * c + i) = problem.m.value.back();
    }
    problem.m.begin.push_back(static_cast<Index>(problem.m.column.size()));
  }
  for (Index k = 0; k < 3 * columns; ++k) {
    problem.m.weight.push_back(k == 13 ? 0.0 : uniform(random));
    problem.w(k, k) = problem.m.weight.back();
  }
  const Index n = 3 * first_rows;
  Eigen::MatrixXd a = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return uniform(random); });
  Eigen::MatrixXd dense = a * a.transpose() + Eigen::MatrixXd::Identity(n, n);
  dense(0, 1) += asymmetry;
  problem.s = Eigen::MatrixXd::Zero(3 * rows, 3 * rows);
  problem.s.topLeftCorner(n, n) = dense;
  for (Index r = 0; r < n; ++r)
    for (Index c = 0; c < n; ++c) problem.block.push_back(dense(r, c));
  for (Index p = first_rows; p < rows; ++p) {
    const Mat3 root = Mat3::NullaryExpr([&] { return uniform(random); });
    const Mat3 law = p == first_rows ? Mat3(uniform(random) * Mat3::Identity()) : Mat3(root * root.transpose());
    problem.s.block<3, 3>(3 * p, 3 * p) = law;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) problem.local.push_back(law(i, j));
  }
  problem.blocks = {{0, first_rows, problem.block.data(), nullptr},
                    {first_rows, rows - first_rows, nullptr, problem.local.data()}};
  return problem;
}

double solve_error(const Problem& problem, const Eigen::MatrixXd& t) {
  MultiplierFactor factor;
  EXPECT_TRUE(factor.factorize(problem.m, problem.blocks));
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(t.rows(), -1.0, 2.0);
  std::vector<double> x(b.data(), b.data() + b.size());
  factor.solve(x.data());
  const Eigen::VectorXd reference = t.partialPivLu().solve(b);
  return (Eigen::Map<Eigen::VectorXd>(x.data(), b.size()) - reference).norm() / reference.norm();
}

TEST(MultiplierFactor, solves_with_s_plus_m_w_mt) {
  const Problem problem = make_problem(0.0);
  const Eigen::MatrixXd t = problem.s + problem.dense_m * problem.w * problem.dense_m.transpose();
  EXPECT_LT(solve_error(problem, t), 1e-12);
}

TEST(MultiplierFactor, gives_the_inverse_of_the_velocity_block) {
  Problem problem = make_problem(0.0);
  problem.m.weight[13] = problem.w(13, 13) = 0.7;  // all weights positive, so that W has an inverse
  MultiplierFactor factor;
  ASSERT_TRUE(factor.factorize(problem.m, problem.blocks));
  const Eigen::MatrixXd& m = problem.dense_m;
  const Eigen::MatrixXd block = Eigen::MatrixXd(problem.w.inverse()) + m.transpose() * problem.s.inverse() * m;
  const Eigen::VectorXd r = Eigen::VectorXd::LinSpaced(block.rows(), 1.0, -2.0);
  Eigen::VectorXd rows = m * problem.w * r;
  factor.solve(rows.data());
  const Eigen::VectorXd x = problem.w * r - problem.w * m.transpose() * rows;
  EXPECT_LT((block * x - r).norm() / r.norm(), 1e-12);
}

TEST(MultiplierFactor, keeps_an_unsymmetric_part_when_cholesky_cannot) {
  // Strongly indefinite symmetric part: CHOLMOD gives up and UMFPACK solves the matrix as it is.
  Problem problem = make_problem(0.0);
  for (Index k = 0; k < 9 * 3; ++k) problem.local[k] = k % 9 % 4 == 0 ? -20.0 : 0.0;
  for (Index p = 4; p < 7; ++p) problem.s.block<3, 3>(3 * p, 3 * p) = -20.0 * Mat3::Identity();
  problem.block[1] += 0.5;
  problem.s(0, 1) += 0.5;
  const Eigen::MatrixXd t = problem.s + problem.dense_m * problem.w * problem.dense_m.transpose();
  EXPECT_LT(solve_error(problem, t), 1e-11);
}

TEST(MultiplierFactor, refuses_what_is_not_finite) {
  Problem problem = make_problem(0.0);
  problem.block[5] = std::numeric_limits<double>::quiet_NaN();
  MultiplierFactor factor;
  EXPECT_FALSE(factor.factorize(problem.m, problem.blocks));
}

TEST(MultiplierFactor, works_on_a_rank_without_rows) {
  MultiplierRows empty;
  empty.begin.push_back(0);
  MultiplierFactor factor;
  EXPECT_TRUE(factor.factorize(empty, {}));
  factor.solve(nullptr);
}

/// Two equal rows on two ranks: with the sums of the other one each factor alone gives what both together give to forces
/// that they share.
TEST(MultiplierFactor, RowsOfOtherRanksCountOnTheDiagonal) {
  MultiplierRows both;
  both.begin = {0, 3, 6};
  both.column = {0, 1, 2, 0, 1, 2};
  both.value = {0.2, 0.5, 0.3, 0.2, 0.5, 0.3};
  both.weight = {1, 2, 3, 4, 5, 6, 7, 8, 9};
  MultiplierRows own = both;
  own.begin = {0, 3};
  own.column.resize(3);
  own.value.resize(3);
  own.others = {0.2, 0.5, 0.3};
  std::vector<double> law(18, 0.0);
  for (int k = 0; k < 18; k += 9)
    for (int i = 0; i < 3; ++i) law[k + 4 * i] = 0.01 * (i + 1);
  MultiplierFactor whole, part, alone;
  ASSERT_TRUE(whole.factorize(both, {{0, 2, nullptr, law.data()}}));
  ASSERT_TRUE(part.factorize(own, {{0, 1, nullptr, law.data()}}));
  own.others.clear();
  ASSERT_TRUE(alone.factorize(own, {{0, 1, nullptr, law.data()}}));
  std::vector<double> x = {1, -2, 3, 1, -2, 3}, y = {1, -2, 3}, z = {1, -2, 3};
  whole.solve(x.data());
  part.solve(y.data());
  alone.solve(z.data());
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(y[i], x[i], 1e-12 * std::abs(x[i]));
    EXPECT_GT(std::abs(z[i]), 1.9 * std::abs(x[i]));
  }
}

}  // namespace
}  // namespace fbi::linalg
