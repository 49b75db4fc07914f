/// The Woodbury factor against a dense inverse.
#include "linalg/multiplier_factor.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>
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

/// Two equal rows on two ranks: with the sums of the other one each factor alone gives what both together give to
/// forces that they share.
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
    // Equal rows make T of both nearly singular: round-off is multiplied by its condition, (2 m W m^T + s)/s.
    const double law_i = law[4 * i];
    double coupling = 0.0;
    for (std::size_t c = 0; c < 3; ++c) coupling += both.value[c] * both.value[c] * both.weight[3 * c + i];
    const double round_off = (2 * coupling + law_i) / law_i * std::numeric_limits<double>::epsilon();
    EXPECT_NEAR(y[i], x[i], round_off * std::abs(x[i]));
    EXPECT_GT(std::abs(z[i]), 1.9 * std::abs(x[i]));
  }
}

/// Fibers of three rows each with dense blocks of S = `law` (1 + what couples them), side by side: rows at the same
/// height of neighbors share columns. The rows of every third fiber are numbered after all others (`scattered`).
struct Fibers {
  MultiplierRows m;
  std::vector<std::vector<double>> dense;
  std::vector<std::vector<Index>> index;
  std::vector<InterfaceBlock> blocks;
  Eigen::MatrixXd own, between;  // of T: within fibers, between them
  Fibers(Index fibers, double law, bool scattered) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(0.1, 1.0);
    const Index n = 3, rows = n * fibers, columns = (fibers + 2) * (n + 1);
    std::vector<Index> fiber_of(rows), number(rows);
    Index next = 0;
    for (const bool late : {false, true})
      for (Index f = 0; f < fibers; ++f)
        if ((scattered && f % 3 == 2) == late)
          for (Index i = 0; i < n; ++i) number[n * f + i] = next++;
    if (scattered) std::swap(number[0], number[rows - 1]);
    std::vector<std::vector<std::pair<Index, double>>> entries(rows);
    for (Index f = 0; f < fibers; ++f)
      for (Index i = 0; i < n; ++i) {
        fiber_of[number[n * f + i]] = f;
        for (Index x = f; x < f + 3; ++x)
          for (Index y = i; y < i + 2; ++y)
            entries[number[n * f + i]].emplace_back(x * (n + 1) + y, (x == f + 1 ? 2.0 : 1.0) * uniform(random));
      }
    m.begin.push_back(0);
    for (Index k = 0; k < 3 * columns; ++k) m.weight.push_back(k == 13 ? 0.0 : uniform(random));
    Eigen::MatrixXd dense_m = Eigen::MatrixXd::Zero(3 * rows, 3 * columns);
    for (Index p = 0; p < rows; ++p) {
      for (const auto& [c, value] : entries[p]) {
        m.column.push_back(c);
        m.value.push_back(value);
        for (int i = 0; i < 3; ++i) dense_m(3 * p + i, 3 * c + i) = value;
      }
      m.begin.push_back(static_cast<Index>(m.column.size()));
    }
    const Eigen::MatrixXd gram =
        dense_m * Eigen::Map<const Eigen::VectorXd>(m.weight.data(), 3 * columns).asDiagonal() * dense_m.transpose();
    own = between = Eigen::MatrixXd::Zero(3 * rows, 3 * rows);
    for (Index p = 0; p < rows; ++p)
      for (Index q = 0; q < rows; ++q)
        (fiber_of[p] == fiber_of[q] ? own : between).block<3, 3>(3 * p, 3 * q) = gram.block<3, 3>(3 * p, 3 * q);
    dense.resize(fibers);
    index.resize(fibers);
    for (Index f = 0; f < fibers; ++f) {
      const Eigen::MatrixXd a = Eigen::MatrixXd::NullaryExpr(3 * n, 3 * n, [&] { return uniform(random); });
      const Eigen::MatrixXd block = law * (0.05 * a * a.transpose() + Eigen::MatrixXd::Identity(3 * n, 3 * n));
      dense[f].assign(block.data(), block.data() + block.size());
      for (Index i = 0; i < n; ++i) index[f].push_back(number[n * f + i]);
      for (Index i = 0; i < n; ++i)
        for (Index j = 0; j < n; ++j)
          own.block<3, 3>(3 * index[f][i], 3 * index[f][j]) += block.block<3, 3>(3 * i, 3 * j);
      blocks.push_back({number[n * f], n, dense[f].data(), nullptr, scattered ? index[f].data() : nullptr});
    }
  }
  double relative(const std::vector<double>& x, const Eigen::VectorXd& reference) const {
    return (Eigen::Map<const Eigen::VectorXd>(x.data(), reference.size()) - reference).norm() / reference.norm();
  }
};

