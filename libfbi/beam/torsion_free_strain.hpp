/// Strains of the torsion-free element and the points they are taken at.
#pragma once

#include <array>
#include <cmath>

#include "beam/formulation.hpp"
#include "fem/line_shapes.hpp"

namespace fbi::beam::torsion_free {

using Vector = std::array<double, 3>;
using Weights = std::array<double, 4>;  // one number for each of d_1, t_1, d_2, t_2

inline constexpr int gauss_points =
    4;  // the fifth point changes no observed order and no error by more than a few percent
inline constexpr std::array<double, gauss_points> gauss_point = {-0.8611363115940526, -0.3399810435848563,
                                                                 0.3399810435848563, 0.8611363115940526};
inline constexpr std::array<double, gauss_points> gauss_weight = {0.3478548451374538, 0.6521451548625461,
                                                                  0.6521451548625461, 0.3478548451374538};

inline constexpr std::array<double, 3> collocation_point = {-1.0, 0.0, 1.0};
/// int_{-1}^{1} L_c L_d dx of the quadratic Lagrange functions on the collocation points
inline constexpr double strain_gram[3][3] = {
    {4.0 / 15, 2.0 / 15, -1.0 / 15}, {2.0 / 15, 16.0 / 15, 2.0 / 15}, {-1.0 / 15, 2.0 / 15, 4.0 / 15}};

template <class T>
T dot(const std::array<T, 3>& u, const std::array<T, 3>& v) {
  return u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
}

template <class T>
std::array<T, 3> combine(const std::array<T, 4>& weights, const T* q) {
  std::array<T, 3> sum;
  for (int k = 0; k < 3; ++k)
    sum[k] = weights[0] * q[k] + weights[1] * q[3 + k] + weights[2] * q[6 + k] + weights[3] * q[9 + k];
  return sum;
}

/// Weights of r' = dr/ds at x.
template <class T>
std::array<T, 4> first_weights(double x, const T& length) {
  const Weights h = fem::hermite_first(x);
  const T scale = 2.0 / length;
  return {scale * h[0], h[1], scale * h[2], h[3]};
}

/// Weights of r'' at x.
template <class T>
std::array<T, 4> second_weights(double x, const T& length) {
  const Weights h = fem::hermite_second(x);
  const T scale = 2.0 / length;
  return {scale * scale * h[0], scale * h[1], scale * scale * h[2], scale * h[3]};
}

/// Axial strain |r'| - 1 at the collocation points, the weights of r' and its unit vectors there.
template <class T>
struct AxialStrainOf {
  std::array<std::array<T, 4>, 3> weights;
  std::array<std::array<T, 3>, 3> direction;
  std::array<T, 3> stretch;
  std::array<T, 3> strain;
};
using AxialStrain = AxialStrainOf<double>;

template <class T>
AxialStrainOf<T> axial_strain(const ElementPropertiesOf<T>& element, const T* q) {
  using std::sqrt;
  AxialStrainOf<T> s;
  for (int c = 0; c < 3; ++c) {
    s.weights[c] = first_weights(collocation_point[c], element.length);
    const std::array<T, 3> t = combine(s.weights[c], q);
    s.stretch[c] = sqrt(dot(t, t));
    s.strain[c] = s.stretch[c] - 1.0;
    for (int k = 0; k < 3; ++k) s.direction[c][k] = t[k] / s.stretch[c];
  }
  return s;
}

/// n_c = EA int L_c eps_h ds, conjugate to the strain at collocation point c [force length].
template <class T>
std::array<T, 3> axial_forces(const ElementPropertiesOf<T>& element, const std::array<T, 3>& strain) {
  std::array<T, 3> n;
  const T scale = element.axial_stiffness * 0.5 * element.length;
  for (int c = 0; c < 3; ++c)
    n[c] = scale * (strain_gram[c][0] * strain[0] + strain_gram[c][1] * strain[1] + strain_gram[c][2] * strain[2]);
  return n;
}

}  // namespace fbi::beam::torsion_free
