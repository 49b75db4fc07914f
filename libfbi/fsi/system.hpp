/// The parts of a coupled problem that every scheme works on, and what a step reports.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "beam/beam_field.hpp"
#include "coupling/coupling.hpp"
#include "coupling/interface_operator.hpp"
#include "fluid/fluid_field.hpp"
#include "fsi/fluid_solver.hpp"
#include "fsi/parameters.hpp"
#include "mesh/fiber_mesh.hpp"

namespace fbi::fsi {

/// Residual norms of one iterate, relative to the references of the step.
struct ResidualNorms {
  double fluid = 0.0;       ///< momentum and scaled continuity rows
  double fiber = 0.0;       ///< equilibrium of the fibers
  double constraint = 0.0;  ///< M v - D v_b - kappa/epsilon lambda, relative to kappa times the largest velocity
};

/// What one step reports. The same on every rank.
struct StepReport {
  bool converged = false;
  int newton = 0;               ///< nonlinear iterations of the fluid (or of the whole monolithic system)
  int krylov = 0;               ///< Krylov iterations, all linear solves together
  int coupling_iterations = 0;  ///< of a partitioned scheme; 1 for monolithic
  int evaluations = 0;          ///< solutions of both fields, each one solve of the fluid and one of the fibers
  int interface_krylov = 0;     ///< Krylov iterations of newton_krylov on the interface
  int parts = 1;                ///< that the step was done in
  int failures = 0;             ///< attempts that did not converge, repeated with a smaller part
  double residual = 0.0;        ///< largest of the norms that the step ended with
  double relaxation = 0.0;      ///< last relaxation factor of a partitioned scheme
  std::vector<ResidualNorms> history;
};

/// Fluid, fibers and what joins them; any of them may be missing. Owns everything that belongs to the interface.
/// Norms of the forces in a flow.
struct FluidScale {
  double momentum = 0.0;  ///< (rho sigma V + mu h) |v|, sigma = 0 when steady
  double forces = 0.0;    ///< that and h^2 |p|, which holds body forces where nothing flows: of this order is round-off
};

class System {
 public:
  /// `fluid` may be null (fibers alone), `beams` may be null (fluid alone). `density` weight etc. come from the
  /// parameters.
  System(fluid::FluidField* fluid, beam::BeamField* beams, const mesh::FiberMesh* fibers,
         const coupling::CouplingParameters& coupling_parameters, const SchemeParameters& scheme,
         const SolverParameters& solver);

  bool has_fluid() const { return fluid_ != nullptr; }
  bool has_fibers() const { return beams_ != nullptr; }
  bool is_coupled() const { return coupling_ != nullptr; }
  /// Some fiber on some rank has equations to solve.
  bool fibers_move() const { return fibers_move_; }
  /// The fibers act on the fluid; false with direction fiber_only.
  bool fluid_feels_fibers() const { return is_coupled() && scheme_.direction != Direction::fiber_only; }
  /// Fibers move by the force of the fluid; false where none moves and with direction fluid_only.
  bool fibers_follow() const { return is_coupled() && fibers_move_ && scheme_.direction != Direction::fluid_only; }
  /// Some fibers on some rank are joined.
  bool has_joints() const { return has_joints_; }

  /// Starts the step in both fields and renews what depends on the step. Collective.
  void begin_step(double time, double dt);
  /// Makes iterate and multipliers the accepted state.
  void accept_step();
  /// Weight w of lambda_{n+1} in the fibers' equation for this step.
  double weight() const;

  /// D, M, kappa at the positions `dofs`; nothing is done when they are those of the last call. Returns whether they
  /// changed. Collective.
  bool update_geometry(const std::vector<double>& dofs);
  /// Positions that the coupling terms of this step start from: d_n, or 2 d_n - d_{n-1} when extrapolated, or the
  /// iterate when iterated; shape=(fiber nodes,6).
  std::vector<double> first_positions() const;
  /// out = M u, shape=(rows,3) [velocity length]; ghosts of u up to date. Collective.
  void interpolate(Vec u, std::vector<double>& out) const;
  /// Forget what the last geometry was built from (after a restart, or to make a checkpoint reproducible).
  void drop_caches();

  /// What the solver keeps of M, S and the sizes of steps is to be renewed before its next solution: after a change of
  /// dt, and when mark_stale was called because it serves badly. Asking clears it.
  bool take_staleness();
  void mark_stale() { stale_ = true; }

  /// w f_{n+1} + (1-w) f_n with f = D^T lambda for multipliers `lambda`, shape=(fiber nodes,6).
  std::vector<double> fiber_force(const std::vector<double>& lambda) const;
  /// Slip M v - D v_b of the iterates, shape=(rows,3). Collective.
  std::vector<double> slip() const;
  /// Largest slip per row over kappa, and the largest fluid speed it compares with: returns their ratio. Collective.
  double constraint_violation() const;
  /// R(u) + M^T lambda with the unbalanced part of continuity removed. Collective.
  /// @param linearize  as in FluidField::residual
  void fluid_residual(const std::vector<double>& lambda, Vec r, bool linearize = false) const;
  /// 2-norm of a fluid residual, continuity rows scaled. Collective.
  double fluid_norm(Vec r) const;
  /// What residuals of the fluid are measured against. Collective.
  FluidScale fluid_scale() const;

