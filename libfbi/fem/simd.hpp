/// Eight doubles at once: one number for each cell of a batch, and the transposition from and to interleaved nodal
/// arrays.
#pragma once

#include <cstddef>
#include <cstring>

#include "base/types.hpp"

namespace fbi::fem {

// Vectors wider than the machine's are passed in memory; nothing here crosses a library boundary.
#pragma GCC diagnostic ignored "-Wpsabi"

/// Cells of one batch.
inline constexpr int batch_size = 8;

/// A number for each of the eight cells of a batch; arithmetic is lane by lane.
struct alignas(64) Batch {
  using Vector = double __attribute__((vector_size(64)));
  Vector v;

  Batch() = default;
  Batch(double x) : v(Vector{x, x, x, x, x, x, x, x}) {}  // NOLINT: a number is the same number in every lane
  explicit Batch(const Vector& x) : v(x) {}

  double operator[](int lane) const { return v[lane]; }
  void set(int lane, double x) { v[lane] = x; }

  Batch& operator+=(const Batch& b) {
    v += b.v;
    return *this;
  }
  Batch& operator-=(const Batch& b) {
    v -= b.v;
    return *this;
  }
  Batch& operator*=(const Batch& b) {
    v *= b.v;
    return *this;
  }
};

inline Batch operator+(const Batch& a, const Batch& b) { return Batch(a.v + b.v); }
inline Batch operator-(const Batch& a, const Batch& b) { return Batch(a.v - b.v); }
inline Batch operator*(const Batch& a, const Batch& b) { return Batch(a.v * b.v); }
inline Batch operator/(const Batch& a, const Batch& b) { return Batch(a.v / b.v); }
inline Batch operator-(const Batch& a) { return Batch(-a.v); }

namespace detail {
using Four = double __attribute__((vector_size(32)));
using Eight = Batch::Vector;

inline Four load_four(const double* p) {
  Four x;
  std::memcpy(&x, p, sizeof(Four));
  return x;
}
}  // namespace detail

/// Reads four interleaved unknowns of one node of each cell: out[c][lane] = array[4 node[lane] + c].
/// @param array  shape=(nodes,4)
/// @param node   shape=(8), one node for each lane
inline void gather_four(const double* array, const Index* node, Batch* out) {
  using detail::Eight;
  const auto at = [&](int lane) { return detail::load_four(array + 4 * static_cast<std::ptrdiff_t>(node[lane])); };
  const Eight a = __builtin_shufflevector(at(0), at(1), 0, 1, 2, 3, 4, 5, 6, 7);
  const Eight b = __builtin_shufflevector(at(2), at(3), 0, 1, 2, 3, 4, 5, 6, 7);
  const Eight c = __builtin_shufflevector(at(4), at(5), 0, 1, 2, 3, 4, 5, 6, 7);
  const Eight d = __builtin_shufflevector(at(6), at(7), 0, 1, 2, 3, 4, 5, 6, 7);
  const Eight low01 = __builtin_shufflevector(a, b, 0, 4, 8, 12, 1, 5, 9, 13);
  const Eight low23 = __builtin_shufflevector(a, b, 2, 6, 10, 14, 3, 7, 11, 15);
  const Eight high01 = __builtin_shufflevector(c, d, 0, 4, 8, 12, 1, 5, 9, 13);
  const Eight high23 = __builtin_shufflevector(c, d, 2, 6, 10, 14, 3, 7, 11, 15);
  out[0].v = __builtin_shufflevector(low01, high01, 0, 1, 2, 3, 8, 9, 10, 11);
  out[1].v = __builtin_shufflevector(low01, high01, 4, 5, 6, 7, 12, 13, 14, 15);
  out[2].v = __builtin_shufflevector(low23, high23, 0, 1, 2, 3, 8, 9, 10, 11);
  out[3].v = __builtin_shufflevector(low23, high23, 4, 5, 6, 7, 12, 13, 14, 15);
}

/// The transposed operation, lane after lane: array[4 node[lane] + c] += in[c][lane] for the first `lanes` lanes.
inline void scatter_add_four(const Batch* in, const Index* node, int lanes, double* array) {
  using detail::Eight;
  using detail::Four;
  const Eight low01 = __builtin_shufflevector(in[0].v, in[1].v, 0, 1, 2, 3, 8, 9, 10, 11);
  const Eight high01 = __builtin_shufflevector(in[0].v, in[1].v, 4, 5, 6, 7, 12, 13, 14, 15);
  const Eight low23 = __builtin_shufflevector(in[2].v, in[3].v, 0, 1, 2, 3, 8, 9, 10, 11);
  const Eight high23 = __builtin_shufflevector(in[2].v, in[3].v, 4, 5, 6, 7, 12, 13, 14, 15);
  const Eight a = __builtin_shufflevector(low01, low23, 0, 4, 8, 12, 1, 5, 9, 13);
  const Eight b = __builtin_shufflevector(low01, low23, 2, 6, 10, 14, 3, 7, 11, 15);
  const Eight c = __builtin_shufflevector(high01, high23, 0, 4, 8, 12, 1, 5, 9, 13);
  const Eight d = __builtin_shufflevector(high01, high23, 2, 6, 10, 14, 3, 7, 11, 15);
  const Four four[8] = {__builtin_shufflevector(a, a, 0, 1, 2, 3), __builtin_shufflevector(a, a, 4, 5, 6, 7),
                        __builtin_shufflevector(b, b, 0, 1, 2, 3), __builtin_shufflevector(b, b, 4, 5, 6, 7),
                        __builtin_shufflevector(c, c, 0, 1, 2, 3), __builtin_shufflevector(c, c, 4, 5, 6, 7),
                        __builtin_shufflevector(d, d, 0, 1, 2, 3), __builtin_shufflevector(d, d, 4, 5, 6, 7)};
  for (int lane = 0; lane < lanes; ++lane) {
    double* p = array + 4 * static_cast<std::ptrdiff_t>(node[lane]);
    const Four sum = detail::load_four(p) + four[lane];
    std::memcpy(p, &sum, sizeof(Four));
  }
}

}  // namespace fbi::fem
