// Rows of other ranks beside own ones: a chain of stiff fibers, each of which shares columns with the next.
#include "linalg/row_overlap.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <memory>
#include <random>

#include "linalg/multiplier_factor.hpp"
#include "mesh/exchange.hpp"

namespace fbi::linalg {
namespace {

constexpr Index fibers_of_rank = 3, rows_of_fiber = 3;

/// Fiber f has rows 3 f to 3 f + 2 with entries in columns 4 f to 4 f + 7; every second one has a dense block of S.
struct Chain {
  Comm comm;
  MultiplierRows own;
  std::vector<InterfaceBlock> blocks;
  std::vector<std::vector<double>> numbers;
  std::vector<GlobalIndex> begins;
  Eigen::MatrixXd t;  // of all rows of all ranks
  Index first_row = 0;
};

Chain make_chain(double stiffness) {
  Chain chain;
  const Index fibers = fibers_of_rank * chain.comm.size(), rows = rows_of_fiber * fibers, columns = 4 * fibers + 4;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0.1, 1.0);
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(rows, columns);
  Eigen::MatrixXd s = Eigen::MatrixXd::Zero(3 * rows, 3 * rows);
  Eigen::VectorXd w = Eigen::VectorXd::NullaryExpr(3 * columns, [&] { return uniform(random); });
  constexpr Index n = 3 * rows_of_fiber;
  std::vector<Eigen::MatrixXd> of_fiber;
  for (Index f = 0; f < fibers; ++f) {
    for (Index i = 0; i < rows_of_fiber; ++i)
      for (Index c = 4 * f; c < 4 * f + 8; ++c) m(rows_of_fiber * f + i, c) = uniform(random);
    Eigen::MatrixXd block = Eigen::MatrixXd::Zero(n, n);
    if (f % 2 == 0) {
      const Eigen::MatrixXd a = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return uniform(random); });
      block = stiffness * (a * a.transpose() + Eigen::MatrixXd::Identity(n, n));
    } else {
      for (Index k = 0; k < n; ++k) block(k, k) = stiffness * uniform(random);
    }
    s.block(n * f, n * f, n, n) = block;
    of_fiber.push_back(block);
  }
  Eigen::MatrixXd wide = Eigen::MatrixXd::Zero(3 * rows, 3 * columns);
  for (Index p = 0; p < rows; ++p)
    for (Index c = 0; c < columns; ++c)
      for (int i = 0; i < 3; ++i) wide(3 * p + i, 3 * c + i) = m(p, c);
  chain.t = s + wide * w.asDiagonal() * wide.transpose();

  const Index first_fiber = fibers_of_rank * chain.comm.rank(), last_fiber = first_fiber + fibers_of_rank;
  const Index first_column = 4 * first_fiber, last_column = 4 * last_fiber + 4;
  chain.first_row = rows_of_fiber * first_fiber;
  chain.own.begin.push_back(0);
  for (Index p = chain.first_row; p < rows_of_fiber * last_fiber; ++p) {
    for (Index c = first_column; c < last_column; ++c)
      if (m(p, c) != 0.0) {
        chain.own.column.push_back(c - first_column);
        chain.own.value.push_back(m(p, c));
      }
    chain.own.begin.push_back(static_cast<Index>(chain.own.column.size()));
  }
  for (Index c = first_column; c < last_column; ++c) {
    double others = m.col(c).sum();
    for (Index p = chain.first_row; p < rows_of_fiber * last_fiber; ++p) others -= m(p, c);
    chain.own.others.push_back(std::abs(others) < 1e-12 ? 0.0 : others);
    chain.own.name.push_back(c);
    for (int i = 0; i < 3; ++i) chain.own.weight.push_back(w[3 * c + i]);
  }
  for (Index f = first_fiber; f < last_fiber; ++f) {
    std::vector<double>& numbers = chain.numbers.emplace_back();
    const Eigen::MatrixXd& block = of_fiber[f];
    InterfaceBlock& b = chain.blocks.emplace_back();
    b.first = rows_of_fiber * (f - first_fiber);
    b.rows = rows_of_fiber;
    if (f % 2 == 0) {
      for (Index i = 0; i < n; ++i)
        for (Index j = 0; j < n; ++j) numbers.push_back(block(i, j));
    } else {
      for (Index p = 0; p < rows_of_fiber; ++p)
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) numbers.push_back(block(3 * p + i, 3 * p + j));
    }
  }
  for (std::size_t f = 0; f < chain.blocks.size(); ++f)
    ((first_fiber + static_cast<Index>(f)) % 2 == 0 ? chain.blocks[f].dense : chain.blocks[f].local) =
        chain.numbers[f].data();
  for (int r = 0; r <= chain.comm.size(); ++r) chain.begins.push_back(mesh::even_begin(columns, r, chain.comm.size()));
  return chain;
}

