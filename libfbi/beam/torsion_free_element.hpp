/// Force, tangent and mass of the torsion-free element, for one element or for a batch of them.
#pragma once

#include "beam/torsion_free_strain.hpp"

namespace fbi::beam::torsion_free {

/// Node functions whose weight of r' does not vanish at a collocation point: there is one at either end.
inline constexpr int first_acting[3] = {1, 0, 3}, last_acting[3] = {1, 3, 3};

/// Adds the derivative of the axial energy by q, shape=(12), to `residual`, and its second derivative to the 3 x 3
/// blocks (i,j), i <= j, of `tangent`, shape=(12,12) row-major or null.
template <class T>
void add_axial(const ElementPropertiesOf<T>& element, const T* q, T* residual, T* tangent) {
  const AxialStrainOf<T> s = axial_strain(element, q);
  const std::array<T, 3> n = axial_forces(element, s.strain);
  T gradient[3][element_dofs];  // d eps_c/dq
  for (int c = 0; c < 3; ++c)
    for (int i = first_acting[c]; i <= last_acting[c]; ++i)
      for (int k = 0; k < 3; ++k) {
        gradient[c][3 * i + k] = s.weights[c][i] * s.direction[c][k];
        residual[3 * i + k] += n[c] * gradient[c][3 * i + k];
      }
  if (tangent == nullptr) return;
  const T scale = element.axial_stiffness * 0.5 * element.length;
  for (int c = 0; c < 3; ++c) {
    T row[element_dofs];  // sum_d EA W_cd d eps_d/dq
    for (int b = 0; b < element_dofs; ++b) row[b] = strain_gram[c][1] * gradient[1][b];
    for (int k = 0; k < 3; ++k) {
      row[3 + k] += strain_gram[c][0] * gradient[0][3 + k];
      row[9 + k] += strain_gram[c][2] * gradient[2][9 + k];
    }
    for (int b = 0; b < element_dofs; ++b) row[b] *= scale;
    for (int i = first_acting[c]; i <= last_acting[c]; ++i)
      for (int k = 0; k < 3; ++k)
        for (int b = 3 * i; b < element_dofs; ++b)
          tangent[element_dofs * (3 * i + k) + b] += gradient[c][3 * i + k] * row[b];
    // second variation of |r'|: (I - g g^T)/|r'|
    T second[3][3];
    const T force = n[c] / s.stretch[c];
    for (int k = 0; k < 3; ++k)
      for (int l = 0; l < 3; ++l) second[k][l] = force * ((k == l ? 1.0 : 0.0) - s.direction[c][k] * s.direction[c][l]);
    for (int i = first_acting[c]; i <= last_acting[c]; ++i)
      for (int j = i; j <= last_acting[c]; ++j) {
        const T w = s.weights[c][i] * s.weights[c][j];
        for (int k = 0; k < 3; ++k)
          for (int l = 0; l < 3; ++l) tangent[element_dofs * (3 * i + k) + 3 * j + l] += w * second[k][l];
      }
  }
}

/// kappa^2 = |t x c|^2/|t|^4 = cc/tt - (tc/tt)^2 of t = r', c = r'', with first and second derivatives.
template <class T>
struct SquaredCurvature {
  std::array<T, 3> by_t, by_c;
  T by_tt[3][3], by_tc[3][3], by_cc[3][3];
};

template <class T>
SquaredCurvature<T> squared_curvature(const std::array<T, 3>& t, const std::array<T, 3>& c, bool second) {
  const T tt = dot(t, t), tc = dot(t, c), cc = dot(c, c);
  const T inverse = 1.0 / tt, inverse2 = inverse * inverse, inverse3 = inverse2 * inverse;
  const T f_tt = (2.0 * tc * tc * inverse - cc) * inverse2, f_tc = -2.0 * tc * inverse2, f_cc = inverse;
  SquaredCurvature<T> f;
  for (int k = 0; k < 3; ++k) {
    f.by_t[k] = 2.0 * f_tt * t[k] + f_tc * c[k];
    f.by_c[k] = f_tc * t[k] + 2.0 * f_cc * c[k];
  }
  if (!second) return f;
  const T g_aa = (2.0 * cc - 6.0 * tc * tc * inverse) * inverse3, g_ab = 4.0 * tc * inverse3, g_ad = -inverse2,
          g_bb = -2.0 * inverse2;
  for (int k = 0; k < 3; ++k)
    for (int l = 0; l < 3; ++l) {
      f.by_tt[k][l] = 4.0 * g_aa * t[k] * t[l] + 2.0 * g_ab * (t[k] * c[l] + c[k] * t[l]) + g_bb * c[k] * c[l];
      f.by_tc[k][l] = 2.0 * g_ab * t[k] * t[l] + 4.0 * g_ad * t[k] * c[l] + g_bb * c[k] * t[l];
      f.by_cc[k][l] = g_bb * t[k] * t[l];
    }
  for (int k = 0; k < 3; ++k) {
    f.by_tt[k][k] += 2.0 * f_tt;
    f.by_tc[k][k] += f_tc;
    f.by_cc[k][k] += 2.0 * f_cc;
  }
  return f;
}

/// The same for the bending energy.
template <class T>
void add_bending(const ElementPropertiesOf<T>& element, const T* q, T* residual, T* tangent) {
  for (int p = 0; p < gauss_points; ++p) {
    const std::array<T, 4> b = first_weights(gauss_point[p], element.length);
    const std::array<T, 4> c = second_weights(gauss_point[p], element.length);
    const SquaredCurvature<T> f = squared_curvature(combine(b, q), combine(c, q), tangent != nullptr);
    const T scale = 0.5 * element.bending_stiffness * gauss_weight[p] * 0.5 * element.length;
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 3; ++k) residual[3 * i + k] += scale * (b[i] * f.by_t[k] + c[i] * f.by_c[k]);
    if (tangent == nullptr) continue;
    for (int j = 0; j < 4; ++j) {
      T x[3][3], y[3][3];  // columns of node function j: derivative of by_t and of by_c
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) {
          x[k][l] = scale * (b[j] * f.by_tt[k][l] + c[j] * f.by_tc[k][l]);
          y[k][l] = scale * (b[j] * f.by_tc[l][k] + c[j] * f.by_cc[k][l]);
        }
      for (int i = 0; i <= j; ++i)
        for (int k = 0; k < 3; ++k)
          for (int l = 0; l < 3; ++l)
            tangent[element_dofs * (3 * i + k) + 3 * j + l] += b[i] * x[k][l] + c[i] * y[k][l];
    }
  }
}

/// Fills the blocks (i,j), i > j, of a symmetric matrix, shape=(12,12), with those across the diagonal.
template <class T>
void mirror(T* matrix) {
  for (int i = 1; i < 4; ++i)
    for (int k = 0; k < 3; ++k)
      for (int b = 0; b < 3 * i; ++b) matrix[element_dofs * (3 * i + k) + b] = matrix[element_dofs * b + 3 * i + k];
}

/// rho_b A int H_i H_j ds: the consistent mass in each direction.
template <class T>
void scalar_mass(const ElementPropertiesOf<T>& element, T (&mass)[4][4]) {
  const T& l = element.length;
  const T scale = element.mass_per_length * l / 420.0;
  const T scalar[4][4] = {{156.0, 22.0 * l, 54.0, -13.0 * l},
                          {22.0 * l, 4.0 * l * l, 13.0 * l, -3.0 * l * l},
                          {54.0, 13.0 * l, 156.0, -22.0 * l},
                          {-13.0 * l, -3.0 * l * l, -22.0 * l, 4.0 * l * l}};
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j) mass[i][j] = scale * scalar[i][j];
}

}  // namespace fbi::beam::torsion_free
