/// Kelvin-Voigt damping of the torsion-free element.
#include <algorithm>

#include "beam/torsion_free.hpp"
#include "beam/torsion_free_strain.hpp"

namespace fbi::beam {

using namespace torsion_free;

namespace {

// A number with its derivatives by the six components of t = r' and c = r''.
struct Dual {
  double value = 0.0;
  std::array<double, 6> by{};
};

Dual operator+(Dual x, const Dual& y) {
  x.value += y.value;
  for (int i = 0; i < 6; ++i) x.by[i] += y.by[i];
  return x;
}
Dual operator*(const Dual& x, const Dual& y) {
  Dual z;
  z.value = x.value * y.value;
  for (int i = 0; i < 6; ++i) z.by[i] = x.by[i] * y.value + x.value * y.by[i];
  return z;
}
Dual operator*(double a, Dual x) {
  x.value *= a;
  for (double& d : x.by) d *= a;
  return x;
}
Dual operator-(const Dual& x, const Dual& y) { return x + (-1.0) * y; }
Dual inverse(const Dual& x) {
  Dual z;
  z.value = 1 / x.value;
  for (int i = 0; i < 6; ++i) z.by[i] = -x.by[i] * z.value * z.value;
  return z;
}

using DualVector = std::array<Dual, 3>;
DualVector operator+(const DualVector& u, const DualVector& v) { return {u[0] + v[0], u[1] + v[1], u[2] + v[2]}; }
DualVector operator-(const DualVector& u, const DualVector& v) { return {u[0] - v[0], u[1] - v[1], u[2] - v[2]}; }
DualVector operator*(const Dual& a, const DualVector& v) { return {a * v[0], a * v[1], a * v[2]}; }
using torsion_free::dot;
Dual dot(const DualVector& u, const DualVector& v) { return u[0] * v[0] + u[1] * v[1] + u[2] * v[2]; }
DualVector cross(const DualVector& u, const DualVector& v) {
  return {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
}

DualVector constant(const Vector& v) {
  DualVector d;
  for (int k = 0; k < 3; ++k) d[k].value = v[k];
  return d;
}
DualVector variable(const Vector& v, int first) {
  DualVector d = constant(v);
  for (int k = 0; k < 3; ++k) d[k].by[first + k] = 1.0;
  return d;
}

// Rate of the curvature vector k = t x c/|t|^2 seen from the tangent, which turns by w = t x t'/|t|^2: k' - w x k.
DualVector strain_rate(const DualVector& t, const DualVector& c, const DualVector& dt, const DualVector& dc,
                       const DualVector& k, const Dual& inverse_square) {
  const DualVector rate = cross(dt, c) + cross(t, dc) - 2.0 * dot(t, dt) * k;
  return inverse_square * (rate - cross(cross(t, dt), k));
}

// Forces conjugate to t and c of a stress vector conjugate to that rate.
struct Conjugate {
  DualVector t, c;
};
Conjugate conjugate(const DualVector& t, const DualVector& c, const DualVector& stress, const DualVector& k,
                    const Dual& inverse_square) {
  return {inverse_square * (cross(c, stress) - 2.0 * dot(k, stress) * t - cross(cross(k, stress), t)),
          inverse_square * cross(stress, t)};
}

void add_axial(const ElementProperties& element, const double* q, const double* v, double* force, double* by_q,
               double* by_v) {
  const AxialStrain s = axial_strain(element, q);
  std::array<double, 3> rate{};
  double gradient[3][element_dofs], second[3][element_dofs];  // d eps_c/dq and d rate_c/dq
  for (int c = 0; c < 3; ++c) {
    const Vector dt = combine(s.weights[c], v);
    rate[c] = dot(s.direction[c], dt);
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 3; ++k) {
        gradient[c][3 * i + k] = s.weights[c][i] * s.direction[c][k];
        second[c][3 * i + k] = s.weights[c][i] * (dt[k] - rate[c] * s.direction[c][k]) / s.stretch[c];
      }
  }
  const std::array<double, 3> n = axial_forces(element, rate);
  const double scale = element.axial_stiffness * 0.5 * element.length;
  for (int c = 0; c < 3; ++c)
    for (int a = 0; a < element_dofs; ++a) {
      force[a] += n[c] * gradient[c][a];
      if (by_q == nullptr) continue;
      for (int b = 0; b < element_dofs; ++b)
        for (int d = 0; d < 3; ++d) {
          by_q[element_dofs * a + b] += scale * strain_gram[c][d] * gradient[c][a] * second[d][b];
          by_v[element_dofs * a + b] += scale * strain_gram[c][d] * gradient[c][a] * gradient[d][b];
        }
    }
  if (by_q == nullptr) return;
  for (int c = 0; c < 3; ++c)
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j)
        for (int k = 0; k < 3; ++k)
          for (int l = 0; l < 3; ++l)
            by_q[element_dofs * (3 * i + k) + 3 * j + l] +=
                n[c] * s.weights[c][i] * s.weights[c][j] *
                ((k == l ? 1.0 : 0.0) - s.direction[c][k] * s.direction[c][l]) / s.stretch[c];
}

void add_bending(const ElementProperties& element, const double* q, const double* v, double* force, double* by_q,
                 double* by_v) {
  for (int p = 0; p < gauss_points; ++p) {
    const Weights b = first_weights(gauss_point[p], element.length);
    const Weights w = second_weights(gauss_point[p], element.length);
    const DualVector t = variable(combine(b, q), 0), c = variable(combine(w, q), 3);
    const DualVector dt = constant(combine(b, v)), dc = constant(combine(w, v));
    const double scale = element.bending_stiffness * gauss_weight[p] * 0.5 * element.length;
    const Dual inverse_square = inverse(dot(t, t));
    const DualVector k = inverse_square * cross(t, c);
    DualVector stress = strain_rate(t, c, dt, dc, k, inverse_square);
    for (Dual& component : stress) component = scale * component;
    const Conjugate out = conjugate(t, c, stress, k, inverse_square);
    for (int i = 0; i < 4; ++i)
      for (int m = 0; m < 3; ++m) {
        force[3 * i + m] += b[i] * out.t[m].value + w[i] * out.c[m].value;
        if (by_q == nullptr) continue;
        for (int j = 0; j < 4; ++j)
          for (int l = 0; l < 3; ++l)
            by_q[element_dofs * (3 * i + m) + 3 * j + l] += b[i] * (b[j] * out.t[m].by[l] + w[j] * out.t[m].by[3 + l]) +
                                                            w[i] * (b[j] * out.c[m].by[l] + w[j] * out.c[m].by[3 + l]);
      }
    if (by_v == nullptr) continue;
    // the force is linear in the rates: one column for each unit rate of t and c
    const DualVector tv = constant(combine(b, q)), cv = constant(combine(w, q));
    Dual fixed_inverse;
    fixed_inverse.value = inverse_square.value;
    const DualVector kv = fixed_inverse * cross(tv, cv);
    for (int column = 0; column < 6; ++column) {
      Vector unit_t{}, unit_c{};
      (column < 3 ? unit_t[column] : unit_c[column - 3]) = scale;
      const DualVector unit_stress = strain_rate(tv, cv, constant(unit_t), constant(unit_c), kv, fixed_inverse);
      const Conjugate unit = conjugate(tv, cv, unit_stress, kv, fixed_inverse);
      for (int i = 0; i < 4; ++i)
        for (int m = 0; m < 3; ++m)
          for (int j = 0; j < 4; ++j)
            by_v[element_dofs * (3 * i + m) + 3 * j + column % 3] +=
                (b[i] * unit.t[m].value + w[i] * unit.c[m].value) * (column < 3 ? b[j] : w[j]);
    }
  }
}

}  // namespace

void TorsionFree::viscous_force(const ElementProperties& element, const double* q, const double* v, double* force,
                                double* by_q, double* by_v) const {
  std::fill_n(force, element_dofs, 0.0);
  if (by_q != nullptr) std::fill_n(by_q, element_dofs * element_dofs, 0.0);
  if (by_v != nullptr) std::fill_n(by_v, element_dofs * element_dofs, 0.0);
  add_axial(element, q, v, force, by_q, by_v);
  add_bending(element, q, v, force, by_q, by_v);
}

}  // namespace fbi::beam
