/// A fiber that moves as one body: Newton-Euler equations of its six degrees of freedom.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "beam/generalized_alpha.hpp"
#include "beam/loads.hpp"
#include "beam/supports.hpp"
#include "beam/turning.hpp"

namespace fbi::beam {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// Pose d_i = c + R r_i, t_i = R g_i with velocity v of the reference point c and body angular velocity W.
///
/// c is the center of mass, or the supported node. Balance at the level of generalised-alpha (forces averaged):
///
///   m a + R (A x S + W x (W x S)) = f ,   J A + W x J W + S x R^T a = tau     (S, J about c in the body; S = 0 for
///   free)
///
/// with R_{n+1} = R_n exp(psi); psi and W are joined by Newmark's formulas like displacement and velocity (Bruels,
/// Cardona 2010). J is that of the line plus rho_b I per length about axes across, 2 rho_b I about the tangent.
/// Wrenches are (force, body torque about c); forces of the coupling act on the pose between both ends of the step.
struct RigidFiber {
  bool active = false;
  // constants
  EndCondition support = EndCondition::free;
  double mass = 0.0;
  Vec3 first_moment = Vec3::Zero();
  Mat3 inertia = Mat3::Zero();
  Vec3 reference = Vec3::Zero(), guide = Vec3::Zero();
  std::vector<Vec3> offset;  ///< r_i and g_i in turn, shape=(2 nodes)
  // state at t_n and iterate
  struct State {
    Vec3 point = Vec3::Zero(), velocity = Vec3::Zero(), acceleration = Vec3::Zero();
    Mat3 rotation = Mat3::Identity();
    Vec3 spin = Vec3::Zero(), spin_rate = Vec3::Zero();
  };
  State last, now;
  Vec3 psi = Vec3::Zero();
  Mat3 middle = Mat3::Identity();      ///< R at the level of the scheme
  Vector6 wrench_n = Vector6::Zero();  ///< external - gyroscopic at t_n
  Vector6 residual = Vector6::Zero();
  Matrix6 tangent = Matrix6::Identity();
  Eigen::PartialPivLU<Eigen::MatrixXd> factors;
  Eigen::MatrixXd basis;  ///< directions the support leaves free, shape=(6,k)

  /// `dofs`: reference positions and tangents, shape=(nodes,6); `section_inertia` rho_b I [mass length].
  RigidFiber() = default;
  RigidFiber(const std::vector<double>& dofs, const std::vector<double>& element_length, double mass_per_length,
             double section_inertia, const std::vector<NodeSupport>& supports);

  Index nodes() const { return static_cast<Index>(offset.size() / 2); }
  /// Free directions at the present pose.
  void update_basis();
  /// Force and body torque of nodal forces, shape=(nodes,6), on the pose with rotation `rotation`.
  Vector6 wrench(const double* force, const Mat3& rotation) const;
  /// Nodal forces of least size with that wrench on the pose `middle`, shape=(nodes,6).
  void spread(const Vector6& wrench, double* force) const;
  /// Replaces nodal forces by those of least size with the same wrench in free directions.
  void project(double* force) const;
  /// Nodal increments, shape=(nodes,6), of a twist (translation, body rotation).
  void move(const Vector6& twist, double* increment) const;
  /// The twist whose increments are nearest to these.
  Vector6 twist_of(const double* increment) const;
  /// External minus gyroscopic wrench at a state, for external nodal forces and body couple.
  Vector6 balance(const State& state, const double* external, const Vec3& couple) const;

  /// Sets the state at t = 0 to the rigid velocity nearest to that of the nodes, shape=(nodes,6).
  void set_velocity(double* velocity);
  /// Predicts the step: velocity kept, supports moved.
  void begin_step(const GeneralizedAlpha& scheme, double dt, const NodeSupport* held);
  void update_rates(const GeneralizedAlpha& scheme, double dt, const NodeSupport* held);
  void turn_by(const Vector6& twist, double factor);
  /// Residual for external nodal forces and body couple at t_{n+1}, and its tangent on request.
  void evaluate(const GeneralizedAlpha& scheme, double dt, const double* external, const Vec3& couple,
                bool with_tangent);
  bool factorize();
  /// b = T K^-1 T^T b, shape=(dofs,columns) row-major.
  void solve(double* b, Index columns) const;
  /// Nodal positions, velocities and accelerations of a state, shape=(nodes,6) each.
  void fill(const State& state, double* dofs, double* velocity, double* acceleration) const;
  double kinetic_energy(const State& state) const;
  /// Acceleration that balances external forces at a state.
  void balance_at_start(const double* external, const Vec3& couple, const NodeSupport* held);
  /// The state as it stands in the arrays of a restart, 12 numbers each.
  void store(const State& state, double* pose, double* motion) const;
  State restore(const double* pose, const double* motion) const;
};

}  // namespace fbi::beam