  fluid::FluidField& fluid() const { return *fluid_; }
  beam::BeamField& beams() const { return *beams_; }
  const mesh::FiberMesh& fibers() const { return *fibers_; }
  coupling::Coupling& coupling() const { return *coupling_; }
  coupling::InterfaceOperator& interface() const { return *interface_; }
  FluidSolver& solver() const { return *solver_; }
  const SchemeParameters& scheme() const { return scheme_; }
  const SolverParameters& solver_parameters() const { return solver_parameters_; }
  const coupling::CouplingParameters& coupling_parameters() const { return coupling_parameters_; }
  const Comm& comm() const { return comm_; }

  std::vector<double>& lambda() { return lambda_; }  ///< iterate, shape=(rows,3) [force/length]
  const std::vector<double>& lambda() const { return lambda_; }
  std::vector<double>& force_old() { return force_old_; }  ///< D^T lambda_n, shape=(fiber nodes,6)
  const std::vector<double>& force_old() const { return force_old_; }
  /// The coupling force w f_{n+1} + (1-w) f_n in the fibers' equation of the last accepted step, shape=(fiber nodes,6).
  const std::vector<double>& last_force() const { return last_force_; }
  /// D^T lambda_{n-1} and D^T lambda_{n-2}, shape=(fiber nodes,6): the predictor of the force uses them.
  std::vector<double>& force_older() { return force_older_; }
  const std::vector<double>& force_older() const { return force_older_; }
  std::vector<double>& force_oldest() { return force_oldest_; }
  const std::vector<double>& force_oldest() const { return force_oldest_; }
  /// d_n - d_{n-1}, shape=(fiber nodes,6).
  std::vector<double>& last_motion() { return last_motion_; }
  const std::vector<double>& last_motion() const { return last_motion_; }
  /// Those arrays by name, and the sizes of the last two steps: what a restart needs of the interface.
  std::vector<std::pair<std::string, std::vector<double>*>> fiber_state();
  std::vector<std::pair<std::string, double*>> scalars() {
    return {{"dt_last", &last_dt_}, {"dt_before_last", &older_dt_}};
  }
  /// Weights of f_n, f_{n-1}, f_{n-2} in the polynomial of `degree` 0, 1 or 2 through them at t_{n+1}, for the sizes
  /// that the steps have.
  std::array<double, 3> extrapolation(int degree) const;
  /// The line force of lambda_n at the nodes for output, shape=(fiber nodes,3).
  std::vector<double> line_force() const;
  /// It, where it cannot be taken from lambda_n any more once the positions change; else empty.
  std::vector<double>& saved_line_force() { return line_force_; }
  std::vector<double>& lambda_old() { return lambda_old_; }
  /// lambda_n for output, shape=(rows of that step,3). No solution depends on it: the number of rows may change.
  const std::vector<double>& lambda_old() const { return lambda_old_; }

 private:
  /// Throws Error(usage) for groups of joined fibers whose block of S would be too large. Collective.
  void check_group_sizes() const;
  /// Says once that the interface law is used beyond its calibration. Collective.
  void warn_of_fast_flow();
  /// tau_M mu/h^2 and tau_C/mu of every local cell at the present tau.
  std::vector<coupling::CellViscosity> stabilization() const;

  fluid::FluidField* fluid_;
  beam::BeamField* beams_;
  const mesh::FiberMesh* fibers_;
  coupling::CouplingParameters coupling_parameters_;
  SchemeParameters scheme_;
  SolverParameters solver_parameters_;
  Comm comm_;
  std::unique_ptr<coupling::Coupling> coupling_;
  std::unique_ptr<coupling::InterfaceOperator> interface_;
  std::unique_ptr<FluidSolver> solver_;
  std::vector<float> node_size_;  // cube root of the lumped volume [length], shape=(owned nodes of the fluid)
  bool fibers_move_ = false;
  bool has_joints_ = false;
  bool has_geometry_ = false;
  bool warned_of_fast_flow_ = false;
  std::vector<double> geometry_dofs_;
  std::vector<double> lambda_, lambda_old_;
  std::vector<double> force_old_, force_older_, force_oldest_, last_force_, last_motion_;
  std::vector<double> line_force_;  // of lambda_old_, for bases without fixed rows
  bool stale_ = false;
  double solver_dt_ = -1.0;                           // that the solver was renewed for
  double dt_ = 0.0, last_dt_ = 0.0, older_dt_ = 0.0;  // of this step and of accepted ones; 0: none
};

}  // namespace fbi::fsi
