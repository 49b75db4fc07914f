#include "coupling/ring.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "fem/hex8.hpp"

namespace fbi::coupling {

namespace {
constexpr double smallest_compliance = 1e-6;  // times 1/mu: what counts as an infinite penalty
}

Vec3 Ring::offset(Index q) const {
  const double angle = 2.0 * std::numbers::pi * (q + 0.5) / points;
  return radius * (std::cos(angle) * first + std::sin(angle) * second);
}

double size_across(const Cell& cell, const Vec3& tangent) {
  const Mat3 edges = 2.0 * cell.corners * fem::hex8_gradient(Vec3::Zero());
  double largest = 0.0;
  for (int k = 0; k < 3; ++k) {
    const Vec3 edge = edges.col(k);
    largest = std::max(largest, (edge - edge.dot(tangent) * tangent).norm());
  }
  return largest;
}

Ring make_ring(double radius, double cell_size, const Vec3& tangent) {
  Ring ring;
  ring.radius = std::max(radius, 0.5 * cell_size);
  ring.points = std::max<Index>(8, static_cast<Index>(std::ceil(4.0 * std::numbers::pi * ring.radius / cell_size)));
  int smallest = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(tangent[k]) < std::abs(tangent[smallest])) smallest = k;
  const Vec3 axis = Vec3::Unit(smallest);
  ring.first = tangent.cross(axis).normalized();
  ring.second = tangent.cross(ring.first);
  return ring;
}

Compliance own_radius_law(double radius, double ring_radius, double cell_size, double viscosity,
                          const CellViscosity& cell) {
  const double ct = cell.viscous_tau;
  const double b_across = 0.175 - 0.32 * ct / std::sqrt(ct + 0.03) + 0.02 * std::min(cell.grad_div, 1.0);
  const double b_along = 0.15 + 0.015 * cell_size / ring_radius;
  const double least = smallest_compliance / viscosity;
  const double across = std::log((ring_radius + b_across * cell_size) / radius) / (4.0 * std::numbers::pi * viscosity);
  const double along = std::log((ring_radius + b_along * cell_size) / radius) / (2.0 * std::numbers::pi * viscosity);
  return {std::max(least, across), std::max(least, along)};
}

}  // namespace fbi::coupling
