#include "beam/torsion_free.hpp"

#include <algorithm>
#include <cmath>

#include "beam/torsion_free_strain.hpp"

namespace fbi::beam {

using namespace torsion_free;

namespace {

void add_axial(const ElementProperties& element, const double* q, double* residual, double* tangent) {
  const AxialStrain s = axial_strain(element, q);
  const std::array<double, 3> n = axial_forces(element, s.strain);
  double gradient[3][element_dofs];  // d eps_c/dq
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 3; ++k) {
        gradient[c][3 * i + k] = s.weights[c][i] * s.direction[c][k];
        residual[3 * i + k] += n[c] * gradient[c][3 * i + k];
      }
  if (tangent == nullptr) return;
  const double scale = element.axial_stiffness * 0.5 * element.length;
  for (int c = 0; c < 3; ++c) {
    double row[element_dofs];  // sum_d EA W_cd d eps_d/dq
    for (int b = 0; b < element_dofs; ++b)
      row[b] = scale * (strain_gram[c][0] * gradient[0][b] + strain_gram[c][1] * gradient[1][b] +
                        strain_gram[c][2] * gradient[2][b]);
    for (int a = 0; a < element_dofs; ++a)
      for (int b = 0; b < element_dofs; ++b) tangent[element_dofs * a + b] += gradient[c][a] * row[b];
    // second variation of |r'|: (I - g g^T)/|r'|
    double second[3][3];
    for (int k = 0; k < 3; ++k)
      for (int l = 0; l < 3; ++l)
        second[k][l] = n[c] * ((k == l ? 1.0 : 0.0) - s.direction[c][k] * s.direction[c][l]) / s.stretch[c];
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const double w = s.weights[c][i] * s.weights[c][j];
        if (w == 0.0) continue;
        for (int k = 0; k < 3; ++k)
          for (int l = 0; l < 3; ++l) tangent[element_dofs * (3 * i + k) + 3 * j + l] += w * second[k][l];
      }
  }
}

// kappa^2 = |t x c|^2/|t|^4 = cc/tt - (tc/tt)^2 of t = r', c = r'', with first and second derivatives.
struct SquaredCurvature {
  Vector by_t, by_c;
  double by_tt[3][3], by_tc[3][3], by_cc[3][3];
};

SquaredCurvature squared_curvature(const Vector& t, const Vector& c, bool second) {
  const double tt = dot(t, t), tc = dot(t, c), cc = dot(c, c);
  const double inverse = 1.0 / tt, inverse2 = inverse * inverse, inverse3 = inverse2 * inverse;
  const double f_tt = (2 * tc * tc * inverse - cc) * inverse2, f_tc = -2 * tc * inverse2, f_cc = inverse;
  SquaredCurvature f;
  for (int k = 0; k < 3; ++k) {
    f.by_t[k] = 2 * f_tt * t[k] + f_tc * c[k];
    f.by_c[k] = f_tc * t[k] + 2 * f_cc * c[k];
  }
  if (!second) return f;
  const double g_aa = (2 * cc - 6 * tc * tc * inverse) * inverse3, g_ab = 4 * tc * inverse3, g_ad = -inverse2,
               g_bb = -2 * inverse2;
  for (int k = 0; k < 3; ++k)
    for (int l = 0; l < 3; ++l) {
      const double identity = k == l ? 1.0 : 0.0;
      f.by_tt[k][l] =
          2 * f_tt * identity + 4 * g_aa * t[k] * t[l] + 2 * g_ab * (t[k] * c[l] + c[k] * t[l]) + g_bb * c[k] * c[l];
      f.by_tc[k][l] = f_tc * identity + 2 * g_ab * t[k] * t[l] + 4 * g_ad * t[k] * c[l] + g_bb * c[k] * t[l];
      f.by_cc[k][l] = 2 * f_cc * identity + g_bb * t[k] * t[l];
    }
  return f;
}

void add_bending(const ElementProperties& element, const double* q, double* residual, double* tangent) {
  for (int p = 0; p < gauss_points; ++p) {
    const Weights b = first_weights(gauss_point[p], element.length);
    const Weights c = second_weights(gauss_point[p], element.length);
    const SquaredCurvature f = squared_curvature(combine(b, q), combine(c, q), tangent != nullptr);
    const double scale = 0.5 * element.bending_stiffness * gauss_weight[p] * 0.5 * element.length;
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 3; ++k) residual[3 * i + k] += scale * (b[i] * f.by_t[k] + c[i] * f.by_c[k]);
    if (tangent == nullptr) continue;
    for (int j = 0; j < 4; ++j) {
      double x[3][3], y[3][3];  // columns of node function j: derivative of by_t and of by_c
      for (int k = 0; k < 3; ++k)
        for (int l = 0; l < 3; ++l) {
          x[k][l] = scale * (b[j] * f.by_tt[k][l] + c[j] * f.by_tc[k][l]);
          y[k][l] = scale * (b[j] * f.by_tc[l][k] + c[j] * f.by_cc[k][l]);
        }
      for (int i = 0; i < 4; ++i)
        for (int k = 0; k < 3; ++k)
          for (int l = 0; l < 3; ++l)
            tangent[element_dofs * (3 * i + k) + 3 * j + l] += b[i] * x[k][l] + c[i] * y[k][l];
    }
  }
}

}  // namespace

double TorsionFree::energy(const ElementProperties& element, const double* q) const {
  const AxialStrain s = axial_strain(element, q);
  const std::array<double, 3> n = axial_forces(element, s.strain);
  double energy = 0.5 * (n[0] * s.strain[0] + n[1] * s.strain[1] + n[2] * s.strain[2]);
  for (int p = 0; p < gauss_points; ++p) {
    const Vector t = combine(first_weights(gauss_point[p], element.length), q);
    const Vector c = combine(second_weights(gauss_point[p], element.length), q);
    const Vector cross = {t[1] * c[2] - t[2] * c[1], t[2] * c[0] - t[0] * c[2], t[0] * c[1] - t[1] * c[0]};
    const double tt = dot(t, t);
    energy += 0.5 * element.bending_stiffness * gauss_weight[p] * 0.5 * element.length * dot(cross, cross) / (tt * tt);
  }
  return energy;
}

void TorsionFree::internal_force(const ElementProperties& element, const double* q, double* residual,
                                 double* tangent) const {
  std::fill_n(residual, element_dofs, 0.0);
  if (tangent != nullptr) std::fill_n(tangent, element_dofs * element_dofs, 0.0);
  add_axial(element, q, residual, tangent);
  add_bending(element, q, residual, tangent);
}

void TorsionFree::mass(const ElementProperties& element, double* mass) const {
  const double l = element.length, scale = element.mass_per_length * l / 420.0;
  const double scalar[4][4] = {{156, 22 * l, 54, -13 * l},
                               {22 * l, 4 * l * l, 13 * l, -3 * l * l},
                               {54, 13 * l, 156, -22 * l},
                               {-13 * l, -3 * l * l, -22 * l, 4 * l * l}};
  std::fill_n(mass, element_dofs * element_dofs, 0.0);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 3; ++k) mass[element_dofs * (3 * i + k) + 3 * j + k] = scale * scalar[i][j];
}

}  // namespace fbi::beam
