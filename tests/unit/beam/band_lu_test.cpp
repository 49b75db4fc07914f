/// Banded LU against a dense factorisation, with interchanges, for short and long fibers.
#include "beam/band_lu.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>
#include <random>
#include <vector>

namespace fbi::beam {
namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Random matrix of the full band; the small diagonal forces interchanges.
Matrix random_band(Index n, std::vector<double>& band) {
  std::mt19937 generator(n);
  std::uniform_real_distribution<double> random(-1.0, 1.0);
  Matrix dense = Matrix::Zero(n, n);
  band.assign(band_size(n), 0.0);
  for (Index i = 0; i < n; ++i)
    for (Index j = std::max(0, i - half_bandwidth); j <= std::min(n - 1, i + half_bandwidth); ++j) {
      dense(i, j) = i == j ? 1e-3 * random(generator) : random(generator);
      band[band_entry(i, j)] = dense(i, j);
    }
  return dense;
}

TEST(BandLu, SolvesAsDense) {
  for (const Index n : {12, 18, 24, 60, 1206}) {
    std::vector<double> band;
    const Matrix dense = random_band(n, band);
    std::vector<Index> pivot(n);
    ASSERT_TRUE(band_factorize(band.data(), pivot.data(), n));
    for (const Index columns : {1, 7}) {
      const Matrix expected = Matrix::Random(n, columns);
      Matrix b = dense * expected;
      band_solve(band.data(), pivot.data(), n, b.data(), columns);
      EXPECT_LE((b - expected).norm(), 1e-9 * expected.norm()) << n << " rows, " << columns << " columns";
    }
  }
}

TEST(BandLu, SingularIsAStatus) {
  std::vector<double> band(band_size(12), 0.0);
  std::vector<Index> pivot(12);
  for (Index i = 0; i < 11; ++i) band[band_entry(i, i)] = 1.0;
  EXPECT_FALSE(band_factorize(band.data(), pivot.data(), 12));
}

TEST(BandLu, NotANumberIsAStatus) {
  std::vector<double> band(band_size(12), 0.0);
  std::vector<Index> pivot(12);
  for (Index i = 0; i < 12; ++i) band[band_entry(i, i)] = 1.0;
  band[band_entry(5, 5)] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(band_factorize(band.data(), pivot.data(), 12));
}

}  // namespace
}  // namespace fbi::beam
