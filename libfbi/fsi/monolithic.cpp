#include "fsi/monolithic.hpp"

#include <algorithm>
#include <cmath>

#include "base/timer.hpp"

namespace fbi::fsi {
namespace {

constexpr double round_off_margin = 10.0;  // the norm of all rows against the largest entry

/// Tolerance of a linear solve: krylov_tolerance, but no further than the nonlinear tolerance asks for, unless the user
/// wants linear systems solved more tightly than the nonlinear one.
double linear_tolerance(const SolverParameters& parameters, double residual, double reference) {
  if (parameters.krylov_tolerance < parameters.newton_tolerance || !(residual > 0.0))
    return parameters.krylov_tolerance;
  const double enough = 0.2 * parameters.newton_tolerance * reference / residual;
  return std::clamp(enough, parameters.krylov_tolerance, std::max(parameters.krylov_tolerance, 0.1));
}

/// The equations of the fluid are linear in every step: one solve, as exact as the nonlinear tolerance asks for.
bool is_linearized(const System& system) {
  return system.solver_parameters().nonlinear == fluid::Linearization::extrapolated;
}
double tolerance_of(const System& system, double residual, double reference) {
  const SolverParameters& parameters = system.solver_parameters();
  if (is_linearized(system)) return 0.5 * std::min(parameters.newton_tolerance, parameters.krylov_tolerance);
  return linear_tolerance(parameters, residual, reference);
}

double norm(const Comm& comm, const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(comm.sum(sum));
}

/// The same for the groups of fibers that joints hold together: one block of S each, and their part of D v_b.
void condense_joined(System& system, double c, std::vector<double>& velocity) {
  const mesh::FiberMesh& fibers = system.fibers();
  if (fibers.joined.empty()) return;
  const coupling::Coupling& coupling = system.coupling();
  beam::BeamField& beams = system.beams();
  const double w = system.weight();
  beam::RowMatrix compliance;
  for (std::size_t g = 0; g < fibers.joined.size(); ++g) {
    std::vector<const double*> d;
    std::vector<Index> rows;
    for (const Index f : fibers.joined[g]) {
      d.push_back(coupling.d_block(f).data());
      rows.push_back(coupling.first_row_of(f + 1) - coupling.first_row_of(f));
    }
    beams.compliance_joined(static_cast<Index>(g), d, rows, compliance);
    system.interface().add_joined(static_cast<Index>(g), c * w, compliance);
  }
  std::vector<double> increment(velocity.size());
  for (std::size_t k = 0; k < increment.size(); ++k)
    increment[k] = (1.0 - w) * system.force_old()[k] - beams.residual()[k];
  beams.solve(increment);
  for (const std::vector<Index>& group : fibers.joined)
    for (const Index f : group)
      for (std::size_t k = 6 * static_cast<std::size_t>(fibers.first_node[f]);
           k < 6 * static_cast<std::size_t>(fibers.first_node[f + 1]); ++k)
        velocity[k] += c * increment[k];
}

/// S and g of the condensed fibers at the current iterate: S = kappa/eps + c w D K_b^-1 D^T,
/// g = D v_b + c D K_b^-1 ((1-w) D^T lambda_n - G_b).
bool condense(System& system, std::vector<double>& g) {
  Timed timed("condensation");
  coupling::InterfaceOperator& interface = system.interface();
  const coupling::Coupling& coupling = system.coupling();
  const mesh::FiberMesh& fibers = system.fibers();
  beam::BeamField& beams = system.beams();
  interface.reset(coupling);
  g.assign(3 * static_cast<std::size_t>(coupling.rows()), 0.0);
  std::vector<double> velocity = beams.velocity();
  const double c = beams.velocity_per_displacement(), w = system.weight();
  if (system.fibers_move() && c != 0.0) {
    beam::RowMatrix compliance;
    std::vector<double> increment;
    for (Index f = 0; f < fibers.fibers(); ++f) {
      if (beams.is_fixed(f) || fibers.is_joined(f)) continue;
      const Index rows = coupling.first_row_of(f + 1) - coupling.first_row_of(f);
      beams.compliance(f, coupling.d_block(f).data(), rows, compliance);
      interface.add(f, c * w, compliance);
      const std::size_t begin = 6 * static_cast<std::size_t>(fibers.first_node[f]);
      const std::size_t end = 6 * static_cast<std::size_t>(fibers.first_node[f + 1]);
      increment.resize(end - begin);
      for (std::size_t k = begin; k < end; ++k)
        increment[k - begin] = (1.0 - w) * system.force_old()[k] - beams.residual()[k];
      beams.solve(f, increment.data());
      for (std::size_t k = begin; k < end; ++k) velocity[k] += c * increment[k - begin];
    }
    condense_joined(system, c, velocity);
  }
  coupling.apply_d(velocity, g.data());
  return !system.comm().any(!interface.factorize());
}

/// lambda = S^-1 (M u - g). Collective.
void multipliers(System& system, const std::vector<double>& g, std::vector<double>& lambda) {
  system.solver().interpolate(system.fluid().iterate(), lambda);
  for (std::size_t k = 0; k < lambda.size(); ++k) lambda[k] -= g[k];
  system.interface().solve(lambda.data());
}

/// Fiber residual G_b - (w D^T lambda + (1-w) D^T lambda_n) at the linearised iterate, zero in constrained directions.
std::vector<double> fiber_residual(const System& system, const std::vector<double>& force) {
  std::vector<double> residual = system.beams().residual();
  for (std::size_t k = 0; k < force.size(); ++k) residual[k] -= force[k];
  system.beams().remove_constrained(residual);
  return residual;
}

/// Increments d by K_b^-1 (force - G_b) for every moving fiber. Needs the linearisation at the current iterate.
void move_fibers(System& system, const std::vector<double>& force) {
  Timed timed("fiber increments");
  beam::BeamField& beams = system.beams();
  std::vector<double> delta(force.size());
  for (std::size_t k = 0; k < delta.size(); ++k) delta[k] = force[k] - beams.residual()[k];
  beams.solve(delta);
  beams.increment(delta);
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
  const bool coupled = system.is_coupled();
  const bool moving = coupled && system.fibers_move();
  const bool linearized = is_linearized(system);
  linalg::VecHandle residual = fluid.create_vector(), increment = fluid.create_vector();
  std::vector<double> g, lambda, force;
  double fluid_reference = 0.0, fiber_reference = 0.0;
  bool geometry_changed = coupled && system.update_geometry(system.beams().accepted_dofs());
  const bool iterated = coupled && system.scheme().geometry_update == GeometryUpdate::iterated && moving;
  // prescribed fibers are where they will be from the start
  if (coupled && !moving && system.scheme().geometry_update == GeometryUpdate::iterated)
    geometry_changed = system.update_geometry(system.beams().dofs()) || geometry_changed;

  for (int iteration = 0;; ++iteration) {
    if (moving) {
      Timed timed("fiber tangents");
      system.beams().linearize();
    }
    if (iterated && system.update_geometry(system.beams().dofs())) geometry_changed = true;
    const bool last = linearized && iteration == 1;
    if (coupled && !last) {
      if (!condense(system, g)) break;
      // Bases whose rows follow the segments have other rows in other positions.
      if (iteration == 0 || (iterated && !system.coupling().has_fixed_rows())) multipliers(system, g, lambda);
    }
    // Residuals of this iterate.
    ResidualNorms norms;
    system.fluid_residual(lambda, residual);
    const double fluid_norm = system.fluid_norm(residual);
    double fiber_norm = 0.0;
    if (moving) {
      force = system.fiber_force(lambda);
      fiber_norm = std::hypot(norm(system.comm(), fiber_residual(system, force)),
                              std::sqrt(system.comm().sum(system.beams().squared_moment_residual())));
      if (system.has_joints())
        fiber_norm = std::hypot(fiber_norm, std::sqrt(system.comm().sum(system.beams().squared_joint_residual())));
    }
    if (iteration == 0) {
      fluid_reference = fluid_norm;
      fiber_reference = fiber_norm;
    }
    // A fiber at rest starts with a residual that says nothing: the force on it is the scale then.
    if (moving) fiber_reference = std::max(fiber_reference, norm(system.comm(), force));
    const double fluid_floor = parameters.newton_absolute_tolerance * system.fluid_scale();
    const double fiber_floor =
        moving ? std::max(parameters.newton_absolute_tolerance * system.comm().max(system.beams().force_scale()),
                          round_off_margin * system.comm().max(system.beams().round_off()))
               : 0.0;
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
    const bool fluid_done = fluid_norm <= fluid_floor || (iteration > 0 && norms.fluid <= parameters.newton_tolerance);
    const bool fiber_done = fiber_norm <= fiber_floor || (iteration > 0 && norms.fiber <= parameters.newton_tolerance);
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

    // Newton step of the condensed system: its residual has lambda = S^-1 (M u - g) at this linearisation.
    if (coupled && iteration > 0) {
      std::vector<double> eliminated;
      multipliers(system, g, eliminated);
      system.fluid_residual(eliminated, residual);
    }
    fluid.linearize();
    if (!system.solver().prepare(geometry_changed || iteration == 0, moving || iteration == 0)) break;
    geometry_changed = false;
    FBI_PETSC(VecScale(residual, -1.0));
    const double tolerance = tolerance_of(system, system.fluid_norm(residual), fluid_reference);
    const linalg::KrylovResult result = system.solver().solve(residual, increment, tolerance);
    report.krylov += result.iterations;
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
                 bool geometry_changed, double& reference) {
  fluid::FluidField& fluid = system.fluid();
  const SolverParameters& parameters = system.solver_parameters();
  linalg::VecHandle residual = fluid.create_vector(), increment = fluid.create_vector();
  for (int iteration = 0; iteration <= parameters.newton_iterations; ++iteration) {
    if (g != nullptr) multipliers(system, *g, lambda);
    system.fluid_residual(lambda, residual);
    const double value = system.fluid_norm(residual);
    if (!std::isfinite(value)) return false;
    reference = std::max(reference, value);
    if (value <= parameters.newton_absolute_tolerance * system.fluid_scale()) return true;
    if (value <= parameters.newton_tolerance * reference) return true;
    fluid.linearize();
    if (!system.solver().prepare(geometry_changed, geometry_changed)) return false;
    geometry_changed = false;
    FBI_PETSC(VecScale(residual, -1.0));
    const double tolerance = tolerance_of(system, value, reference);
    const linalg::KrylovResult result = system.solver().solve(residual, increment, tolerance);
    report.krylov += result.iterations;
    ++report.newton;
    if (!result.converged && !(result.relative_residual < 0.5)) return false;
    fluid.increment(increment);
  }
  return false;
}

}  // namespace fbi::fsi
