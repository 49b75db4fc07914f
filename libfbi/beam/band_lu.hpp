/// LU factorisation with row interchanges of the block-tridiagonal matrix of one fiber, as a band.
#pragma once

#include <cstddef>

#include "base/types.hpp"

namespace fbi::beam {

/// Matrices whose entries (i,j) vanish for |i-j| > half.
///
/// Entry (i,j), i - half <= j <= i + 2 half, of the band: rows of 3 half + 1 entries, the last `half` of which take the
/// fill of interchanges. Seen from entry (0,0) it is a row-major matrix with leading dimension 3 half.
template <Index half>
struct Band {
  static constexpr Index half_bandwidth = half;
  static constexpr Index stride = 3 * half;
  static std::size_t entry(Index i, Index j) {
    return static_cast<std::size_t>(i) * stride + static_cast<std::size_t>(half + j);
  }
  /// Number of doubles that a band with n rows needs.
  static std::size_t size(Index n) { return static_cast<std::size_t>(n) * (stride + 1); }

  /// Replaces the band by its factors; pivot, shape=(n), records the interchanges. False when the matrix is singular or
  /// not finite: the factors must not be used then. About 24 n half_bandwidth^2 operations at most.
  static bool factorize(double* band, Index* pivot, Index n);

  /// Solves for `columns` right-hand sides, b of shape=(n,columns) row-major, in place.
  static void solve(const double* band, const Index* pivot, Index n, double* b, Index columns);
};

/// Center lines: farthest are the DoFs of two neighboring nodes of 6 DoFs.
using CenterLineBand = Band<11>;
/// Center lines with triads: 12 unknowns of a node and the middle behind it, 9 of the next node.
using TriadBand = Band<20>;
/// Triads alone: 6 turns of a node and the middle behind it, 3 of the next node.
using TurnBand = Band<8>;

inline constexpr Index half_bandwidth = CenterLineBand::half_bandwidth;
inline constexpr Index band_stride = CenterLineBand::stride;
inline std::size_t band_entry(Index i, Index j) { return CenterLineBand::entry(i, j); }
inline std::size_t band_size(Index n) { return CenterLineBand::size(n); }
inline bool band_factorize(double* band, Index* pivot, Index n) { return CenterLineBand::factorize(band, pivot, n); }
inline void band_solve(const double* band, const Index* pivot, Index n, double* b, Index columns) {
  CenterLineBand::solve(band, pivot, n, b, columns);
}

}  // namespace fbi::beam