/// |b - T x| / |b| over the rows of all ranks, x from the solver given.
template <class Solve>
double residual(const Chain& chain, Solve solve) {
  const Eigen::Index size = chain.t.rows(), own = 3 * chain.own.rows(), first = 3 * chain.first_row;
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(size, -1.0, 2.0);
  std::vector<double> mine(b.data() + first, b.data() + first + own);
  solve(mine.data());
  std::vector<double> x(size, 0.0);
  std::copy(mine.begin(), mine.end(), x.begin() + first);
  chain.comm.sum(x.data(), static_cast<int>(size));
  return (b - chain.t * Eigen::Map<const Eigen::VectorXd>(x.data(), size)).norm() / b.norm();
}

TEST(RowOverlap, brings_every_row_that_own_ones_meet) {
  const Chain chain = make_chain(1e-3);
  RowOverlap overlap(chain.comm, chain.own, chain.blocks, chain.begins);
  const bool has_left = chain.comm.rank() > 0, has_right = chain.comm.rank() + 1 < chain.comm.size();
  const MultiplierRows& rows = overlap.rows();
  EXPECT_EQ(overlap.own_rows(), fibers_of_rank * rows_of_fiber);
  ASSERT_EQ(rows.rows(), rows_of_fiber * (fibers_of_rank + (has_left ? 1 : 0) + (has_right ? 1 : 0)));
  for (Index c = 0; c < chain.own.columns(); ++c) EXPECT_EQ(rows.others[c], 0.0);
  // T of these rows from what has arrived, and rows told apart by their first column.
  std::vector<Index> global;
  for (Index p = 0; p < rows.rows(); ++p) {
    GlobalIndex first = std::numeric_limits<GlobalIndex>::max();
    for (Index k = rows.begin[p]; k < rows.begin[p + 1]; ++k) first = std::min(first, rows.name[rows.column[k]]);
    const Index at = p < overlap.own_rows() ? p : p - overlap.own_rows();
    global.push_back(static_cast<Index>(first / 4) * rows_of_fiber + at % rows_of_fiber);
  }
  for (Index p = 0; p < overlap.own_rows(); ++p) EXPECT_EQ(global[p], chain.first_row + p);
  Eigen::MatrixXd t = Eigen::MatrixXd::Zero(3 * rows.rows(), 3 * rows.rows());
  for (Index p = 0; p < rows.rows(); ++p)
    for (Index q = 0; q < rows.rows(); ++q)
      for (Index k = rows.begin[p]; k < rows.begin[p + 1]; ++k)
        for (Index l = rows.begin[q]; l < rows.begin[q + 1]; ++l)
          if (rows.column[k] == rows.column[l])
            for (int i = 0; i < 3; ++i)
              t(3 * p + i, 3 * q + i) += rows.value[k] * rows.value[l] * rows.weight[3 * rows.column[k] + i];
  for (const InterfaceBlock& block : overlap.blocks())
    for (Index i = 0; i < 3 * block.rows; ++i)
      for (Index j = 0; j < 3 * block.rows; ++j)
        if (block.dense != nullptr) {
          t(3 * block.first + i, 3 * block.first + j) += block.dense[3 * block.rows * i + j];
        } else if (i / 3 == j / 3) {
          t(3 * block.first + i, 3 * block.first + j) += block.local[3 * i + j % 3];
        }
  for (Index p = 0; p < rows.rows(); ++p)
    for (Index q = 0; q < rows.rows(); ++q)
      EXPECT_NEAR((t.block<3, 3>(3 * p, 3 * q) - chain.t.block<3, 3>(3 * global[p], 3 * global[q])).norm(), 0.0, 1e-12);
  // Values of rows come from where the rows come from, also after rows are gone.
  std::vector<double> own;
  for (Index p = 0; p < overlap.own_rows(); ++p)
    for (int i = 0; i < 3; ++i) own.push_back(3.0 * (chain.first_row + p) + i);
  overlap.release();
  const std::vector<double>& all = overlap.bring(own.data());
  ASSERT_EQ(all.size(), 3 * global.size());
  for (std::size_t k = 0; k < all.size(); ++k) EXPECT_EQ(all[k], 3.0 * global[k / 3] + static_cast<double>(k % 3));
}

