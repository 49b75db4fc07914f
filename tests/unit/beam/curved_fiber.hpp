/// Curved fibers and sections with given stiffness for tests, without a case file.
#pragma once

#include <array>

#include "beam/fiber_equations.hpp"
#include "unit/beam/straight_fiber.hpp"

namespace fbi::test {

/// A fiber whose nodes lie at equal arc lengths on position(s), 0 <= s <= length, with unit tangents tangent(s).
template <class Position, class Tangent>
mesh::FiberMesh curved_fiber(const Position& position, const Tangent& tangent, double length, Index elements) {
  mesh::FiberMesh mesh = straight_fiber({0, 0, 0}, {1, 0, 0}, length, elements);
  for (Index node = 0; node <= elements; ++node) {
    const Vec3 x = position(length * node / elements), g = tangent(length * node / elements);
    for (int k = 0; k < 3; ++k) {
      mesh.position[3 * static_cast<std::size_t>(node) + k] = x[k];
      mesh.tangent[3 * static_cast<std::size_t>(node) + k] = g[k];
    }
  }
  return mesh;
}

/// An arc of the circle of this radius in the plane x, y that begins at the origin along x and bends to y.
inline mesh::FiberMesh arc(double radius, double angle, Index elements) {
  return curved_fiber(
      [=](double s) { return Vec3(radius * std::sin(s / radius), radius * (1 - std::cos(s / radius)), 0); },
      [=](double s) { return Vec3(std::cos(s / radius), std::sin(s / radius), 0); }, radius * angle, elements);
}

/// A beam with shear and torsion from E, G, k, A, I2, I3, J and rho_b.
inline beam::FiberParameters shear_beam(double young, double shear_modulus, double correction, double area,
                                        double inertia_2, double inertia_3, double torsion, double density = 1.0) {
  beam::FiberParameters group;
  group.name = "fiber";
  group.formulation = beam::Formulation::simo_reissner;
  group.material = {.young = young, .density = density, .shear_modulus = shear_modulus};
  group.section.area = area;
  group.section.inertia_2 = inertia_2;
  group.section.inertia_3 = inertia_3;
  group.section.torsion = torsion;
  group.section.shear_correction = correction;
  return group;
}

/// The same, round, of this radius and Poisson's ratio.
inline beam::FiberParameters round_shear_beam(double young, double poisson, double correction, double radius,
                                              double density = 1.0) {
  beam::FiberParameters group = shear_beam(young, young / (2 * (1 + poisson)), correction, 0, 0, 0, 0, density);
  group.section.radius = radius;
  return group;
}

}  // namespace fbi::test
