/// Linear solver of the fluid with the multiplier term: (A_FF + M^T S^-1 M) x = b.
#pragma once

#include <memory>
#include <vector>

#include "coupling/coupling.hpp"
#include "coupling/interface_operator.hpp"
#include "fluid/fluid_field.hpp"
#include "fsi/assembled_system.hpp"
#include "fsi/extended_system.hpp"
#include "fsi/parameters.hpp"
#include "fsi/pressure_block.hpp"
#include "fsi/single_solver.hpp"
#include "fsi/velocity_lines.hpp"
#include "fsi/velocity_weight.hpp"
#include "linalg/krylov.hpp"
#include "linalg/multiplier_factor.hpp"

namespace fbi::fsi {

/// out (rows,3) = M u. Ghosts of u must be up to date. Collective.
void interpolate(const coupling::Coupling& coupling, Vec u, std::vector<double>& out);

/// Whether linear systems of the fluid are factorised: few unknowns, or on request.
bool solves_directly(const SolverParameters& parameters, const fluid::FluidField& fluid);

/// Solves with the tangent of the fluid at its linearisation point, with or without fibers.
///
/// Iterative: FGMRES with a pressure-splitting block preconditioner. The velocity block is (W^-1 + M^T S^-1 M)^-1 with
/// the diagonal W of VelocityWeight, by Woodbury, or in single precision with VelocityLines in its place; it
/// is applied after the pressure operator, the Laplacian divided by rho sigma with a Robin condition at open faces,
/// which is solved exactly on boxes and by one multigrid cycle elsewhere; the inverse lumped mass times 2 mu (and a
/// part of tau_C) is added to it. With the pressure projection its action on smooth pressures, a Laplacian with
/// coefficient c h^2/12, is part of the pressure operator. The continuity rows are scaled by rho sigma h, which gives
/// all rows the unit of a force.
///
/// Iterations run in single precision (SingleSolver) where the equations allow it; what is asked for beyond its digits
/// comes by refinement: residuals in double, corrections in single precision. Where that does not get on, and with
/// `precision: "double"`, the double precision iteration described above takes over.
///
/// Direct (few unknowns, or on request): the system with the multipliers as extra unknowns, factorised.
///
/// Reference (on request): everything assembled, GMRES with ILU.
class FluidSolver {
 public:
  /// `coupling` and `interface` are null without fibers. Collective.
  FluidSolver(fluid::FluidField& fluid, const coupling::Coupling* coupling,
              const coupling::InterfaceOperator* interface, const SolverParameters& parameters);
  ~FluidSolver();

  /// True when the direct solver was chosen.
  bool is_direct() const { return direct_ != nullptr; }
  /// Scale of continuity rows that makes them comparable with momentum rows: rho sigma h; for steady flow rho |v| +
  /// mu/h of the first iterate.
  double continuity_scale() const;

  /// Iterates in single precision where the equations have it.
  bool is_single() const {
    return direct_ == nullptr && reference_ == nullptr && parameters_.precision == Precision::mixed;
  }
  /// Readies preconditioner or factors for the present linearisation point, M and S. Returns false (on all ranks) when
  /// a factorisation failed. Collective.
  /// @param geometry_changed   M is not what it was
  /// @param interface_changed  nor S
  /// @param anew               nothing that is kept of them serves any longer
  bool prepare(bool geometry_changed, bool interface_changed, bool anew = false);

  /// x = (A + M^T S^-1 M)^-1 b to `tolerance`; b in unscaled rows. Collective.
  linalg::KrylovResult solve(Vec b, Vec x, double tolerance);

  /// Vectors for who solves with this, kept from step to step.
  Vec residual() const { return residual_; }
  Vec increment() const { return increment_; }

  /// Where no face fixes the pressure level, removes from the continuity rows of a residual what no solution can
  /// balance (their mean, the net flux through the boundary); returns that mean. Collective.
  double project_residual(Vec r) const;
  /// r += M^T lambda in all rows that are not Dirichlet (or in all rows). Collective.
  void add_spread(const std::vector<double>& lambda, Vec r, bool dirichlet_rows = false) const;

 private:
  void apply_operator(Vec x, Vec y);
  void apply_preconditioner(Vec r, Vec x);
  void velocity_block(const double* r, double* x);
  bool renew_velocity(bool geometry_changed, bool interface_changed, bool anew);
  std::vector<double> sums_of_columns() const;
  bool renew_factor(bool of_lines);
  void prepare_single();
  linalg::KrylovResult iterate_single(Vec x, double tolerance, int maximum, bool impatient);
  linalg::KrylovResult iterate(Vec x, double tolerance, int maximum, bool impatient);
  void remove_mean_pressure(Vec x) const;

  fluid::FluidField& fluid_;
  const coupling::Coupling* coupling_;
  const coupling::InterfaceOperator* interface_;
  SolverParameters parameters_;
  Comm comm_;

  linalg::KrylovResult solve_single(Vec b, Vec x, double tolerance, int maximum, bool impatient);

  // Iterative.
  std::unique_ptr<linalg::Krylov> krylov_;
  std::unique_ptr<PressureBlock> pressure_;
  double steady_scale_ = 1.0;
  std::unique_ptr<SingleSolver> single_;
  std::vector<float> single_right_, single_solution_;
  double factor_sigma_ = -1.0;  // that the direct factors were made for
  std::unique_ptr<VelocityWeight> weight_;
  /// Sweeps with W have V of the lines between them.
  bool smooths_with_lines() const;
  /// mu/(rho sigma h^2) is large in the cells of fibers. Collective.
  bool is_viscous() const;
  /// Whether lines stand for W: they rest after solves that did not converge with them, and in fast flow around fibers.
  bool uses_lines() const { return lines_ != nullptr && lines_rest_ == 0 && !is_fast_; }
  std::unique_ptr<VelocityLines> lines_;  // in single precision
  bool lines_current_ = false;            // renewed with W
  bool is_viscous_ = false;               // is_viscous() of this preparation
  bool is_fast_ = false;                  // fast flow around fibers, from which lines keep away
  int lines_rest_ = 0;                    // preparations until they are tried again
  int next_rest_ = 8;                     // after the next solve without convergence
  bool factor_of_lines_ = false;          // factor_ has the diagonal of lines_ in place of W
  linalg::MultiplierFactor factor_;
  bool exact_factor_ = false;    // from now on sparse factors in any case
  bool factor_follows_ = false;  // without lines a new one with every S from now on: one for an earlier S has failed
  /// How the factor of the multipliers ages: it is kept while S and W change and iterations stay few, with lines while
  /// M changes as well.
  struct FactorAge {
    Index rows = -1;            // of this rank when it was made
    double sigma = 0.0;         // then
    bool exact = false;         // made for the present M and S
    double fresh_effort = 0.0;  // iterations a decade of the first solve after
    double effort = 0.0;        // of the last solve
    double fresh_steps = 0.0;   // for the multipliers of lines in the first solve after, in the mean
    double lost_steps = 0.0;    // more than that since
  } age_;
  linalg::VecHandle ghosted_, work_, scaled_, residual_, increment_;
  linalg::VecHandle pressure_right_, pressure_solution_;
  mutable std::vector<double> rows_;  // shape=(rows,3)

  std::unique_ptr<ExtendedSystem> direct_;
  std::unique_ptr<AssembledSystem> reference_;  // both null = iterative
};

}  // namespace fbi::fsi