TEST(MultiplierBlocks, AreThreeStepsOfTheLumpedIteration) {
  for (const bool scattered : {false, true}) {
    const Fibers fibers(8, 0.3, scattered);
    ASSERT_TRUE(MultiplierBlocks::suits(fibers.m, fibers.blocks));
    const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(fibers.own.rows(), -1.0, 2.0);
    const Eigen::MatrixXd lumped = fibers.between.rowwise().sum().asDiagonal();
    const Eigen::PartialPivLU<Eigen::MatrixXd> d(fibers.own + lumped);
    Eigen::VectorXd y = d.solve(b);
    for (int step = 0; step < 2; ++step) y = d.solve(b + (lumped - fibers.between) * y).eval();
    MultiplierFactor factor;
    ASSERT_TRUE(factor.factorize(fibers.m, fibers.blocks));
    std::vector<double> x(b.data(), b.data() + b.size());
    factor.solve(x.data());
    EXPECT_LT(fibers.relative(x, y), 1e-6) << scattered;  // single precision between fibers
    x.assign(b.data(), b.data() + b.size());
    factor.precondition(x.data());
    EXPECT_LT(fibers.relative(x, d.solve(b)), 1e-12) << scattered;
    // The same T by sparse factors.
    ASSERT_TRUE(factor.factorize(fibers.m, fibers.blocks, MultiplierFactor::Use::exact));
    x.assign(b.data(), b.data() + b.size());
    factor.solve(x.data());
    const std::vector<double> solution = x;
    EXPECT_LT(fibers.relative(x, (fibers.own + fibers.between).partialPivLu().solve(b)), 1e-12) << scattered;
    x.assign(b.data(), b.data() + b.size());
    factor.precondition(x.data());
    EXPECT_EQ(x, solution);
  }
}

TEST(MultiplierBlocks, AreExactForCommonMotionAndCloseOtherwise) {
  // T y = b with y the same in all rows; then with what changes along the fibers and from one to the next.
  const Fibers fibers(12, 1e-3, false);
  const Index size = static_cast<Index>(fibers.own.rows());
  const Eigen::MatrixXd t = fibers.own + fibers.between;
  MultiplierFactor factor;
  ASSERT_TRUE(factor.factorize(fibers.m, fibers.blocks));
  const auto error = [&](const Eigen::VectorXd& y) {
    const Eigen::VectorXd b = t * y;
    std::vector<double> x(b.data(), b.data() + size);
    factor.solve(x.data());
    return fibers.relative(x, y);
  };
  EXPECT_LT(error(Eigen::VectorXd::Ones(size)), 1e-5);
  EXPECT_LT(error(Eigen::VectorXd::NullaryExpr(size, [](Index k) { return std::sin(0.01 * k) + 0.5; })), 0.02);
  // Neighbors against each other: not exact, but never further from it than doing nothing.
  EXPECT_LT(error(Eigen::VectorXd::NullaryExpr(size, [](Index k) { return k / 9 % 2 == 0 ? 1.0 : -1.0; })), 1.0);
}

TEST(MultiplierBlocks, OneFiberIsExact) {
  const Fibers fibers(1, 0.3, false);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(fibers.own.rows(), -1.0, 2.0);
  MultiplierFactor factor;
  ASSERT_TRUE(factor.factorize(fibers.m, fibers.blocks));
  std::vector<double> x(b.data(), b.data() + b.size());
  factor.solve(x.data());
  EXPECT_LT(fibers.relative(x, fibers.own.partialPivLu().solve(b)), 1e-12);
}

TEST(MultiplierBlocks, SuitMovingFibersAndPositiveEntriesOnly) {
  Fibers fibers(2, 0.3, false);
  EXPECT_TRUE(MultiplierBlocks::suits(fibers.m, fibers.blocks));
  fibers.m.value[3] = -1e-3;
  EXPECT_FALSE(MultiplierBlocks::suits(fibers.m, fibers.blocks));
  EXPECT_FALSE(MultiplierBlocks::suits(make_problem(0.0).m, make_problem(0.0).blocks));
}

}  // namespace
}  // namespace fbi::linalg