TEST(RowOverlap, factors_solve_for_the_rows_of_all_ranks) {
  const Chain chain = make_chain(1e-5);
  MultiplierFactor factor;
  ASSERT_TRUE(factor.factorize(std::make_unique<RowOverlap>(chain.comm, chain.own, chain.blocks, chain.begins)));
  const double with = residual(chain, [&](double* b) { factor.solve(b); });
  EXPECT_LT(with, 1.01e-3);
  std::vector<double> zero(3 * static_cast<std::size_t>(chain.own.rows()), 0.0);
  factor.solve(zero.data());
  for (const double value : zero) EXPECT_EQ(value, 0.0);
  // What sums of the rows of other ranks are worth here.
  MultiplierFactor alone;
  ASSERT_TRUE(alone.factorize(chain.own, chain.blocks, MultiplierFactor::Use::exact));
  const double without = residual(chain, [&](double* b) { alone.solve(b); });
  if (chain.comm.rank() == 0)
    std::printf("residual of the factors: %.2e with rows of other ranks, %.2e with sums of them\n", with, without);
  if (chain.comm.size() > 1) {
    EXPECT_GT(without, 0.05);
  }
}

TEST(RowOverlap, numbers_that_are_not_finite_come_through) {
  const Chain chain = make_chain(1e-3);
  MultiplierFactor factor;
  ASSERT_TRUE(factor.factorize(std::make_unique<RowOverlap>(chain.comm, chain.own, chain.blocks, chain.begins)));
  std::vector<double> b(3 * static_cast<std::size_t>(chain.own.rows()), 1.0);
  if (chain.comm.rank() == 0) b[4] = std::numeric_limits<double>::quiet_NaN();
  factor.solve(b.data());
  for (const double value : b) EXPECT_FALSE(std::isfinite(value));
}

TEST(RowOverlap, large_dense_blocks_stay_where_they_are) {
  const Comm comm;
  constexpr Index rows = 257;
  MultiplierRows own;
  own.begin.push_back(0);
  for (Index p = 0; p < rows; ++p) {
    own.column.push_back(0);
    own.value.push_back(1.0);
    own.begin.push_back(p + 1);
  }
  own.weight.assign(3, 1.0);
  own.others.assign(1, static_cast<double>(rows) * (comm.size() - 1));
  own.name.assign(1, 0);
  std::vector<GlobalIndex> begins(static_cast<std::size_t>(comm.size()) + 1, 1);
  begins[0] = 0;
  const std::vector<double> dense(9 * static_cast<std::size_t>(rows) * rows, 1.0);
  const RowOverlap stays(comm, own, {{0, rows, dense.data(), nullptr}}, begins);
  EXPECT_EQ(stays.rows().rows(), rows);
  EXPECT_EQ(stays.rows().others[0], own.others[0]);
  // Those of fixed fibers are small.
  const std::vector<double> law(9 * static_cast<std::size_t>(rows), 1.0);
  const RowOverlap goes(comm, own, {{0, rows, nullptr, law.data()}}, begins);
  EXPECT_EQ(goes.rows().rows(), rows * comm.size());
  EXPECT_EQ(goes.rows().others[0], 0.0);
}

}  // namespace
}  // namespace fbi::linalg
