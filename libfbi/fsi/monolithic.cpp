#include "fsi/monolithic.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/timer.hpp"
#include "fsi/condensation.hpp"

namespace fbi::fsi {
namespace {

// Factors of M are kept while the flow changes, until a linear solve takes more iterations than this.
constexpr int many_iterations = 40;
// Fibers are stiff along their axis and cheap: they are solved to at least this, relative.
constexpr double most_fiber_tolerance = 5e-3;
constexpr double hopeless = 1e4;  // residual against that at the start of a step, then shorter steps are the better way
constexpr int most_corrections = 3;  // of fibers alone, after a linear solve

/// Tolerance of a linear solve: krylov_tolerance, but no further than the nonlinear tolerance asks for, unless the user
/// wants linear systems solved more tightly than the nonlinear one.
double linear_tolerance(const SolverParameters& parameters, double residual, double reference) {
  constexpr double share = 0.95;  // of the nonlinear tolerance
  if (parameters.krylov_tolerance < 0.2 * parameters.newton_tolerance || !(residual > 0.0))
    return parameters.krylov_tolerance;
  const double enough = share * parameters.newton_tolerance * reference / residual;
  return std::clamp(enough, parameters.krylov_tolerance, std::max(parameters.krylov_tolerance, 0.3));
}

/// What the residual of the fluid is compared with: the first of the step, but where the tolerance is loose and the
/// step starts far from its end, as after a sudden start, no more than a part of the forces that change the momentum.
/// Where next to nothing flows those say nothing: a residual of `tight` times the first one is always enough.
/// @param momentum  of System::fluid_scale()
double fluid_reference_of(const SolverParameters& parameters, double first, double momentum) {
  constexpr double loose = 1e-3, part = 0.05, tight = 1e-6;
  if (parameters.newton_tolerance <= loose || !(momentum > 0.0)) return first;
  return std::min(first, std::max(part * momentum, tight / parameters.newton_tolerance * first));
}

/// The equations of the fluid are linear in every step: one solve, as exact as the nonlinear tolerance asks for.
bool is_linearized(const System& system) {
  return system.solver_parameters().nonlinear == fluid::Linearization::extrapolated;
}
double tolerance_of(const System& system, double residual, double reference) {
  const SolverParameters& parameters = system.solver_parameters();
  if (is_linearized(system)) {
    const double tolerance = 0.5 * std::min(parameters.newton_tolerance, parameters.krylov_tolerance);
    return residual > reference ? tolerance * reference / residual : tolerance;
  }
  return linear_tolerance(parameters, residual, reference);
}

/// D^T lambda, shape=(fiber nodes,6).
std::vector<double> force_of(const System& system, const std::vector<double>& lambda) {
  std::vector<double> force(system.force_old().size(), 0.0);
  system.coupling().add_d_transposed(lambda.data(), force, 1.0);
  return force;
}

/// Largest of M u - D v_b - S_law lambda relative to kappa times the largest fluid speed.
double constraint_residual(const System& system, const std::vector<double>& lambda) {
  const std::vector<double> slip = system.slip();
  std::vector<double> law(slip.size());
  system.interface().apply_law(lambda.data(), law.data());
  const coupling::Coupling& coupling = system.coupling();
  double largest = 0.0;
  for (Index p = 0; p < coupling.rows(); ++p) {
    if (!system.interface().is_active(p)) continue;
    for (int i = 0; i < 3; ++i) {
      const std::size_t k = 3 * static_cast<std::size_t>(p) + i;
      largest = std::max(largest, std::abs(slip[k] - law[k]) / coupling.kappa()[p]);
    }
  }
  largest = system.comm().max(largest);
  const double speed = system.fluid().max_velocity();
  return speed > 0.0 ? largest / speed : largest;
}

}  // namespace

StepReport solve_monolithic(System& system) {
  StepReport report;
  report.coupling_iterations = 1;
  fluid::FluidField& fluid = system.fluid();
  const SolverParameters& parameters = system.solver_parameters();
  const bool coupled = system.fluid_feels_fibers();
  const bool moving = coupled && system.fibers_follow();
  const bool linearized = is_linearized(system);
  const Vec residual = system.solver().residual(), increment = system.solver().increment();
  std::vector<double> g, lambda, force, first_seen;  // first_seen: M u to begin with
  double first_fluid_norm = 0.0, first_forces = 0.0, momentum = 0.0, fluid_reference = 0.0, fiber_reference = 0.0;
  const double fiber_tolerance = std::min(parameters.newton_tolerance, most_fiber_tolerance);
  // Fibers that do not follow the fluid are where they will be from the start.
  bool geometry_changed = coupled && system.update_geometry(system.first_positions());
  bool stale = system.take_staleness();  // what the solver keeps of fibers that do not move
  const bool iterated = coupled && system.scheme().geometry_update == GeometryUpdate::iterated && moving;

  for (int iteration = 0;; ++iteration) {
    const bool last = linearized && iteration == 1;  // the one linear solve was about the positions of the predictor
    // What the fibers do to S and g is needed for another linear solve only, unless the constraint is looked at.
    const bool early = !last && (iteration == 0 || iterated);
    // Far from the end of the step downhill, then quadratically.
    if (moving) system.beams().set_downhill(iteration == 0);
    if (moving && early) linearize_fibers(system);
    if (moving && !early) evaluate_fibers(system);
    if (iterated && !last && system.update_geometry(system.beams().dofs())) geometry_changed = true;
    if (coupled && early) {
      if (!condense(system, g)) break;
      // Bases whose rows follow the segments have other rows in other positions.
      if (iteration == 0) {
        system.interpolate(fluid.iterate(), first_seen);
        multipliers(system, first_seen, g, lambda);
      } else if (iterated && !system.coupling().has_fixed_rows()) {
        multipliers(system, g, lambda);
      }
    }
    // Residuals of this iterate.
    ResidualNorms norms;
    double fiber_norm = 0.0;
    const double fiber_floor = moving ? fiber_round_off(system) : 0.0;
    if (moving) {
      force = system.fiber_force(lambda);
      fiber_norm = fiber_residual(system, force);
      if (iteration == 0) fiber_reference = fiber_norm;
      const double enough = std::max(fiber_floor, fiber_tolerance * fiber_reference);
      const bool correct = iteration == 0 ? !linearized && !iterated : !early && !last;
      if (correct && fiber_norm > enough) {
        // One suffices to begin with: what is left is as small as what the flow will change.
        const int most = iteration == 0 ? 1 : most_corrections;
        if (!correct_fibers(system, most, enough, early, g, lambda, fiber_norm)) break;
        // The linear solve that follows is about these positions.
        if (iteration == 0) linearize_fibers(system);
        if (iteration == 0 && !condense(system, g)) break;
        if (iteration == 0) multipliers(system, first_seen, g, lambda);
        force = system.fiber_force(lambda);
      }
    }
    system.fluid_residual(lambda, residual, iteration == 0 && system.solver().is_single());
    const double fluid_norm = system.fluid_norm(residual);
    if (iteration == 0) first_fluid_norm = fluid_norm;
    const FluidScale scale = system.fluid_scale();
    if (iteration == 0) first_forces = scale.forces;
    momentum = std::max(momentum, scale.momentum);
    // The one linear solve of linearized equations is as exact as what it started from asks for.
    if (!last) fluid_reference = fluid_reference_of(parameters, first_fluid_norm, momentum);
    // A fiber at rest starts with a residual that says nothing: the force on it is the scale then.
    if (moving) fiber_reference = std::max(fiber_reference, interface_norm(system.comm(), force));
    const double fluid_floor = parameters.newton_absolute_tolerance * scale.forces;
    norms.fluid = fluid_reference > 0.0 ? fluid_norm / fluid_reference : 0.0;
    norms.fiber = fiber_reference > 0.0 ? fiber_norm / fiber_reference : 0.0;
    if (iterated) norms.constraint = constraint_residual(system, lambda);
    report.history.push_back(norms);
    report.residual =
        std::max(fluid_norm <= fluid_floor ? 0.0 : norms.fluid, fiber_norm <= fiber_floor ? 0.0 : norms.fiber);
    report.residual = std::max(report.residual, norms.constraint);
    if (last) report.residual = fluid_norm <= fluid_floor ? 0.0 : norms.fluid;
    if (!std::isfinite(fluid_norm) || !std::isfinite(fiber_norm)) {
      report.residual = fluid_norm + fiber_norm;
      break;
    }
    if (iteration > 0 &&
        (fluid_norm > hopeless * std::max(first_fluid_norm, first_forces) || fiber_norm > hopeless * fiber_reference))
      break;
    const bool fluid_done = fluid_norm <= fluid_floor || (iteration > 0 && norms.fluid <= parameters.newton_tolerance);
    const bool fiber_done = fiber_norm <= fiber_floor || (iteration > 0 && norms.fiber <= fiber_tolerance);
    const bool constraint_done = iteration > 0 || !iterated;
    if (fluid_done && fiber_done && constraint_done && norms.constraint <= parameters.newton_tolerance) {
      report.converged = true;
      break;
    }
    if (last) {
      report.converged = fluid_done;
      break;
    }
    if (iteration == parameters.newton_iterations) break;

    if (moving) linearize_fibers(system);
    if (coupled && !early && !condense(system, g)) break;
    // Newton step of the condensed system: its residual has lambda = S^-1 (M u - g) at this linearisation.
    if (coupled && iteration > 0) {
      std::vector<double> change;
      multipliers(system, g, change);
      for (std::size_t k = 0; k < change.size(); ++k) change[k] -= lambda[k];
      system.solver().add_spread(change, residual);
      system.solver().project_residual(residual);
    }
    fluid.linearize();
    const bool moved = geometry_changed || (moving && iteration == 0);
    if (!system.solver().prepare(moved, moving, stale)) break;
    geometry_changed = stale = false;
    FBI_PETSC(VecScale(residual, -1.0));
    const double tolerance = tolerance_of(system, system.fluid_norm(residual), fluid_reference);
    const linalg::KrylovResult result = system.solver().solve(residual, increment, tolerance);
    report.krylov += result.iterations;
    if (result.iterations > many_iterations) system.mark_stale();
    ++report.newton;
    ++report.evaluations;
    if (!result.converged && !(result.relative_residual < 0.5)) {
      report.residual = std::isfinite(result.relative_residual) ? report.residual : result.relative_residual;
      break;
    }
    fluid.increment(increment);
    if (coupled) multipliers(system, g, lambda);
    if (moving) move_fibers(system, system.fiber_force(lambda));
  }
  if (coupled) system.lambda() = lambda;
  return report;
}

bool solve_fluid(System& system, const std::vector<double>* g, std::vector<double>& lambda, StepReport& report,
                 bool& geometry_changed, double& reference, const FluidTolerance& tolerance) {
  fluid::FluidField& fluid = system.fluid();
  const SolverParameters& parameters = system.solver_parameters();
  const Vec residual = system.solver().residual(), increment = system.solver().increment();
  double before = std::numeric_limits<double>::infinity();
  for (int iteration = 0; iteration <= parameters.newton_iterations; ++iteration) {
    if (g != nullptr) multipliers(system, *g, lambda);
    system.fluid_residual(lambda, residual);
    const double value = system.fluid_norm(residual);
    if (!std::isfinite(value)) return false;
    reference = std::max(reference, value);
    if (value <= parameters.newton_absolute_tolerance * system.fluid_scale().forces) return true;
    double limit = tolerance.relative * reference;
    if (tolerance.force_share > 0.0)
      limit = std::min(limit, tolerance.force_share * interface_norm(system.comm(), force_of(system, lambda)));
    if (value <= limit) return true;
    // Round-off may keep it from the share of a small force.
    if (value <= tolerance.relative * reference && value > 0.5 * before) return true;
    before = value;
    fluid.linearize();
    const bool fresh = geometry_changed;
    if (!system.solver().prepare(fresh, fresh)) return false;
    geometry_changed = false;
    FBI_PETSC(VecScale(residual, -1.0));
    const double wanted = is_linearized(system) ? value : limit / parameters.newton_tolerance;
    const double linear = tolerance_of(system, value, wanted);
    linalg::KrylovResult result = system.solver().solve(residual, increment, linear);
    if (!fresh && !result.converged) {
      report.krylov += result.iterations;
      if (!system.solver().prepare(true, true, true)) return false;
      result = system.solver().solve(residual, increment, linear);
    }
    if (!fresh && result.iterations > many_iterations) geometry_changed = true;
    report.krylov += result.iterations;
    ++report.newton;
    if (!result.converged && !(result.relative_residual < 0.5)) return value <= tolerance.relative * reference;
    fluid.increment(increment);
  }
  return false;
}

}  // namespace fbi::fsi
