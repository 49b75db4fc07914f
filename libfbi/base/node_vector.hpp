/// The four numbers of a node of a nodal array as one vector, for loops over nodes that take them alike.
#pragma once

#include <cstdint>
#include <cstring>
#include <type_traits>

namespace fbi {

/// Velocity and pressure, or a force and nothing; arithmetic is entry by entry. T: double or float.
template <class T>
struct NodeVectorOf {
  typedef T Type __attribute__((vector_size(4 * sizeof(T))));  // NOLINT: an alias cannot carry the attribute
};
template <class T>
using NodeVector = typename NodeVectorOf<T>::Type;

template <class T>
inline NodeVector<T> load_node(const T* p) {
  NodeVector<T> x;
  std::memcpy(&x, p, sizeof(x));
  return x;
}
template <class T>
inline void store_node(const NodeVector<T>& x, T* p) {
  std::memcpy(p, &x, sizeof(x));
}
/// The first three numbers of a and the last one of b, bit by bit.
template <class T>
inline NodeVector<T> three_and_one(const NodeVector<T>& a, const NodeVector<T>& b) {
  using Bits = typename NodeVectorOf<std::conditional_t<sizeof(T) == 8, std::int64_t, std::int32_t>>::Type;
  constexpr Bits first = {0, 1, 2, 7};
  return __builtin_shuffle(a, b, first);
}

}  // namespace fbi
