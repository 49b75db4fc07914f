/// Internal force of the midpoint scheme: difference quotients of the strain energy in place of its gradient.
#include <algorithm>
#include <cmath>

#include "beam/torsion_free.hpp"
#include "beam/torsion_free_strain.hpp"

namespace fbi::beam {

using namespace torsion_free;

namespace {

// Axial part. |t_1| - |t_0| = D . (t_1 - t_0) with D = (t_0 + t_1)/(|t_0| + |t_1|).
void add_axial(const ElementProperties& element, const double* q_n, const double* q, double* residual,
               double* tangent) {
  const AxialStrain last = axial_strain(element, q_n), next = axial_strain(element, q);
  std::array<double, 3> mean{};
  for (int c = 0; c < 3; ++c) mean[c] = 0.5 * (last.strain[c] + next.strain[c]);
  const std::array<double, 3> n = axial_forces(element, mean);
  Vector quotient[3];
  for (int c = 0; c < 3; ++c) {
    const double sum = last.stretch[c] + next.stretch[c];
    for (int k = 0; k < 3; ++k)
      quotient[c][k] = (last.stretch[c] * last.direction[c][k] + next.stretch[c] * next.direction[c][k]) / sum;
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 3; ++k) residual[3 * i + k] += n[c] * next.weights[c][i] * quotient[c][k];
  }
  if (tangent == nullptr) return;
  const double scale = element.axial_stiffness * 0.25 * element.length;  // half of EA l/2: mean strain
  for (int c = 0; c < 3; ++c) {
    double row[element_dofs] = {};  // d n_c/dq
    for (int d = 0; d < 3; ++d)
      for (int i = 0; i < 4; ++i)
        for (int k = 0; k < 3; ++k)
          row[3 * i + k] += scale * strain_gram[c][d] * next.weights[d][i] * next.direction[d][k];
    const double sum = last.stretch[c] + next.stretch[c];
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 3; ++k) {
        double* out = tangent + element_dofs * (3 * i + k);
        for (int b = 0; b < element_dofs; ++b) out[b] += next.weights[c][i] * quotient[c][k] * row[b];
        for (int j = 0; j < 4; ++j)
          for (int l = 0; l < 3; ++l)
            out[3 * j + l] += n[c] * next.weights[c][i] * next.weights[c][j] *
                              ((k == l ? 1.0 : 0.0) - quotient[c][k] * next.direction[c][l]) / sum;
      }
  }
}

// kappa^2 = e/a - (b/a)^2 of the invariants a = t.t, b = t.c, e = c.c, t = r', c = r''.
struct Invariants {
  double a, b, e;
  double curvature() const { return b / a; }
};

Invariants invariants(const Vector& t, const Vector& c) { return {dot(t, t), dot(t, c), dot(c, c)}; }

// Difference quotients of kappa^2 by a, b, e: f_1 - f_0 = by_a (a_1 - a_0) + by_b (b_1 - b_0) + by_e (e_1 - e_0), and
// their derivatives by a_1, b_1, e_1.
struct Quotient {
  double by_a, by_b, by_e;
  double second[3][3];
};

Quotient quotient(const Invariants& last, const Invariants& next) {
  const double inverse = 1 / (last.a * next.a);
  const double g = 0.5 * (1 / last.a + 1 / next.a), e = 0.5 * (last.e + next.e), b = 0.5 * (last.b + next.b),
               h = 0.5 * (last.curvature() + next.curvature());
  Quotient d;
  d.by_e = g;
  d.by_a = (2 * h * b - e) * inverse;
  d.by_b = -2 * h * g;
  const double g_a = -0.5 / (next.a * next.a), h_a = -0.5 * next.b / (next.a * next.a), h_b = 0.5 / next.a;
  d.second[0][0] = 2 * h_a * b * inverse - d.by_a / next.a;
  d.second[0][1] = (2 * h_b * b + h) * inverse;
  d.second[0][2] = -0.5 * inverse;
  d.second[1][0] = -2 * (h_a * g + h * g_a);
  d.second[1][1] = -2 * h_b * g;
  d.second[1][2] = 0.0;
  d.second[2][0] = g_a;
  d.second[2][1] = d.second[2][2] = 0.0;
  return d;
}

void add_bending(const ElementProperties& element, const double* q_n, const double* q, double* residual,
                 double* tangent) {
  for (int p = 0; p < gauss_points; ++p) {
    const Weights b = first_weights(gauss_point[p], element.length);
    const Weights w = second_weights(gauss_point[p], element.length);
    const Vector t_n = combine(b, q_n), c_n = combine(w, q_n), t = combine(b, q), c = combine(w, q);
    const Quotient d = quotient(invariants(t_n, c_n), invariants(t, c));
    const double scale = 0.5 * element.bending_stiffness * gauss_weight[p] * 0.5 * element.length;
    Vector t_mid, c_mid;
    for (int k = 0; k < 3; ++k) {
      t_mid[k] = 0.5 * (t_n[k] + t[k]);
      c_mid[k] = 0.5 * (c_n[k] + c[k]);
    }
    // a, b, e change by 2 t_mid . dt, c_mid . dt + t_mid . dc, 2 c_mid . dc: rows conjugate to the DoFs
    double row[3][element_dofs], now[3][element_dofs];
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 3; ++k) {
        const int j = 3 * i + k;
        row[0][j] = 2 * b[i] * t_mid[k];
        row[1][j] = b[i] * c_mid[k] + w[i] * t_mid[k];
        row[2][j] = 2 * w[i] * c_mid[k];
        now[0][j] = 2 * b[i] * t[k];
        now[1][j] = b[i] * c[k] + w[i] * t[k];
        now[2][j] = 2 * w[i] * c[k];
        residual[j] += scale * (d.by_a * row[0][j] + d.by_b * row[1][j] + d.by_e * row[2][j]);
      }
    if (tangent == nullptr) continue;
    for (int i = 0; i < element_dofs; ++i) {
      double by[3] = {};
      for (int m = 0; m < 3; ++m)
        for (int n = 0; n < 3; ++n) by[n] += row[m][i] * d.second[m][n];
      for (int j = 0; j < element_dofs; ++j)
        tangent[element_dofs * i + j] += scale * (by[0] * now[0][j] + by[1] * now[1][j] + by[2] * now[2][j]);
    }
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const double same =
            scale * (d.by_a * b[i] * b[j] + 0.5 * d.by_b * (b[i] * w[j] + w[i] * b[j]) + d.by_e * w[i] * w[j]);
        for (int k = 0; k < 3; ++k) tangent[element_dofs * (3 * i + k) + 3 * j + k] += same;
      }
  }
}

}  // namespace

void TorsionFree::conserving_force(const ElementProperties& element, const double* q_n, const double* q,
                                   double* residual, double* tangent) const {
  std::fill_n(residual, element_dofs, 0.0);
  if (tangent != nullptr) std::fill_n(tangent, element_dofs * element_dofs, 0.0);
  add_axial(element, q_n, q, residual, tangent);
  add_bending(element, q_n, q, residual, tangent);
}

}  // namespace fbi::beam
