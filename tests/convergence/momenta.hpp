/// Linear and angular momentum of a fiber, and orders of convergence.
#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "beam/formulation.hpp"
#include "unit/beam/straight_fiber.hpp"

namespace fbi::test {

/// Angular momentum about the origin of the line, int rho A r x v ds, of positions and velocities shape=(nodes,6).
inline Vec3 angular_momentum(const mesh::FiberMesh& mesh, double mass_per_length, const std::vector<double>& dofs,
                             const std::vector<double>& velocity) {
  const beam::ElementFormulation& formulation = *beam::element_formulation(beam::Formulation::torsion_free);
  beam::ElementProperties element;
  element.mass_per_length = mass_per_length;
  Vec3 sum = Vec3::Zero();
  for (Index e = 0; e < mesh.elements(); ++e) {
    element.length = mesh.element_length[e];
    Eigen::Matrix<double, 12, 12, Eigen::RowMajor> mass;
    formulation.mass(element, mass.data());
    const Eigen::Matrix<double, 12, 1> p = mass * Eigen::Map<const Eigen::Matrix<double, 12, 1>>(&velocity[6 * e]);
    for (int i = 0; i < 4; ++i) sum += Vec3(&dofs[6 * e + 3 * i]).cross(Vec3(p.segment<3>(3 * i)));
  }
  return sum;
}

/// A quarter of a circle in the xy plane with `elements` arc-length consistent elements.
inline mesh::FiberMesh quarter_circle(double radius, Index elements) {
  mesh::FiberMesh mesh = straight_fiber({0, 0, 0}, {1, 0, 0}, 0.5 * M_PI * radius, elements);
  for (Index node = 0; node <= elements; ++node) {
    const double angle = 0.5 * M_PI * node / elements;
    const double x[6] = {
        radius * std::sin(angle), radius * (1 - std::cos(angle)), 0, std::cos(angle), std::sin(angle), 0};
    for (int k = 0; k < 3; ++k) {
      mesh.position[3 * node + k] = x[k];
      mesh.tangent[3 * node + k] = x[3 + k];
    }
  }
  return mesh;
}

inline input::VectorExpression formulas(const std::string& x, const std::string& y, const std::string& z) {
  return {input::Expression(x), input::Expression(y), input::Expression(z)};
}

inline double order(double coarse, double fine) { return std::log2(coarse / fine); }

}  // namespace fbi::test
