/// Trilinear fields on a batch of hexahedra: from corner values to the eight Gauss points and back.
///
/// Everything is written in the scaled reference coordinates z = xi / g with g = 1/sqrt(3): the 2x2x2 Gauss points are
/// then z = (+-1, +-1, +-1), and a field is the sum of c_m prod_{i in m} z_i over the subsets m of the three directions
/// (bit i of m set: factor z_i). Corners and points are numbered by bits as well: bit i set means the positive side of
/// direction i.
#pragma once

#include <array>
#include <bit>

#include "fem/simd.hpp"

namespace fbi::fluid {

using fem::Batch;

/// Corner in hex8 (VTK) order of the corner numbered by bits.
inline constexpr std::array<int, 8> corner_of_bits = {0, 1, 3, 2, 4, 5, 7, 6};

inline constexpr double gauss_scale = 0.577350269189625764509148780501957456;  // 1/sqrt(3)

/// g^k / 8 for a subset m of k directions.
inline constexpr std::array<double, 8> mode_scale = [] {
  std::array<double, 8> scale{};
  for (unsigned m = 0; m < 8; ++m) {
    scale[m] = 0.125;
    for (int k = 0; k < std::popcount(m); ++k) scale[m] *= gauss_scale;
  }
  return scale;
}();

/// The two directions besides d, ascending.
inline constexpr std::array<std::array<int, 2>, 3> other_directions = {{{1, 2}, {0, 2}, {0, 1}}};

/// c_m = (g^k/8) sum_a (product of the corner's signs in m) f_a, in place; f by corner bits.
template <class B>
inline void to_modes(B* f) {
  for (int bit = 1; bit < 8; bit *= 2)
    for (int a = 0; a < 8; ++a)
      if ((a & bit) == 0) {
        const B low = f[a], high = f[a | bit];
        f[a] = low + high;
        f[a | bit] = high - low;
      }
  for (int m = 0; m < 8; ++m) f[m] *= mode_scale[m];
}

/// The transposed map: f_a = sum_m (g^k/8) (signs of corner a in m) c_m, in place.
template <class B>
inline void from_modes(B* f) {
  for (int m = 0; m < 8; ++m) f[m] *= mode_scale[m];
  for (int bit = 1; bit < 8; bit *= 2)
    for (int a = 0; a < 8; ++a)
      if ((a & bit) == 0) {
        const B low = f[a], high = f[a | bit];
        f[a] = low - high;
        f[a | bit] = low + high;
      }
}

/// Index of point q among the four lines along direction d (derivatives along d are constant there).
inline constexpr int line_of_point(int d, int q) {
  return ((q >> other_directions[d][0]) & 1) + 2 * ((q >> other_directions[d][1]) & 1);
}
/// Index of point q for the mixed second derivative over the two directions besides d: it varies along d alone.
inline constexpr int layer_of_point(int d, int q) { return (q >> d) & 1; }

/// Values at the points.
template <class B>
inline void values_at_points(const B* modes, B* value) {
  for (int m = 0; m < 8; ++m) value[m] = modes[m];
  for (int bit = 1; bit < 8; bit *= 2)
    for (int a = 0; a < 8; ++a)
      if ((a & bit) == 0) {
        const B low = value[a], high = value[a | bit];
        value[a] = low - high;
        value[a | bit] = low + high;
      }
}

/// d/dz_d on the four lines along direction d, shape=(4).
template <class B>
inline void derivative_at_points(const B* modes, int d, B* out) {
  const int self = 1 << d, first = 1 << other_directions[d][0], second = 1 << other_directions[d][1];
  const B a = modes[self] - modes[self | first], b = modes[self] + modes[self | first];
  const B c = modes[self | second] - modes[7], e = modes[self | second] + modes[7];
  out[0] = a - c;
  out[1] = b - e;
  out[2] = a + c;
  out[3] = b + e;
}

/// d^2/(dz_k dz_l), {k,l} the two directions besides d, on the two layers normal to d, shape=(2).
template <class B>
inline void mixed_at_points(const B* modes, int d, B* out) {
  out[0] = modes[7 ^ (1 << d)] - modes[7];
  out[1] = modes[7 ^ (1 << d)] + modes[7];
}

/// First derivatives of a field at all points.
template <class B>
struct PointDerivatives {
  B line[3][4];
  explicit PointDerivatives(const B* modes) {
    for (int d = 0; d < 3; ++d) derivative_at_points(modes, d, line[d]);
  }
  PointDerivatives() = default;
};

/// Moments of a flux against the slopes of the modes: out_m = sum_q sum_d flux_dq dphi_m/dz_d, phi_m = prod_{i in m}
/// z_i.
/// @param flux  reference flux along each direction, shape=(3,8)
template <class B>
inline void flux_moments(const B (*flux)[8], B* out) {
  B sums[3][4];  // along direction d: of the other modes none, first, second, both
  for (int d = 0; d < 3; ++d) {
    const int self = 1 << d, first = 1 << other_directions[d][0], second = 1 << other_directions[d][1];
    const B* f = flux[d];
    const B s00 = f[0] + f[self], s10 = f[first] + f[first | self];
    const B s01 = f[second] + f[second | self], s11 = f[7 ^ self] + f[7];
    const B low = s00 + s10, high = s01 + s11, low_difference = s10 - s00, high_difference = s11 - s01;
    sums[d][0] = low + high;
    sums[d][1] = low_difference + high_difference;
    sums[d][2] = high - low;
    sums[d][3] = high_difference - low_difference;
  }
  out[0] = B(0.0);
  out[1] = sums[0][0];
  out[2] = sums[1][0];
  out[4] = sums[2][0];
  out[3] = sums[0][1] + sums[1][1];
  out[5] = sums[0][2] + sums[2][1];
  out[6] = sums[1][2] + sums[2][2];
  out[7] = sums[0][3] + sums[1][3] + sums[2][3];
}

/// Moments against the modes: out_m = sum_q (value_q phi_m + sum_d flux_dq dphi_m/dz_d).
/// @param value  shape=(8), overwritten
/// @param flux   reference flux along each direction, shape=(3,8)
template <class B>
inline void moments(B* value, const B (*flux)[8], B* out) {
  for (int bit = 1; bit < 8; bit *= 2)
    for (int a = 0; a < 8; ++a)
      if ((a & bit) == 0) {
        const B low = value[a], high = value[a | bit];
        value[a] = low + high;
        value[a | bit] = high - low;
      }
  flux_moments(flux, out);
  for (int m = 0; m < 8; ++m) out[m] += value[m];
}

}  // namespace fbi::fluid
