/// Parameters of the coupled solution: scheme, geometry update, tolerances, time steps. Free of PETSc and MPI.
#pragma once

#include <optional>
#include <string>

#include "base/types.hpp"
#include "fluid/parameters.hpp"

namespace fbi::fsi {

enum class Scheme { monolithic, constant, aitken, newton_krylov, iqn_ils };
enum class Direction {
  two_way,
  fluid_only,  ///< the fluid feels the fibers, which move by their own loads and supports
  fiber_only   ///< the fibers feel the fluid, which flows as without them
};
enum class GeometryUpdate {
  lagged,        ///< D, M, kappa from the positions at t_n
  extrapolated,  ///< from 2 d_n - d_{n-1}
  iterated       ///< from the current iterate
};
/// The interaction force that the iteration of a partitioned scheme starts from.
enum class ForcePredictor {
  constant = 0,  ///< f_n
  linear = 1,    ///< 2 f_n - f_{n-1} for steps of one size
  quadratic = 2  ///< 3 f_n - 3 f_{n-1} + f_{n-2} for steps of one size
};
/// How newton_krylov evaluates the fields for the differences of the Jacobian.
enum class Differences {
  linearized,  ///< one linear solve of each field about the current iterate
  nonlinear    ///< both fields solved again
};
enum class LinearSolver {
  automatic,  ///< direct for steady flow below 150,000 unknowns, else iterative
  direct,
  iterative,
  reference  ///< assembled matrix, GMRES with ILU: to compare with
};
/// Numbers in the iterations of linear solves; residuals of the equations are always in double precision.
enum class Precision {
  mixed,   ///< single precision, refined where more is asked for
  twofold  ///< double precision
};
enum class CouplingWeight {
  theta,              ///< w = theta of the fluid: fluid and fiber receive the same impulse
  one_minus_alpha_f,  ///< the paper's choice
};

struct SchemeParameters {
  Scheme scheme = Scheme::monolithic;
  GeometryUpdate geometry_update = GeometryUpdate::lagged;
  CouplingWeight coupling_weight = CouplingWeight::theta;
  double tolerance = 1e-6;            ///< partitioned: change of the interaction force, relative; absolute part below
  double absolute_tolerance = 1e-12;  ///< the same, per sqrt(N)
  Index max_iterations = 100;         ///< partitioned
  double relaxation = 0.1;            ///< constant; first factor of aitken and iqn_ils
  Direction direction = Direction::two_way;
  bool implicit_penalty = false;  ///< partitioned: epsilon D^T kappa^-1 D v_b stays in the equations of the fibers
  ForcePredictor force_predictor = ForcePredictor::linear;  ///< partitioned
  Differences differences = Differences::linearized;        ///< newton_krylov
  double gamma = 1e-4;                                      ///< newton_krylov: parameter of the difference step
  double krylov_tolerance = 1e-2;                           ///< newton_krylov: |J dx + r| <= this |r|
  Index krylov_iterations = 50;                             ///< newton_krylov: largest dimension of the Krylov space
  Index reuse = 10;                                         ///< iqn_ils: earlier steps whose columns are kept
  double filter = 1e-2;  ///< iqn_ils: columns with a smaller independent part are dropped, relative
};

struct SolverParameters {
  LinearSolver linear = LinearSolver::automatic;
  fluid::Linearization nonlinear = fluid::Linearization::newton;
  double newton_tolerance = 0.0;             ///< residual relative to the first of the step; 0: chosen
  double newton_absolute_tolerance = 1e-12;  ///< absolute, rms per unknown
  Index newton_iterations = 15;              ///< steady flow: ten times as many
  double krylov_tolerance = 0.0;             ///< relative, per linear solve; 0: chosen
  Precision precision = Precision::mixed;
  Index krylov_iterations = 200;  ///< per linear solve; ten times as many for reference
  Index ilu_level = 0;            ///< reference: levels of fill
  Index gmres_restart = 100;      ///< reference: directions kept
};

/// The parameters with tolerances chosen where they were left open. newton_tolerance: for one solution of fluid and
/// fibers together in a time step that starts from an extrapolation 2.2e-2, or 1e-3 where the time scheme is of second
/// order, whose error is as much smaller; 1e-6 for everything else (steady flow, partitioned schemes, fibers alone).
/// krylov_tolerance: 1.1e-2 and 5e-4 with the former, 1e-4 otherwise and beside a newton_tolerance that is given.
/// @param extrapolated  time steps solved in one Newton iteration on all fields
inline SolverParameters with_tolerances(SolverParameters parameters, bool extrapolated, bool second_order) {
  const bool loose = parameters.newton_tolerance == 0.0 && extrapolated;
  if (parameters.newton_tolerance == 0.0)
    parameters.newton_tolerance = !extrapolated ? 1e-6 : second_order ? 1e-3 : 2.2e-2;
  if (parameters.krylov_tolerance == 0.0) parameters.krylov_tolerance = !loose ? 1e-4 : second_order ? 5e-4 : 1.1e-2;
  return parameters;
}

struct TimeParameters {
  double step = 0.0;  ///< dt [time]
  double end = 0.0;   ///< [time]
  /// The run ends when the root mean square of dv/dt fell below this times that of v [1/time]; 0 = never.
  double steady_tolerance = 0.0;
  Index halvings = 4;  ///< a step that does not converge is repeated in parts of at least step/2^halvings
};

}  // namespace fbi::fsi
