/// Equations of motion of the fibers of one rank: what BeamField keeps and its parts work on.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "beam/band_lu.hpp"
#include "beam/end_conditions.hpp"
#include "beam/fiber_batch.hpp"
#include "beam/formulation.hpp"
#include "beam/generalized_alpha.hpp"
#include "beam/loads.hpp"
#include "beam/parameters.hpp"
#include "beam/rigid_fiber.hpp"
#include "beam/supports.hpp"
#include "beam/triad_field.hpp"
#include "mesh/fiber_mesh.hpp"

namespace fbi::beam {

using NodalField = std::vector<double>;  ///< shape=(nodes,6)
using ElementMatrix = Eigen::Matrix<double, element_dofs, element_dofs, Eigen::RowMajor>;
using ElementVector = Eigen::Matrix<double, element_dofs, 1>;

/// Everything about one fiber that does not change.
struct Fiber {
  const ElementFormulation* formulation = nullptr;
  ElementProperties section;  // length is filled in for each element
  std::vector<NodeSupport> supports;
  bool prescribed = false;  // moves as formulas say
  bool placed = false;      // where formulas without time say
  bool moving_supports = false;
  double mass_damping = 0.0, stiffness_damping = 0.0;
  Index first_node = 0, nodes = 0, first_element = 0;
  std::size_t band = 0;  // where its matrix starts

  std::size_t first_dof() const { return 6 * static_cast<std::size_t>(first_node); }
  Index dofs() const { return 6 * nodes; }
  /// Removes what supports hold from forces or increments x, shape=(dofs,columns) row-major.
  void project(double* x, Index columns = 1) const;
  void project_increment(double* x, Index columns = 1) const;
  /// The support of a node, or null.
  const NodeSupport* support_at(Index node) const;
};

/// Weights of one time level: G = M (inertia part) + internal (F - F_ext)_{n+1} + previous (F - F_ext)_n. The
/// conserving scheme has one internal force F for the whole step in place of both.
struct Level {
  bool dynamic = false;
  bool conserving = false;
  double time = 0.0;  // t_{n+1}
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
  Frames frames;                  // empty without follower loads
  NodalField shift;               // accelerations of moved supports, NodeSupport::shift; empty without
  std::vector<RigidFiber> rigid;  // one for each fiber when the case has rigid ones, else empty
  NodalField pose_n, motion_n;    // their state at t_n: 12 numbers each of every rigid fiber; else empty
  bool any_rigid = false;         // some fiber of the case is rigid, on whichever rank
  bool at_start = false;          // initialised at t = 0 and no step accepted yet
  Level level;
  bool downhill = false;  // BeamField::set_downhill
  bool evaluated = false;                // residual, internal and external belong to the iterate
  std::vector<double> scale, round_off;  // of each fiber: largest single force, level of round-off in the residual
  std::vector<double> band;              // matrices K_b or their factors, one fiber after the other
  std::vector<Index> pivot;
  std::vector<char> singular;
  std::unique_ptr<TriadField> triads;  // rotations of simo_reissner fibers; null when no group has them
  std::unique_ptr<FiberBatches> batches;

  FiberEquations(const mesh::FiberMesh& fiber_mesh, const std::vector<FiberParameters>& fiber_groups,
                 const BeamTimeParameters& time, const Vec3& gravity);

  const double* element_length(const Fiber& fiber) const { return &mesh.element_length[fiber.first_element]; }
  bool is_rigid(Index f) const { return !rigid.empty() && rigid[f].active; }
  double shortest_element(const Fiber& fiber) const;
  bool has_triads(Index f) const { return triads != nullptr && triads->has(f); }

  /// Internal, inertial and external forces of one fiber and from them `full` and `residual`; K_b in the band on
  /// request.
  void evaluate(Index f, bool with_tangent);
  void evaluate_all(bool with_tangent);
  /// Factors after evaluate_all(true), of every fiber that has equations.
  void factorize_all();
  /// FiberEquations::round_off of a torsion_free fiber with the largest coordinate `coordinate`.
  double round_off_of(Index f, double coordinate) const;
  /// The consistent mass in the band instead of K_b.
  void assemble_mass(Index f);
  /// Adds to one diagonal entry of the band of one fiber; the supports are not looked at.
  void add_to_diagonal(Index f, Index dof, double value) {
    if (has_triads(f)) return triads->add_to_diagonal(*this, f, dof, value);
    band[fibers[f].band + band_entry(dof, dof)] += value;
  }
  /// EI [force length^2], the largest of both axes with triads.
  double bending_stiffness(Index f) const {
    return has_triads(f) ? triads->section[f].moment.tail<2>().maxCoeff() : fibers[f].section.bending_stiffness;
  }
  /// Stiffness of the springs at joints in statics: a position (part 0), tangent or triad held by one element.
  double joint_spring(Index f, int part) const {
    const double length = shortest_element(fibers[f]), stiffness = bending_stiffness(f);
    return part == 0 ? 12 * stiffness / (length * length * length) : 4 * stiffness / length;
  }
  /// Factorises the band of one fiber; false when it is singular or not finite.
  bool factorize(Index f);
  /// Starts the step of one fiber: motion of supports, of prescribed and of rigid fibers.
  void begin_step(Index f);
  /// The formulas FiberParameters::velocity at t = 0.
  void set_initial_velocity();
  /// Gives moved supports their rates at t = 0, once the size of the first step is known.
  void start_moving_supports(double dt);
  /// Makes poses of rigid fibers and frames of follower loads those at t_n.
  void accept_bodies_and_frames();
  RigidFiber::State rigid_state(Index f) const;
  /// What the support of a rigid fiber carries under the coupling force, shape=(dofs) or null, shape=(dofs).
  void rigid_reaction(Index f, const double* force, double* reaction) const;
  /// Rates of the supports and the acceleration that balances the forces on one fiber at t = 0, `force` of shape=(dofs)
  /// or null.
  void balance_at_start(Index f, const double* force);
  /// b = K_b^-1 b with supports projected out, b of shape=(dofs,columns) row-major; not a number where K_b is singular.
  void solve(Index f, double* b, Index columns) const;
  /// Number of unknowns: DoFs, and with triads their turns.
  Index unknowns(Index f) const { return (has_triads(f) ? 2 : 1) * fibers[f].dofs(); }
  /// The same for all unknowns, b of shape=(unknowns,columns).
  void solve_all(Index f, double* b, Index columns) const {
    if (has_triads(f))
      triads->solve_all(*this, f, b, columns);
    else
      solve(f, b, columns);
  }
  /// Velocity and acceleration that belong to the iterate.
  void update_rates(const Fiber& fiber);
  /// Makes the residual and the solves of linearised fibers those of the center line alone.
  void condense(Index f);
  /// Removes what supports hold, and for rigid fibers what rigidity carries, from nodal forces of shape=(dofs).
  void project(Index f, double* force) const;
  /// Adds factor * delta, shape=(dofs), to the iterate, without triads.
  void add_increment(const Fiber& fiber, const double* delta, double factor);

 private:
  void move_joined_nodes();
  void evaluate_rigid(Index f, bool with_tangent);
  Vec3 rigid_loads(Index f, const LoadValues& values, const RigidFiber::State& state, double* forces) const;
  void add_point_loads(Index f, Index e, ElementMatrix* tangent);
  void add_viscous(const Fiber& fiber, const ElementProperties& element, std::size_t dof, ElementVector& force,
                   ElementMatrix* tangent);
  void place_prescribed(const Fiber& fiber);
  void assemble_element(const Fiber& fiber, Index e, ElementMatrix& matrix);
};

}  // namespace fbi::beam
