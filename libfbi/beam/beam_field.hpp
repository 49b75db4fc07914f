/// All fibers of this rank: state, time integration, residuals, tangents and their factors.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "base/types.hpp"
#include "beam/parameters.hpp"
#include "mesh/fiber_mesh.hpp"

namespace fbi::beam {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Energies of this rank's fibers [force length].
struct Energy {
  double internal = 0.0, kinetic = 0.0, external_work = 0.0;
};

/// The fibers' fields. All nodal arrays have shape=(fiber nodes,6): position (or velocity, force) and tangent parts.
/// Forces conjugate to the tangent DoFs are generalised forces.
class BeamField {
 public:
  /// `groups[g]` describes fibers with fiber_mesh.group == g; gravity acts as rho_b A g.
  BeamField(const mesh::FiberMesh& fibers, const std::vector<FiberParameters>& groups, const BeamTimeParameters& time,
            const Vec3& gravity);
  ~BeamField();

  /// True when fiber `f` has no equations (fixed): its block of every solve is zero.
  bool is_fixed(Index fiber) const;
  /// Number of fibers on this rank that have equations.
  Index moving_fibers() const;

  /// Initial acceleration from equilibrium at t = 0 with coupling force `force` (zero at rest). Call once.
  void initialize(const std::vector<double>& force);

  /// Starts the step t_n -> t_{n+1} = time, sets the predictor as iterate. Calling it again restarts the same step.
  void begin_step(double time, double dt);
  /// c = gamma/(beta dt): change of end velocity per change of end displacement. 0 in statics.
  double velocity_per_displacement() const;
  double alpha_f() const;

  /// From the next linearisation on fibers that are solved in batches have L |D| L^T in place of K_b = L D L^T. The two
  /// differ where a fiber is compressed beyond buckling: Newton's method with K_b heads for the unstable solution of a
  /// step then, with |D| for the one that the fiber falls into, but not quadratically. Off at first.
  void set_downhill(bool downhill);
  /// Evaluates residual G_b (without any coupling force, internal - external + inertia, at the generalised-alpha level)
  /// and factorises K_b of every fiber at the current iterate. Constrained rows of G_b are zero.
  void linearize();
  /// The residual alone, which costs a third; with triads or joints it is that of linearize(), which is called. Solves
  /// go on with the factors of the last linearisation.
  void evaluate();
  /// True after linearize() until the iterate changes.
  bool is_linearized() const;
  /// Fibers with triads: G_b is what remains after the triads are eliminated, so that K_b^-1 G_b is the center-line
  /// part of the increment of all unknowns.
  const std::vector<double>& residual() const;
  /// Sum over this rank of the squared residuals of the triads' equations, moments divided by the element length: what
  /// the elimination takes out of G_b. Zero without triads.
  double squared_moment_residual() const;
  /// Largest single force entering the residual (internal, inertial, external), for relative tests.
  double force_scale() const;
  /// Size of the force that round-off leaves in the residual of the worst fiber: what no iteration can undercut
  /// [force].
  double round_off() const;
  /// x = K_b^-1 b for one fiber, b and x of shape=(6*nodes of the fiber); constrained entries of x are zero. In place.
  void solve(Index fiber, double* b) const;
  /// The same for all fibers, b of shape=(nodes,6); those that joints hold together move together, and gaps that their
  /// constraints have are closed.
  void solve(std::vector<double>& b);
  /// compliance() of a group of joined fibers (FiberMesh::joined): `d[i]` and `rows[i]` of its fiber i, rows of the
  /// fibers one after the other.
  void compliance_joined(Index group, const std::vector<const double*>& d, const std::vector<Index>& rows,
                         RowMatrix& block) const;
  /// Sum over the groups of this rank of the squared gaps of their joints, as forces [force^2].
  double squared_joint_residual() const;
  /// Removes the part of a force in constrained directions, shape=(nodes,6): what supports carry.
  void remove_constrained(std::vector<double>& force) const;
  /// block = D K_b^-1 D^T, shape=(3*rows,3*rows), multiplier entries ordered (row, direction). `d` is row-major
  /// shape=(rows, 2*nodes): d_1, t_1, d_2, ..., the same for each direction.
  void compliance(Index fiber, const double* d, Index rows, RowMatrix& block) const;
  /// compliance() of all fibers that have equations and are not joined, several at a time: `d` and `rows` of each
  /// fiber, shape=(fibers); `take` is called once for each, in any order.
  void compliances(const std::vector<const double*>& d, const std::vector<Index>& rows,
                   const std::function<void(Index, const Eigen::Ref<const RowMatrix>&)>& take) const;
  /// Adds an increment to the iterate and updates end velocity and acceleration with it. Joints go along by what the
  /// last solve() of all fibers found, triads turn by what the last linearisation at this iterate says, which is made
  /// if there is none.
  void increment(const std::vector<double>& delta);

  /// Newton per fiber with the coupling force entering the residual as -force (already weighted w f_{n+1} + (1-w) f_n),
  /// from the current iterate; where it fails the residual at d_n is removed in portions. Returns the largest number of
  /// iterations; -1 when a fiber did not converge (the same on all ranks). Collective.
  int solve_step(const std::vector<double>& force);

  void accept_step();

  const std::vector<double>& dofs() const;           ///< iterate d_{n+1}
  const std::vector<double>& velocity() const;       ///< iterate v_{n+1}
  const std::vector<double>& acceleration() const;   ///< iterate a_{n+1}
  const std::vector<double>& accepted_dofs() const;  ///< d_n
  const std::vector<double>& accepted_velocity() const;
  const std::vector<double>& accepted_acceleration() const;

  /// Reaction of supports at the generalised-alpha level of the current iterate: residual of constrained DoFs including
  /// the coupling force `force` (weighted), shape=(nodes,6), zero elsewhere. Position parts are forces exerted on the
  /// fiber. Tangent parts are generalised forces f, the moment t x f; at clamped triads they are the moment itself,
  /// with its part about the fiber, in the axes x, y, z [force length].
  std::vector<double> reactions(const std::vector<double>& force) const;
  /// Position columns of the consistent mass times a nodal rate: total linear momentum of this rank's fibers.
  Vec3 linear_momentum(const std::vector<double>& rate) const;
  Energy energy() const;
  /// Highest vibration frequency of the stiffest element, omega [1/time], an estimate for reports.
  double highest_frequency() const;

  /// State arrays (all that a restart needs) by name, each of shape=(nodes,6), to save and to restore bitwise.
  std::vector<std::pair<std::string, std::vector<double>*>> state();

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace fbi::beam
