#include "fsi/steady.hpp"

#include <algorithm>
#include <cmath>

#include "base/log.hpp"

namespace fbi::fsi {
namespace {

constexpr int first_picard = 2, picard_after_failure = 3;
constexpr int iterations_factor = 10;  // steady against one time step
constexpr int most_pseudo_steps = 3000, pseudo_steps_between_lines = 20;
constexpr double pseudo_tolerance = 0.03;                  // of the linear system of a pseudo-time step
constexpr int easy_iterations = 40, hard_iterations = 70;  // Krylov

/// The steady equations at the present iterate.
class SteadyProblem {
 public:
  explicit SteadyProblem(System& system)
      : system_(system),
        parameters_(system.solver_parameters()),
        residual_(system.fluid().create_vector()),
        increment_(system.fluid().create_vector()) {
    if (!system_.is_coupled()) return;
    system_.update_geometry(system_.beams().accepted_dofs());
    system_.interface().reset(system_.coupling());
    regular_ = !system_.comm().any(!system_.interface().factorize());
  }

  bool is_regular() const { return regular_; }

  /// Residual norm; appends it to the report. tau is that of the iterate.
  double evaluate(StepReport& report) {
    system_.fluid().update_tau();
    if (system_.is_coupled()) {  // lambda = S^-1 M u: the fibers do not move
      system_.interpolate(system_.fluid().iterate(), lambda_);
      system_.interface().solve(lambda_.data());
    }
    choose_reference(report.history.empty());
    system_.fluid_residual(lambda_, residual_);
    const double norm = system_.fluid_norm(residual_);
    if (report.history.empty() && !system_.is_coupled()) reference_ = norm;
    const double reference = reference_ > 0.0 ? reference_ : norm;
    report.residual = reference > 0.0 ? norm / reference : 0.0;
    report.history.push_back({report.residual, 0.0, 0.0});
    if (norm <= parameters_.newton_absolute_tolerance * system_.fluid_scale().forces) report.residual = 0.0;
    report.converged =
        report.residual == 0.0 || (report.history.size() > 1 && report.residual <= parameters_.newton_tolerance);
    return norm;
  }

  /// One linear solve with the tangent at the iterate; the iterate is not changed.
  linalg::KrylovResult solve(StepReport& report, bool renew_factor, double tolerance) {
    system_.fluid().linearize();
    if (!system_.solver().prepare(renew_factor, renew_factor, renew_factor)) return {};
    FBI_PETSC(VecScale(residual_, -1.0));
    const linalg::KrylovResult result = system_.solver().solve(residual_, increment_, tolerance);
    report.krylov += result.iterations;
    ++report.newton;
    ++report.evaluations;
    return result;
  }
  void add_increment() { system_.fluid().increment(increment_); }
  void take_back() {
    FBI_PETSC(VecScale(increment_, -1.0));
    system_.fluid().increment(increment_);
  }
  void finish() {
    if (system_.is_coupled()) system_.lambda() = lambda_;
  }

 private:
  /// What residuals are measured by: the first one without the fibers' forces, or these forces once a first solution
  /// has made them what they are. With the fibers in an initial flow they are penalty times slip, which says nothing.
  void choose_reference(bool first) {
    if (!system_.is_coupled()) return;
    if (first) {
      system_.fluid_residual(std::vector<double>(lambda_.size(), 0.0), residual_);
      reference_ = system_.fluid_norm(residual_);
    } else {
      FBI_PETSC(VecSet(residual_, 0.0));
      system_.solver().add_spread(lambda_, residual_);
      reference_ = std::max(reference_, system_.fluid_norm(residual_));
    }
  }

  System& system_;
  const SolverParameters& parameters_;
  linalg::VecHandle residual_, increment_;
  std::vector<double> lambda_;
  bool regular_ = true;
  double reference_ = 0.0;
};

void by_newton(System& system, SteadyProblem& problem, StepReport& report) {
  const SolverParameters& parameters = system.solver_parameters();
  const bool newton = parameters.nonlinear == fluid::Linearization::newton;
  const int limit = iterations_factor * parameters.newton_iterations;
  int picard_left = first_picard;
  bool tried_newton = false;
  double before = 0.0;
  for (int iteration = 0;; ++iteration) {
    double norm = problem.evaluate(report);
    log::info("iteration %d%s: residual %.2e", iteration,
              iteration == 0 ? "" : (tried_newton ? ", newton" : ", picard"), report.residual);
    if (report.converged || !std::isfinite(norm)) return;
    if (tried_newton && !(norm < before)) {
      problem.take_back();
      picard_left = picard_after_failure;
      norm = problem.evaluate(report);
    }
    if (iteration == limit) return;
    tried_newton = newton && picard_left == 0;
    if (picard_left > 0) --picard_left;
    system.fluid().set_linearization(tried_newton ? fluid::Linearization::newton : fluid::Linearization::picard);
    const linalg::KrylovResult result = problem.solve(report, true, parameters.krylov_tolerance);
    if (!result.converged) return;
    before = norm;
    problem.add_increment();
  }
}

void by_pseudo_time(System& system, SteadyProblem& problem, StepReport& report) {
  const SolverParameters& parameters = system.solver_parameters();
  fluid::FluidField& fluid = system.fluid();
  const double h = fluid.smallest_cell(), density = fluid.parameters().density;
  double sigma = fluid.max_velocity() / h + fluid.parameters().viscosity / (density * h * h);
  double before = 0.0;
  int iterations = easy_iterations;
  for (int step = 0; step <= most_pseudo_steps; ++step) {
    fluid.set_pseudo_time(sigma);
    const double norm = problem.evaluate(report);
    if (step % pseudo_steps_between_lines == 0 || report.converged)
      log::info("pseudo-time step %d: residual %.2e, CFL %.3g, %d Krylov iterations", step, report.residual,
                fluid.max_velocity() / (sigma * h), step > 0 ? iterations : 0);
    if (report.converged || !std::isfinite(norm)) return;
    if (step > 0) {
      if (norm > 1.5 * before)
        sigma *= 2.0;
      else if (iterations > hard_iterations)
        sigma *= 1.3;
      else if (iterations <= easy_iterations)
        sigma /= 1.3;
      fluid.set_pseudo_time(sigma);
    }
    before = norm;
    const linalg::KrylovResult result =
        problem.solve(report, step % 10 == 0, std::max(pseudo_tolerance, parameters.krylov_tolerance));
    iterations = result.iterations;
    if (!std::isfinite(result.relative_residual)) return;
    if (result.converged || result.relative_residual < 0.5)
      problem.add_increment();
    else
      sigma *= 4.0;
  }
}

}  // namespace

StepReport solve_steady(System& system) {
  StepReport report;
  report.coupling_iterations = 1;
  SteadyProblem problem(system);
  if (!problem.is_regular()) return report;
  if (system.solver().is_direct())
    by_newton(system, problem, report);
  else
    by_pseudo_time(system, problem, report);
  problem.finish();
  system.fluid().set_linearization(system.solver_parameters().nonlinear);
  return report;
}

}  // namespace fbi::fsi
