// Flexible GMRES in single precision on a system that is spread over the ranks.
#include "linalg/single_gmres.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace fbi::linalg::test {
namespace {

/// A rank's part of diag(1 ... n) + 1/2 u u^T with |u| = 1, and its solution for b = A (1, 1, ...).
struct Spread {
  Comm comm{MPI_COMM_WORLD};
  std::size_t size = 50;
  double total = 50.0 * comm.size();

  double u() const { return 1.0 / std::sqrt(total); }
  double diagonal(std::size_t k) const { return 1.0 + static_cast<double>(k) + 50.0 * comm.rank(); }
  void multiply(const float* x, float* y) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < size; ++k) sum += u() * x[k];
    sum = comm.sum(sum);
    for (std::size_t k = 0; k < size; ++k) y[k] = static_cast<float>(diagonal(k) * x[k] + 0.5 * u() * sum);
  }
  /// Half of the diagonal's inverse as preconditioner: the factor must not matter.
  SingleGmres solver(int restart) {
    return SingleGmres(
        comm, size, size + 3,
        [this](const float* v, float factor, float* z, float* w) {
          for (std::size_t k = 0; k < size; ++k)
            z[k] = static_cast<float>(0.5 * factor * v[k] / std::sqrt(diagonal(k)));
          multiply(z, w);
        },
        restart);
  }
};

TEST(SingleGmres, SolvesToItsToleranceWithAndWithoutRestarts) {
  Spread problem;
  const std::vector<float> ones(problem.size, 1.0f);
  for (const int restart : {60, 8}) {
    SingleGmres solver = problem.solver(restart);
    for (const double size : {1.0, 1e-30}) {  // far from the range of floats: b is scaled
      std::vector<float> b(problem.size), x(problem.size), product(problem.size), right;
      problem.multiply(ones.data(), b.data());
      for (float& value : b) value = static_cast<float>(value * size);
      right = b;
      const KrylovResult result = solver.solve(b.data(), x.data(), 1e-5, 400);
      EXPECT_TRUE(result.converged);
      if (restart == 8) {
        EXPECT_GT(result.iterations, 8);
      }
      problem.multiply(x.data(), product.data());
      double sums[2] = {0, 0};
      for (std::size_t k = 0; k < problem.size; ++k) {
        sums[0] += std::pow((product[k] - right[k]) / size, 2);
        sums[1] += std::pow(right[k] / size, 2);
      }
      problem.comm.sum(sums, 2);
      EXPECT_LT(std::sqrt(sums[0] / sums[1]), 1.2e-5);
      EXPECT_NEAR(std::sqrt(sums[0] / sums[1]), result.relative_residual, 3e-6);
    }
  }
}

TEST(SingleGmres, BoundsZeroAndNumbersThatAreNone) {
  Spread problem;
  SingleGmres solver = problem.solver(10);
  std::vector<float> b(problem.size, 0.0f), x(problem.size, 1.0f);
  EXPECT_TRUE(solver.solve(b.data(), x.data(), 1e-5, 10).converged);
  for (const float value : x) EXPECT_EQ(value, 0.0f);
  b.assign(problem.size, 1.0f);
  const KrylovResult cut = solver.solve(b.data(), x.data(), 1e-6, 3);
  EXPECT_FALSE(cut.converged);
  EXPECT_EQ(cut.iterations, 3);
  EXPECT_LT(cut.relative_residual, 1.0);
  b.assign(problem.size, 1.0f);
  if (problem.comm.rank() == 0) b[7] = std::numeric_limits<float>::infinity();
  const KrylovResult broken = solver.solve(b.data(), x.data(), 1e-6, 3);  // the same on every rank
  EXPECT_FALSE(broken.converged);
  EXPECT_FALSE(std::isfinite(broken.relative_residual));
}

// A cyclic shift of all entries: the residual stays as it is until the space is whole. Who has another way gives up.
TEST(SingleGmres, GivesUpOnlyWhereAskedToAndWithoutProgress) {
  const Comm comm{MPI_COMM_WORLD};
  constexpr std::size_t size = 60;
  const auto shift = [](const float* v, float factor, float* z, float* w) {
    for (std::size_t k = 0; k < size; ++k) z[k] = factor * v[k];
    for (std::size_t k = 0; k < size; ++k) w[k] = z[(k + 1) % size];
  };
  SingleGmres solver(comm, size, size, shift, 100);
  std::vector<float> b(size), x(size);
  const auto solve = [&](int maximum, bool impatient) {
    b.assign(size, 0.0f);
    b[0] = 1.0f;
    return solver.solve(b.data(), x.data(), 1e-4, maximum, impatient);
  };
  const KrylovResult given_up = solve(40, true), patient = solve(40, false), whole = solve(100, false);
  EXPECT_TRUE(given_up.stalled);
  EXPECT_FALSE(given_up.converged);
  EXPECT_EQ(given_up.iterations, 10);
  EXPECT_FALSE(patient.stalled);
  EXPECT_EQ(patient.iterations, 40);
  EXPECT_TRUE(whole.converged);
  EXPECT_EQ(whole.iterations, static_cast<int>(size));
  Spread problem;  // progress enough
  SingleGmres quick = problem.solver(60);
  b.assign(problem.size, 1.0f);
  const KrylovResult result = quick.solve(b.data(), x.data(), 1e-5, 60, true);
  EXPECT_TRUE(result.converged);
  EXPECT_FALSE(result.stalled);
  EXPECT_GT(result.iterations, 10);
}

}  // namespace
}  // namespace fbi::linalg::test
