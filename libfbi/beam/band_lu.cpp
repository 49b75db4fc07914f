#include "beam/band_lu.hpp"

#include <algorithm>
#include <cmath>

namespace fbi::beam {

template <Index half>
bool Band<half>::factorize(double* band, Index* pivot, Index n) {
  Index last = 0;  // last column that the rows met so far reach
  for (Index k = 0; k < n; ++k) {
    const Index below = std::min(n - 1, k + half_bandwidth);
    Index p = k;
    double largest = std::abs(band[entry(k, k)]);
    for (Index i = k + 1; i <= below; ++i) {
      const double candidate = std::abs(band[entry(i, k)]);
      if (std::isgreater(candidate, largest)) {
        largest = candidate;
        p = i;
      }
    }
    if (!std::isfinite(largest) || largest < 1e-300) return false;
    pivot[k] = p;
    last = std::max(last, std::min(p + half_bandwidth, n - 1));
    double* row_k = band + entry(k, 0);
    if (p != k) {
      double* row_p = band + entry(p, 0);
      std::swap_ranges(row_k + k, row_k + last + 1, row_p + k);
    }
    const double inverse = 1.0 / row_k[k];
    for (Index i = k + 1; i <= below; ++i) {
      double* row_i = band + entry(i, 0);
      const double factor = row_i[k] * inverse;
      row_i[k] = factor;
#pragma GCC ivdep
      for (Index j = k + 1; j <= last; ++j) row_i[j] -= factor * row_k[j];
    }
  }
  return true;
}

template <Index half>
void Band<half>::solve(const double* band, const Index* pivot, Index n, double* b, Index columns) {
  const auto row = [b, columns](Index i) { return b + static_cast<std::size_t>(i) * columns; };
  for (Index k = 0; k < n; ++k) {
    double* b_k = row(k);
    if (pivot[k] != k) std::swap_ranges(b_k, b_k + columns, row(pivot[k]));
    const Index below = std::min(n - 1, k + half_bandwidth);
    for (Index i = k + 1; i <= below; ++i) {
      const double factor = band[entry(i, k)];
      double* b_i = row(i);
#pragma GCC ivdep
      for (Index c = 0; c < columns; ++c) b_i[c] -= factor * b_k[c];
    }
  }
  for (Index k = n - 1; k >= 0; --k) {
    double* b_k = row(k);
    const Index last = std::min(n - 1, k + 2 * half_bandwidth);
    for (Index j = k + 1; j <= last; ++j) {
      const double factor = band[entry(k, j)];
      const double* b_j = row(j);
#pragma GCC ivdep
      for (Index c = 0; c < columns; ++c) b_k[c] -= factor * b_j[c];
    }
    const double inverse = 1.0 / band[entry(k, k)];
    for (Index c = 0; c < columns; ++c) b_k[c] *= inverse;
  }
}

template struct Band<11>;
template struct Band<20>;
template struct Band<8>;

}  // namespace fbi::beam
