#include "linalg/line_transform.hpp"

#include <algorithm>
#include <array>
#include <cstdint>

#include "linalg/lanes.hpp"

namespace fbi::linalg {
namespace {

// Columns are treated in strips of two vectors; a tile of rows keeps its sums in registers.
constexpr int strip = 2;
#if defined(__AVX512F__) || defined(__aarch64__)
constexpr int tile_rows = 12;  // of 32 registers
#else
constexpr int tile_rows = 6;  // of 16
#endif

/// out[i] = sum_k a[k][i] in[k] for `Rows` values of i; in and out have shape=(.,strip) vectors.
template <class Real, int Rows>
void multiply_tile(const Real* a, Index stride, Index depth, const Lanes<Real>* in, Lanes<Real>* out) {
  Lanes<Real> sum[Rows][strip] = {};
  for (Index k = 0; k < depth; ++k) {
    const Real* factor = a + static_cast<std::size_t>(k) * stride;
    Lanes<Real> column[strip];
    for (int s = 0; s < strip; ++s) column[s] = in[strip * k + s];
    for (int i = 0; i < Rows; ++i)
      for (int s = 0; s < strip; ++s) sum[i][s] += factor[i] * column[s];
  }
  for (int i = 0; i < Rows; ++i)
    for (int s = 0; s < strip; ++s) out[strip * i + s] = sum[i][s];
}

template <class Real>
using Tile = void (*)(const Real*, Index, Index, const Lanes<Real>*, Lanes<Real>*);

template <class Real, int... R>
constexpr std::array<Tile<Real>, sizeof...(R)> make_tiles(std::integer_sequence<int, R...>) {
  return {multiply_tile<Real, R + 1>...};
}

/// out = a^T in with a of shape=(depth,rows).
template <class Real>
void multiply(const Real* a, Index depth, Index rows, const Lanes<Real>* in, Lanes<Real>* out) {
  static constexpr auto tiles = make_tiles<Real>(std::make_integer_sequence<int, tile_rows>());
  const Index count = (rows + tile_rows - 1) / tile_rows;
  for (Index t = 0, begin = 0; t < count; ++t) {
    const Index end = rows * (t + 1) / count;
    tiles[end - begin - 1](a + begin, rows, depth, in, out + strip * begin);
    begin = end;
  }
}

}  // namespace

template <class Real>
LineTransform<Real>::LineTransform(const Matrix& q, bool mirrored)
    : size_(static_cast<Index>(q.rows())), mirrored_(mirrored) {
  const Index even = mirrored ? (size_ + 1) / 2 : size_, odd = size_ - even;
  for (Index j = 0; j < even; ++j)
    for (Index m = 0; m < even; ++m) forward_.push_back(static_cast<Real>(q(j, m)));
  for (Index j = 0; j < odd; ++j)
    for (Index m = 0; m < odd; ++m) forward_.push_back(static_cast<Real>(q(j, even + m)));
  for (Index m = 0; m < even; ++m)
    for (Index j = 0; j < even; ++j) backward_.push_back(static_cast<Real>(q(j, m)));
  for (Index m = 0; m < odd; ++m)
    for (Index j = 0; j < odd; ++j) backward_.push_back(static_cast<Real>(q(j, even + m)));
  // Input and output strips, and room to align them.
  work_.resize(static_cast<std::size_t>(2 * strip * size_ + 1) * lane_count<Real>);
}

namespace {

template <class Real>
Lanes<Real>* aligned(std::vector<Real>& work) {
  const auto address = reinterpret_cast<std::uintptr_t>(work.data());
  return reinterpret_cast<Lanes<Real>*>((address + lane_bytes - 1) / lane_bytes * lane_bytes);
}

/// Calls body(first column, lanes of each of the two vectors) for strips that cover `inner` columns.
template <class Real, class Body>
void for_strips(Index inner, Body body) {
  constexpr Index width = lane_count<Real>;
  Index column = 0;
  for (; column + strip * width <= inner; column += strip * width) body(column, width, width);
  if (column < inner) body(column, std::min(width, inner - column), std::max<Index>(0, inner - column - width));
}

template <class Real>
void read(const Real* from, Index first, Index second, Lanes<Real>* to) {
  constexpr Index width = lane_count<Real>;
  to[0] = first == width ? load(from) : load(from, first);
  to[1] = second == width ? load(from + width) : load(from + (second > 0 ? width : 0), second);
}

template <class Real>
void write(const Lanes<Real>* from, Index first, Index second, Real* to) {
  constexpr Index width = lane_count<Real>;
  if (second == width) {
    store(from[0], to);
    store(from[1], to + width);
    return;
  }
  store(from[0], to, first);
  if (second > 0) store(from[1], to + width, second);
}

}  // namespace

template <class Real>
void LineTransform<Real>::forward(Index outer, Index inner, const Real* in, Real* out) const {
  const Index n = size_, half = n / 2, even = mirrored_ ? n - half : n, odd = n - even;
  Lanes<Real>*right = aligned(work_), *left = right + strip * n;
  for (Index o = 0; o < outer; ++o) {
    const Real* from = in + static_cast<std::size_t>(o) * n * inner;
    Real* to = out + static_cast<std::size_t>(o) * n * inner;
    for_strips<Real>(inner, [&](Index column, Index first, Index second) {
      const auto row = [&](Index j) { return static_cast<std::size_t>(j) * inner + column; };
      if (mirrored_) {
        for (Index j = 0; j < half; ++j) {
          Lanes<Real> low[strip], high[strip];
          read(from + row(j), first, second, low);
          read(from + row(n - 1 - j), first, second, high);
          for (int s = 0; s < strip; ++s) {
            right[strip * j + s] = low[s] + high[s];
            right[strip * (even + j) + s] = low[s] - high[s];
          }
        }
        if (even > half) read(from + row(half), first, second, right + strip * half);
      } else {
        for (Index j = 0; j < n; ++j) read(from + row(j), first, second, right + strip * j);
      }
      multiply(forward_.data(), even, even, right, left);
      if (odd > 0)
        multiply(forward_.data() + static_cast<std::size_t>(even) * even, odd, odd, right + strip * even,
                 left + strip * even);
      for (Index m = 0; m < n; ++m) write(left + strip * m, first, second, to + row(m));
    });
  }
}

template <class Real>
void LineTransform<Real>::backward(Index outer, Index inner, const Real* in, Real* out) const {
  const Index n = size_, half = n / 2, even = mirrored_ ? n - half : n, odd = n - even;
  Lanes<Real>*right = aligned(work_), *left = right + strip * n;
  for (Index o = 0; o < outer; ++o) {
    const Real* from = in + static_cast<std::size_t>(o) * n * inner;
    Real* to = out + static_cast<std::size_t>(o) * n * inner;
    for_strips<Real>(inner, [&](Index column, Index first, Index second) {
      const auto row = [&](Index j) { return static_cast<std::size_t>(j) * inner + column; };
      for (Index m = 0; m < n; ++m) read(from + row(m), first, second, right + strip * m);
      multiply(backward_.data(), even, even, right, left);
      if (odd > 0)
        multiply(backward_.data() + static_cast<std::size_t>(even) * even, odd, odd, right + strip * even,
                 left + strip * even);
      if (!mirrored_) {
        for (Index j = 0; j < n; ++j) write(left + strip * j, first, second, to + row(j));
        return;
      }
      for (Index j = 0; j < half; ++j) {
        Lanes<Real> low[strip], high[strip];
        for (int s = 0; s < strip; ++s) {
          low[s] = left[strip * j + s] + left[strip * (even + j) + s];
          high[s] = left[strip * j + s] - left[strip * (even + j) + s];
        }
        write(low, first, second, to + row(j));
        write(high, first, second, to + row(n - 1 - j));
      }
      if (even > half) write(left + strip * half, first, second, to + row(half));
    });
  }
}

template class LineTransform<float>;
template class LineTransform<double>;

}  // namespace fbi::linalg
