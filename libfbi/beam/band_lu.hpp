/// LU factorisation with row interchanges of the block-tridiagonal matrix of one fiber, as a band.
#pragma once

#include <cstddef>

#include "base/types.hpp"

namespace fbi::beam {

/// Farthest coupling of two DoFs: those of two neighboring nodes of 6 DoFs.
inline constexpr Index half_bandwidth = 11;

/// Entry (i,j), i - 11 <= j <= i + 22, of the band: rows of 34 entries, the last 11 of which take the fill of
/// interchanges. Seen from entry (0,0) it is a row-major matrix with leading dimension 33.
inline constexpr Index band_stride = 3 * half_bandwidth;
inline std::size_t band_entry(Index i, Index j) {
  return static_cast<std::size_t>(i) * band_stride + static_cast<std::size_t>(half_bandwidth + j);
}
/// Number of doubles that a band with n rows needs.
inline std::size_t band_size(Index n) { return static_cast<std::size_t>(n) * (band_stride + 1); }

/// Replaces the band by its factors; pivot, shape=(n), records the interchanges. False when the matrix is singular or
/// not finite: the factors must not be used then. About 24 n half_bandwidth^2 operations at most.
bool band_factorize(double* band, Index* pivot, Index n);

/// Solves for `columns` right-hand sides, b of shape=(n,columns) row-major, in place.
void band_solve(const double* band, const Index* pivot, Index n, double* b, Index columns);

}  // namespace fbi::beam
