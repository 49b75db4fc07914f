#include "linalg/block_inverses.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <map>

#include "base/types.hpp"
#include "fem/simd.hpp"

namespace fbi::linalg {
namespace {

using Lanes = fem::Batch;
using fem::batch_size;

// Part of a diagonal entry that must remain of it as a pivot, and of the largest one that symmetry may miss.
constexpr double least_pivot = 1e-13, symmetric = 1e-12;

// Replaces symmetric matrices, shape=(n,n) of which the lower triangle is used, by minus their inverses: one sweep for
// each row. `pivot_column` and `diagonal` are scratch, shape=(n). `ok`: lanes that are symmetric and whose pivots are
// all positive.
FBI_KERNEL void invert_symmetric(Lanes* matrix, Index n, Lanes* pivot_column, Lanes* diagonal, bool* ok) {
  Lanes largest = 0.0, difference = 0.0;
  for (Index i = 0; i < n; ++i) {
    diagonal[i] = matrix[n * i + i];
    largest = max(largest, abs(diagonal[i]));
    for (Index j = 0; j < i; ++j) difference = max(difference, abs(matrix[n * i + j] - matrix[n * j + i]));
  }
  Lanes refused = select_greater(difference, symmetric * largest, 1.0, 0.0);
  for (Index k = 0; k < n; ++k) {
    const Lanes least = least_pivot * abs(diagonal[k]), pivot = matrix[n * k + k];
    Lanes inverse = 1.0 / select_greater(pivot, least, pivot, 1.0);
    inverse = select_greater(pivot, least, inverse, 0.0);
    refused += select_greater(inverse, 0.0, 0.0, 1.0);
    for (Index i = 0; i < n; ++i) pivot_column[i] = i < k ? matrix[n * k + i] : matrix[n * i + k];
    for (Index i = 0; i < n; ++i) {
      if (i == k) continue;
      const Lanes factor = pivot_column[i] * inverse;
      for (Index j = 0; j <= i; ++j) matrix[n * i + j] -= factor * pivot_column[j];
      (i < k ? matrix[n * k + i] : matrix[n * i + k]) = factor;
    }
    matrix[n * k + k] = -inverse;
  }
  for (int lane = 0; lane < batch_size; ++lane) ok[lane] = refused[lane] == 0.0;
}

bool invert_one(const DenseBlock& block, DenseBlock& inverse) {
  const Eigen::PartialPivLU<DenseBlock> factor(block);
  if (!(factor.matrixLU().diagonal().cwiseAbs().minCoeff() > 0.0)) return false;
  inverse = factor.inverse();
  return true;
}

}  // namespace

bool invert(const std::vector<DenseBlock>& blocks, std::vector<DenseBlock>& inverses) {
  std::map<Index, std::vector<std::size_t>> of_size;
  for (std::size_t f = 0; f < blocks.size(); ++f) {
    if (blocks[f].size() == 0) continue;
    if (!blocks[f].allFinite()) return false;
    of_size[static_cast<Index>(blocks[f].rows())].push_back(f);
  }
  for (const auto& [n, list] : of_size) {
    const std::size_t size = static_cast<std::size_t>(n) * n;
    std::vector<Lanes> storage(size + 2 * static_cast<std::size_t>(n));
    Lanes* matrix = storage.data();
    for (std::size_t begin = 0; begin < list.size(); begin += batch_size) {
      const int count = static_cast<int>(std::min<std::size_t>(batch_size, list.size() - begin));
      for (int lane = 0; lane < batch_size; ++lane) {
        const double* from = blocks[list[begin + std::min(lane, count - 1)]].data();
        for (std::size_t i = 0; i < size; ++i) matrix[i].set(lane, from[i]);
      }
      bool ok[batch_size];
      invert_symmetric(matrix, n, matrix + size, matrix + size + n, ok);
      for (int lane = 0; lane < count; ++lane) {
        const std::size_t f = list[begin + lane];
        if (!ok[lane]) {
          if (!invert_one(blocks[f], inverses[f])) return false;
          continue;
        }
        inverses[f].resize(n, n);
        double* to = inverses[f].data();
        for (Index i = 0; i < n; ++i)
          for (Index j = 0; j <= i; ++j) to[n * i + j] = to[n * j + i] = -matrix[n * i + j][lane];
      }
    }
  }
  return true;
}

}  // namespace fbi::linalg
