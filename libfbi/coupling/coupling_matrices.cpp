#include "coupling/coupling_matrices.hpp"

#include <cmath>

#include "fem/hex8.hpp"
#include "fem/line_shapes.hpp"

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

void integration_points(const Measure& measure, const fem::QuadratureRule& rule, const Segment& segment,
                        std::vector<IntegrationPoint>& points) {
  if (segment.rule_point >= 0) {
    const double x = rule.points[segment.rule_point];
    points.push_back({x, rule.weights[segment.rule_point] * measure(x), segment.first_point});
    return;
  }
  const double middle = 0.5 * (segment.begin + segment.end), half = 0.5 * (segment.end - segment.begin);
  for (std::size_t q = 0; q < rule.points.size(); ++q) {
    const double x = middle + half * rule.points[q];
    points.push_back({x, rule.weights[q] * half * measure(x), segment.first_point + static_cast<Index>(q)});
  }
}

void ElementIntegrals::reset(Index rows) {
  kappa.assign(rows, 0.0);
  d.assign(rows, {});
  length = 0.0;
}

void integrate_fiber(const Basis& basis, double half_length, const std::vector<IntegrationPoint>& points,
                     ElementIntegrals& sums) {
  for (const IntegrationPoint& point : points) {
    const BasisValues phi = basis.at(point.x, point.number);
    std::array<double, 4> h = fem::hermite(point.x);
    h[1] *= half_length;
    h[3] *= half_length;
    sums.length += point.ds;
    for (int p = 0; p < phi.count; ++p) {
      const double weight = phi.value[p] * point.ds;
      sums.kappa[phi.first + p] += weight;
      for (int j = 0; j < 4; ++j) sums.d[phi.first + p][j] += weight * h[j];
    }
  }
}

bool integrate_fluid(const Basis& basis, const Curve& curve, const Cell& cell,
                     const std::vector<IntegrationPoint>& points, std::vector<std::array<double, 8>>& m) {
  Vec3 xi = Vec3::Zero();
  for (const IntegrationPoint& point : points) {
    if (!project(cell, curve.point(point.x), xi)) return false;
    const BasisValues phi = basis.at(point.x, point.number);
    const std::array<double, 8> n = fem::hex8_shape(xi);
    for (int p = 0; p < phi.count; ++p)
      for (int a = 0; a < 8; ++a) m[phi.first + p][a] += phi.value[p] * point.ds * n[a];
  }
  return true;
}

}  // namespace fbi::coupling
