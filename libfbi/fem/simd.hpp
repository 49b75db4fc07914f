/// One number for each cell of a batch: eight doubles or sixteen floats at once, and the transposition from and to
/// interleaved nodal arrays.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstring>

#include "base/node_vector.hpp"
#include "base/types.hpp"

// In a portable build a kernel is compiled for AVX-512, for AVX2 and for any x86-64; which one runs is decided when the
// program starts. Everything that it calls is inlined into it: nothing else may need the wider instructions.
#if defined(FBI_PORTABLE) && defined(__x86_64__)
#define FBI_KERNEL [[gnu::flatten, gnu::target_clones("arch=x86-64-v4", "arch=x86-64-v3", "default")]]
#else
#define FBI_KERNEL
#endif

namespace fbi::fem {

// Vectors wider than the machine's are passed in memory; nothing here crosses a library boundary.
#pragma GCC diagnostic ignored "-Wpsabi"

/// Numbers for the cells of a batch, 64 bytes of them; arithmetic is lane by lane. T: double (8 cells) or float (16).
template <class T>
struct alignas(64) BatchOf {
  typedef T Vector __attribute__((vector_size(64)));  // NOLINT: an alias cannot carry the attribute in a template
  static constexpr int lanes = 64 / sizeof(T);
  using Scalar = T;
  Vector v;

  BatchOf() = default;
  BatchOf(T x) : v(x - Vector{}) {}  // NOLINT: a number is the same number in every lane
  explicit BatchOf(const Vector& x) : v(x) {}

  T operator[](int lane) const { return v[lane]; }
  void set(int lane, T x) { v[lane] = x; }

  BatchOf& operator+=(const BatchOf& b) {
    v += b.v;
    return *this;
  }
  BatchOf& operator-=(const BatchOf& b) {
    v -= b.v;
    return *this;
  }
  BatchOf& operator*=(const BatchOf& b) {
    v *= b.v;
    return *this;
  }
  friend BatchOf operator+(const BatchOf& a, const BatchOf& b) { return BatchOf(a.v + b.v); }
  friend BatchOf operator-(const BatchOf& a, const BatchOf& b) { return BatchOf(a.v - b.v); }
  friend BatchOf operator*(const BatchOf& a, const BatchOf& b) { return BatchOf(a.v * b.v); }
  friend BatchOf operator/(const BatchOf& a, const BatchOf& b) { return BatchOf(a.v / b.v); }
  friend BatchOf operator-(const BatchOf& a) { return BatchOf(-a.v); }
  /// a > b ? x : y. Numbers that are none raise no floating-point exception.
  friend BatchOf select_greater(const BatchOf& a, const BatchOf& b, const BatchOf& x, const BatchOf& y) {
    BatchOf out;
    for (int lane = 0; lane < lanes; ++lane) out.v[lane] = std::isgreater(a.v[lane], b.v[lane]) ? x.v[lane] : y.v[lane];
    return out;
  }
  friend BatchOf abs(const BatchOf& a) {
    BatchOf out;
    for (int lane = 0; lane < lanes; ++lane) out.v[lane] = std::abs(a.v[lane]);
    return out;
  }
  /// The larger one, `a` where `b` is not a number.
  friend BatchOf max(const BatchOf& a, const BatchOf& b) { return select_greater(b, a, b, a); }
  friend BatchOf sqrt(const BatchOf& a) {
    BatchOf root;
    for (int lane = 0; lane < lanes; ++lane) root.v[lane] = std::sqrt(a.v[lane]);
    return root;
  }
};

/// A number for each of the eight cells of a batch in double precision.
using Batch = BatchOf<double>;
/// Cells of one batch in double precision.
inline constexpr int batch_size = Batch::lanes;

namespace detail {
using Four = NodeVector<double>;
using Eight = Batch::Vector;
}  // namespace detail

/// Reads four interleaved unknowns of one node of each cell: out[c][lane] = array[4 node[lane] + c].
/// @param array  shape=(nodes,4)
/// @param node   shape=(8), one node for each lane
inline void gather_four(const double* array, const Index* node, Batch* out) {
  using detail::Eight;
  const auto at = [&](int lane) { return load_node(array + 4 * static_cast<std::ptrdiff_t>(node[lane])); };
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
    const Four sum = load_node(p) + four[lane];
    std::memcpy(p, &sum, sizeof(Four));
  }
}

namespace detail {
using FourFloats = NodeVector<float>;
using EightFloats = float __attribute__((vector_size(32)));
using SixteenFloats = BatchOf<float>::Vector;
}  // namespace detail

/// Sixteen nodes in single precision: q[k] holds those of lanes k, k + 4, k + 8, k + 12, four numbers each.
struct FourOfSixteen {
  detail::SixteenFloats q[4];

