#include "coupling/coupling_matrices.hpp"

#include <algorithm>
#include <cmath>

#include "fem/hex8.hpp"
#include "fem/line_shapes.hpp"
#include "fem/simd.hpp"

namespace fbi::coupling {

namespace {

/// N_a(xi) of the eight corners.
fem::Batch shape(const Vec3& xi) {
  static_assert(fem::batch_size == 8);
  static const auto signs = [] {
    std::array<fem::Batch, 3> sign;
    for (int i = 0; i < 3; ++i)
      for (int a = 0; a < 8; ++a) sign[i].set(a, fem::hex8_corners[a][i]);
    return sign;
  }();
  return 0.125 * (1.0 + signs[0] * xi[0]) * (1.0 + signs[1] * xi[1]) * (1.0 + signs[2] * xi[2]);
}

}  // namespace

double Measure::operator()(double x) const {
  if (constant >= 0.0) return constant;
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
  const auto is_constant = [](const double* c) { return c[1] == 0.0 && c[2] == 0.0; };
  if (std::all_of(measure.c, measure.c + 3, is_constant)) measure.constant = measure(0.0);
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
  fem::Batch sums[most_rows];
  for (fem::Batch& sum : sums) sum = 0.0;
  Vec3 xi = Vec3::Zero();
  for (const IntegrationPoint& point : points) {
    if (!project(cell, curve.point(point.x), xi)) return false;
    const BasisValues phi = basis.at(point.x, point.number);
    const fem::Batch weighted = point.ds * shape(xi);
    if (basis.is_lagrange())
      for (int p = 0; p < phi.count; ++p) sums[p] += phi.value[p] * weighted;
    else
      for (int a = 0; a < 8; ++a) m[phi.first][a] += weighted[a];
  }
  for (int p = 0; basis.is_lagrange() && p <= basis.order(); ++p)
    for (int a = 0; a < 8; ++a) m[p][a] += sums[p][a];
  return true;
}

}  // namespace fbi::coupling
