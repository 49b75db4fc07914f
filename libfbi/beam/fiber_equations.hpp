/// Equations of motion of the fibers of one rank: what BeamField keeps and its parts work on.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "beam/band_lu.hpp"
#include "beam/end_conditions.hpp"
#include "beam/formulation.hpp"
#include "beam/generalized_alpha.hpp"
#include "beam/loads.hpp"
#include "beam/parameters.hpp"
#include "mesh/fiber_mesh.hpp"

namespace fbi::beam {

using NodalField = std::vector<double>;  ///< shape=(nodes,6)
using ElementMatrix = Eigen::Matrix<double, element_dofs, element_dofs, Eigen::RowMajor>;
using ElementVector = Eigen::Matrix<double, element_dofs, 1>;

/// Everything about one fiber that does not change.
struct Fiber {
  const ElementFormulation* formulation = nullptr;
  ElementProperties section;  // length is filled in for each element
  NodeConstraint start, end;
  Index first_node = 0, nodes = 0, first_element = 0;
  std::size_t band = 0;  // where its matrix starts

  std::size_t first_dof() const { return 6 * static_cast<std::size_t>(first_node); }
  Index dofs() const { return 6 * nodes; }
  /// Removes what supports hold from x, shape=(dofs,columns) row-major.
  void project(double* x, Index columns = 1) const;
};

/// Weights of one time level: G = M (inertia part) + internal (F - F_ext)_{n+1} + previous (F - F_ext)_n.
struct Level {
  bool dynamic = false;
  double dt = 0.0;
  double internal = 1.0, previous = 0.0;
  double inertia = 0.0;  // d a_level/d d_{n+1} [1/time^2]
};

/// All fibers of a rank: state, iterate, residuals, tangents and their factors. Fibers do not know each other.
struct FiberEquations {
  mesh::FiberMesh mesh;
  std::vector<FiberParameters> groups;
  BeamTimeParameters parameters;
  GeneralizedAlpha scheme;
  Loads loads;
  std::vector<Fiber> fibers;
  Index moving = 0;

  // state at t_n
  NodalField dofs_n, velocity_n, acceleration_n, internal_n, external_n, work_n;
  // iterate at t_{n+1}
  NodalField dofs, velocity, acceleration, internal, external;
  NodalField residual, full;  // G_b with and without the projection of the supports
  LoadValues load_values;
  Level level;
  bool evaluated = false;                // residual, internal and external belong to the iterate
  std::vector<double> scale, round_off;  // of each fiber: largest single force, level of round-off in the residual
  std::vector<double> band;              // matrices K_b or their factors, one fiber after the other
  std::vector<Index> pivot;
  std::vector<char> singular;

  FiberEquations(const mesh::FiberMesh& fiber_mesh, const std::vector<FiberParameters>& fiber_groups,
                 const BeamTimeParameters& time, const Vec3& gravity);

  const double* element_length(const Fiber& fiber) const { return &mesh.element_length[fiber.first_element]; }
  double shortest_element(const Fiber& fiber) const;

  /// Internal, inertial and external forces of one fiber and from them `full` and `residual`; K_b in the band on
  /// request.
  void evaluate(Index f, bool with_tangent);
  void evaluate_all(bool with_tangent);
  /// The consistent mass in the band instead of K_b.
  void assemble_mass(Index f);
  /// Factorises the band of one fiber; false when it is singular or not finite.
  bool factorize(Index f);
  /// b = K_b^-1 b with supports projected out, b of shape=(dofs,columns) row-major; not a number where K_b is singular.
  void solve(Index f, double* b, Index columns) const;
  /// Velocity and acceleration that belong to the iterate.
  void update_rates(const Fiber& fiber);
  /// Adds factor * delta, shape=(dofs), to the iterate.
  void add_increment(const Fiber& fiber, const double* delta, double factor);

 private:
  void assemble_element(const Fiber& fiber, Index e, ElementMatrix& matrix);
};

}  // namespace fbi::beam
