/// Vectors of the machine's width for any real type, and the transposition of square tiles of them.
#pragma once

#include <cstddef>
#include <cstring>
#include <utility>

namespace fbi::linalg {

// Vectors never cross a library boundary.
#pragma GCC diagnostic ignored "-Wpsabi"

#if defined(__AVX512F__)
inline constexpr int lane_bytes = 64;
#elif defined(__AVX__)
inline constexpr int lane_bytes = 32;
#else
inline constexpr int lane_bytes = 16;
#endif

/// `count` numbers of type Real that one instruction treats together.
template <class Real>
struct LanesOf {
  static constexpr int count = lane_bytes / static_cast<int>(sizeof(Real));
  typedef Real Vector __attribute__((vector_size(lane_bytes)));
};
template <class Real>
using Lanes = typename LanesOf<Real>::Vector;
template <class Real>
inline constexpr int lane_count = LanesOf<Real>::count;

template <class Real>
inline Lanes<Real> load(const Real* from) {
  Lanes<Real> v;
  std::memcpy(&v, from, sizeof v);
  return v;
}
/// The first `count` lanes; the others are zero.
template <class Real>
inline Lanes<Real> load(const Real* from, int count) {
  Lanes<Real> v = {};
  std::memcpy(&v, from, static_cast<std::size_t>(count) * sizeof(Real));
  return v;
}
template <class Real>
inline void store(Lanes<Real> v, Real* to) {
  std::memcpy(to, &v, sizeof v);
}
template <class Real>
inline void store(Lanes<Real> v, Real* to, int count) {
  std::memcpy(to, &v, static_cast<std::size_t>(count) * sizeof(Real));
}

namespace detail {
// Swaps the off-diagonal blocks of size S of all pairs of rows that lie S apart.
template <class Real, int S, int... L>
inline void swap_blocks(Lanes<Real>* v, std::integer_sequence<int, L...> lanes) {
  constexpr int n = lane_count<Real>;
  for (int i = 0; i < n; ++i) {
    if ((i & S) != 0) continue;
    const Lanes<Real> a = v[i], b = v[i + S];
    v[i] = __builtin_shufflevector(a, b, ((L & S) == 0 ? L : n + L - S)...);
    v[i + S] = __builtin_shufflevector(a, b, ((L & S) == 0 ? L + S : n + L)...);
  }
  if constexpr (S > 1) swap_blocks<Real, S / 2>(v, lanes);
}
}  // namespace detail

/// v[i][j] <-> v[j][i], shape=(lane_count,lane_count).
template <class Real>
inline void transpose(Lanes<Real>* v) {
  constexpr int n = lane_count<Real>;
  detail::swap_blocks<Real, n / 2>(v, std::make_integer_sequence<int, n>());
}

}  // namespace fbi::linalg
