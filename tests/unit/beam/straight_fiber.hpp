/// Straight fibers and their parameters for tests, without a case file.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "beam/beam_field.hpp"

namespace fbi::test {

/// Appends a straight fiber of `elements` equal elements from `from` along the unit vector `direction`.
inline void add_straight_fiber(mesh::FiberMesh& mesh, const Vec3& from, const Vec3& direction, double length,
                               Index elements, Index group = 0) {
  if (mesh.first_node.empty()) mesh.first_node.push_back(0);
  mesh.fiber_id.push_back(mesh.fibers());
  mesh.name.push_back("fiber/" + std::to_string(mesh.fiber_id.back()));
  mesh.group.push_back(group);
  mesh.first_node_id.push_back(mesh.first_node.back());
  for (Index node = 0; node <= elements; ++node) {
    const Vec3 x = from + direction * (length * node / elements);
    for (int k = 0; k < 3; ++k) {
      mesh.position.push_back(x[k]);
      mesh.tangent.push_back(direction[k]);
    }
  }
  for (Index e = 0; e < elements; ++e) mesh.element_length.push_back(length / elements);
  mesh.first_node.push_back(mesh.first_node.back() + elements + 1);
  mesh.global_fibers = mesh.fibers();
  mesh.global_nodes = mesh.nodes();
  mesh.global_elements = mesh.elements();
}

inline mesh::FiberMesh straight_fiber(const Vec3& from, const Vec3& direction, double length, Index elements) {
  mesh::FiberMesh mesh;
  add_straight_fiber(mesh, from, direction, length, elements);
  return mesh;
}

/// A section with given EA, EI and rho_b A: E = 1, A = EA, I = EI, rho_b = mass/A.
inline beam::FiberParameters stiffness(double axial, double bending, double mass_per_length = 1.0) {
  beam::FiberParameters group;
  group.name = "fiber";
  group.material.young = 1.0;
  group.section.area = axial;
  group.section.inertia = bending;
  group.material.density = mass_per_length / axial;
  return group;
}

inline beam::Load load(beam::LoadType type, const Vec3& value, beam::End at = beam::End::end) {
  beam::Load load;
  load.type = type;
  load.at = at;
  load.value = {value[0], value[1], value[2]};
  return load;
}

/// Result of a static solution in equal load steps.
struct StaticSolution {
  std::vector<double> dofs;
  int most_iterations = 0;
  int all_iterations = 0;
  bool converged = true;
  Vec3 tip() const { return Vec3(&dofs[dofs.size() - 6]); }
};

inline StaticSolution solve_static(const mesh::FiberMesh& mesh, const beam::FiberParameters& group, int load_steps,
                                   const Vec3& gravity = Vec3::Zero()) {
  beam::BeamTimeParameters time;
  time.scheme = beam::TimeScheme::static_;
  beam::BeamField field(mesh, {group}, time, gravity);
  field.initialize({});
  StaticSolution solution;
  for (int step = 1; step <= load_steps; ++step) {
    field.begin_step(static_cast<double>(step) / load_steps, 1.0 / load_steps);
    const int iterations = field.solve_step({});
    if (iterations < 0) {
      solution.converged = false;
      break;
    }
    solution.most_iterations = std::max(solution.most_iterations, iterations);
    solution.all_iterations += iterations;
    field.accept_step();
  }
  solution.dofs = field.accepted_dofs();
  return solution;
}

}  // namespace fbi::test