  /// From or to one vector for each of the four numbers.
  void to_batches(BatchOf<float>* out) const {
    const detail::SixteenFloats a = low(q[0], q[2]), b = low(q[1], q[3]), c = high(q[0], q[2]), d = high(q[1], q[3]);
    out[0].v = low(a, b);
    out[1].v = high(a, b);
    out[2].v = low(c, d);
    out[3].v = high(c, d);
  }
  void from_batches(const BatchOf<float>* in) {
    const detail::SixteenFloats a = low(in[0].v, in[2].v), b = low(in[1].v, in[3].v);
    const detail::SixteenFloats c = high(in[0].v, in[2].v), d = high(in[1].v, in[3].v);
    q[0] = low(a, b);
    q[1] = high(a, b);
    q[2] = low(c, d);
    q[3] = high(c, d);
  }

 private:
  static detail::SixteenFloats low(const detail::SixteenFloats& a, const detail::SixteenFloats& b) {
    return __builtin_shufflevector(a, b, 0, 16, 1, 17, 4, 20, 5, 21, 8, 24, 9, 25, 12, 28, 13, 29);
  }
  static detail::SixteenFloats high(const detail::SixteenFloats& a, const detail::SixteenFloats& b) {
    return __builtin_shufflevector(a, b, 2, 18, 3, 19, 6, 22, 7, 23, 10, 26, 11, 27, 14, 30, 15, 31);
  }
};

/// Lane of the i-th of sixteen cells: with it four neighboring nodes are one vector of memory (gather_row).
inline constexpr int lane_of_sixteen(int i) { return 4 * (i % 4) + i / 4; }

/// out[c][lane] = array[4 node[lane] + c] in single precision; node has shape=(16).
inline void gather_four(const float* array, const Index* node, BatchOf<float>* out) {
  const auto at = [&](int lane) { return load_node(array + 4 * static_cast<std::ptrdiff_t>(node[lane])); };
  FourOfSixteen four;
  for (int k = 0; k < 4; ++k) {
    const detail::EightFloats low = __builtin_shufflevector(at(k), at(k + 4), 0, 1, 2, 3, 4, 5, 6, 7);
    const detail::EightFloats high = __builtin_shufflevector(at(k + 8), at(k + 12), 0, 1, 2, 3, 4, 5, 6, 7);
    four.q[k] = __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  }
  four.to_batches(out);
}

/// array[4 node[lane] + c] += in[c][lane]; lanes from `lanes` on, in the order of lane_of_sixteen, are left out.
inline void scatter_add_four(const BatchOf<float>* in, const Index* node, int lanes, float* array) {
  FourOfSixteen packed;
  packed.from_batches(in);
  alignas(64) float four[4][16];
  for (int k = 0; k < 4; ++k) std::memcpy(four[k], &packed.q[k], sizeof(packed.q[k]));
  for (int i = 0; i < lanes; ++i) {
    const int lane = lane_of_sixteen(i);
    float* p = array + 4 * static_cast<std::ptrdiff_t>(node[lane]);
    const detail::FourFloats sum = load_node(p) + load_node(&four[lane % 4][4 * (lane / 4)]);
    std::memcpy(p, &sum, sizeof(sum));
  }
}

/// The same where the i-th of the sixteen nodes is `first` + i, i-th in the sense of lane_of_sixteen.
inline void gather_row(const float* array, Index first, BatchOf<float>* out) {
  FourOfSixteen four;
  std::memcpy(four.q, array + 4 * static_cast<std::ptrdiff_t>(first), sizeof(four.q));
  four.to_batches(out);
}

/// The transposed operation for both ends of the edges of a row of cells: the i-th of the `low` nodes is `first` + i,
/// that of the `high` ones is `first` + i + 1. Every node is read and written once.
inline void scatter_add_edges(const BatchOf<float>* low, const BatchOf<float>* high, Index first, float* array) {
  const auto shifted = [](const detail::SixteenFloats& before, const detail::SixteenFloats& here) {
    return __builtin_shufflevector(before, here, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25, 26, 27);
  };
  FourOfSixteen a, b, sum;
  a.from_batches(low);
  b.from_batches(high);
  float* p = array + 4 * static_cast<std::ptrdiff_t>(first);
  std::memcpy(sum.q, p, sizeof(sum.q));
  sum.q[0] += a.q[0] + shifted(detail::SixteenFloats{}, b.q[0]);
  for (int k = 1; k < 4; ++k) sum.q[k] += a.q[k] + shifted(b.q[k - 1], b.q[k]);
  std::memcpy(p, sum.q, sizeof(sum.q));
  const detail::FourFloats last = load_node(p + 64) + __builtin_shufflevector(b.q[3], b.q[3], 12, 13, 14, 15);
  std::memcpy(p + 64, &last, sizeof(last));
}

}  // namespace fbi::fem
