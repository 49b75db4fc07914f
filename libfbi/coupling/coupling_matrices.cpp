#include "coupling/coupling_matrices.hpp"

#include <cmath>

#include "fem/hex8.hpp"

namespace fbi::coupling {

double Measure::operator()(double x) const {
  double square = 0.0;
  for (const auto& component : c) {
    const double slope = component[0] + x * (component[1] + x * component[2]);
    square += slope * slope;
  }
  return std::sqrt(square);
}

Measure make_measure(const Curve& reference) {
  Measure measure{};
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k) measure.c[i][k] = (k + 1) * reference.component[i].c[k + 1];
  return measure;
}

void integrate_fiber(const Measure& measure, double half_length, const fem::QuadratureRule& rule, double begin,
                     double end, FiberIntegrals& sums) {
  const double middle = 0.5 * (begin + end), half = 0.5 * (end - begin);
  for (std::size_t q = 0; q < rule.points.size(); ++q) {
    const double x = middle + half * rule.points[q];
    const double ds = rule.weights[q] * half * measure(x);
    const std::array<double, rows_per_element> phi = multiplier_shape(x);
    std::array<double, 4> h = fem::hermite(x);
    h[1] *= half_length;
    h[3] *= half_length;
    sums.length += ds;
    for (int p = 0; p < rows_per_element; ++p) {
      const double weight = phi[p] * ds;
      sums.kappa[p] += weight;
      for (int j = 0; j < 4; ++j) sums.d[p][j] += weight * h[j];
    }
  }
}

bool integrate_fluid(const Curve& curve, const Measure& measure, const Cell& cell, const fem::QuadratureRule& rule,
                     double begin, double end, std::array<std::array<double, 8>, rows_per_element>& m) {
  const double middle = 0.5 * (begin + end), half = 0.5 * (end - begin);
  Vec3 xi = Vec3::Zero();
  for (std::size_t q = 0; q < rule.points.size(); ++q) {
    const double x = middle + half * rule.points[q];
    if (!project(cell, curve.point(x), xi)) return false;
    const double ds = rule.weights[q] * half * measure(x);
    const std::array<double, rows_per_element> phi = multiplier_shape(x);
    const std::array<double, 8> n = fem::hex8_shape(xi);
    for (int p = 0; p < rows_per_element; ++p)
      for (int a = 0; a < 8; ++a) m[p][a] += phi[p] * ds * n[a];
  }
  return true;
}

}  // namespace fbi::coupling
