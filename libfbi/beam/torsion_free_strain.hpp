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

inline double dot(const Vector& u, const Vector& v) { return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]; }

inline Vector combine(const Weights& weights, const double* q) {
  Vector sum{};
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 3; ++k) sum[k] += weights[i] * q[3 * i + k];
  return sum;
}

/// Weights of r' = dr/ds at x.
inline Weights first_weights(double x, double length) {
  const Weights h = fem::hermite_first(x);
  const double scale = 2.0 / length;
  return {scale * h[0], h[1], scale * h[2], h[3]};
}

/// Weights of r'' at x.
inline Weights second_weights(double x, double length) {
  const Weights h = fem::hermite_second(x);
  const double scale = 2.0 / length;
  return {scale * scale * h[0], scale * h[1], scale * scale * h[2], scale * h[3]};
}

/// Axial strain |r'| - 1 at the collocation points, the weights of r' and its unit vectors there.
struct AxialStrain {
  std::array<Weights, 3> weights;
  std::array<Vector, 3> direction;
  std::array<double, 3> stretch;
  std::array<double, 3> strain;
};

inline AxialStrain axial_strain(const ElementProperties& element, const double* q) {
  AxialStrain s;
  for (int c = 0; c < 3; ++c) {
    s.weights[c] = first_weights(collocation_point[c], element.length);
    const Vector t = combine(s.weights[c], q);
    s.stretch[c] = std::sqrt(dot(t, t));
    s.strain[c] = s.stretch[c] - 1.0;
    for (int k = 0; k < 3; ++k) s.direction[c][k] = t[k] / s.stretch[c];
  }
  return s;
}

/// n_c = EA int L_c eps_h ds, conjugate to the strain at collocation point c [force length].
inline std::array<double, 3> axial_forces(const ElementProperties& element, const std::array<double, 3>& strain) {
  std::array<double, 3> n{};
  const double scale = element.axial_stiffness * 0.5 * element.length;
  for (int c = 0; c < 3; ++c)
    for (int d = 0; d < 3; ++d) n[c] += scale * strain_gram[c][d] * strain[d];
  return n;
}

}  // namespace fbi::beam::torsion_free
