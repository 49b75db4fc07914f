#include "fsi/interface_map.hpp"

#include <algorithm>
#include <cmath>

#include "base/timer.hpp"
#include "fsi/condensation.hpp"

namespace fbi::fsi {
namespace {

// Linear solves of differences are this much tighter than the Krylov space of the interface that they span.
constexpr double difference_tolerance = 0.1;
constexpr int most_attempts = 3;
// What is left unbalanced in the fluid is this much less than the change of force that the iteration ends with: else
// the force that the fluid answers with would not be a function of x to that tolerance.
constexpr double fluid_share = 0.1;

}  // namespace

InterfaceMap::InterfaceMap(System& system, StepReport& report, double time, double dt)
    : system_(system), report_(report), time_(time), dt_(dt), implicit_(system.scheme().implicit_penalty) {
  system_.update_geometry(system_.first_positions());
  system_.interface().reset(system_.coupling());
}

std::vector<double> InterfaceMap::predict() {
  const std::vector<double>&now = system_.force_old(), &old = system_.force_older(), &oldest = system_.force_oldest();
  const std::array<double, 3> weight = system_.extrapolation(static_cast<int>(system_.scheme().force_predictor));
  std::vector<double> x(now.size());
  for (std::size_t k = 0; k < x.size(); ++k) x[k] = weight[0] * now[k] + weight[1] * old[k] + weight[2] * oldest[k];
  if (!implicit_) return x;
  // The velocity that this force gives the fibers is that of the x of the implicit form.
  Timed timed("fiber solve");
  const double w = system_.weight();
  std::vector<double> force(x.size());
  for (std::size_t k = 0; k < x.size(); ++k) force[k] = w * x[k] + (1.0 - w) * now[k];
  if (system_.beams().solve_step(force) < 0) return {};
  std::vector<double> g(3 * static_cast<std::size_t>(system_.coupling().rows()));
  system_.coupling().apply_d(system_.beams().velocity(), g.data());
  const std::vector<double> spring = spring_force(system_, g);
  for (std::size_t k = 0; k < x.size(); ++k) x[k] += spring[k];
  return x;
}

bool InterfaceMap::solve_fields(const std::vector<double>& x, std::vector<double>& h, double& reference,
                                const FluidTolerance& tolerance) {
  beam::BeamField& beams = system_.beams();
  coupling::Coupling& coupling = system_.coupling();
  ++report_.evaluations;
  beams.begin_step(time_, dt_);
  if (implicit_) {
    if (!solve_fibers(system_, x)) return false;
  } else {
    Timed timed("fiber solve");
    const double w = system_.weight();
    std::vector<double> force(x.size());
    for (std::size_t k = 0; k < x.size(); ++k) force[k] = w * x[k] + (1.0 - w) * system_.force_old()[k];
    if (beams.solve_step(force) < 0) return false;
  }
  if (system_.scheme().geometry_update == GeometryUpdate::iterated && system_.update_geometry(beams.dofs())) {
    geometry_changed_ = true;
    system_.interface().reset(coupling);
  }
  std::vector<double> g(3 * static_cast<std::size_t>(coupling.rows()));
  coupling.apply_d(beams.velocity(), g.data());
  if (!solve_fluid(system_, &g, lambda_, report_, geometry_changed_, reference, tolerance)) return false;
  if (implicit_)
    h = spring_force(system_, g);
  else
    h.assign(x.size(), 0.0);
  coupling.add_d_transposed(lambda_.data(), h, 1.0);
  return true;
}

bool InterfaceMap::evaluate(const std::vector<double>& x, std::vector<double>& h) {
  tangent_.reset();
  const bool solved = solve_fields(
      x, h, fluid_reference_, {system_.solver_parameters().newton_tolerance, fluid_share * system_.scheme().tolerance});
  if (solved) system_.lambda() = lambda_;
  x_ = x;
  h_ = h;
  return solved;
}

double InterfaceMap::force_norm() const {
  std::vector<double> force(system_.force_old().size(), 0.0);
  system_.coupling().add_d_transposed(system_.lambda().data(), force, 1.0);
  return interface_norm(system_.comm(), force);
}

bool InterfaceMap::difference(const std::vector<double>& x, std::vector<double>& h) {
  return system_.scheme().differences == Differences::linearized ? linearized(x, h) : nonlinear(x, h);
}

// The residuals at the last iterate are taken to be zero: d = K^-1 w dx, (A + M^T S^-1 M) du = M^T S^-1 D c d.
bool InterfaceMap::linearized(const std::vector<double>& x, std::vector<double>& h) {
  fluid::FluidField& fluid = system_.fluid();
  beam::BeamField& beams = system_.beams();
  coupling::Coupling& coupling = system_.coupling();
  FluidSolver& solver = system_.solver();
  ++report_.evaluations;
  if (!right_) {
    right_ = fluid.create_vector();
    change_ = fluid.create_vector();
  }
  if (tangent_ == nullptr) {
    tangent_ = std::make_unique<FiberTangent>(system_, implicit_);
    if (!tangent_->is_regular()) return false;
    fluid.linearize();
    if (!solver.prepare(true, true, true)) return false;
    geometry_changed_ = false;
  }
  std::vector<double> change(x.size());
  for (std::size_t k = 0; k < x.size(); ++k) change[k] = system_.weight() * (x[k] - x_[k]);
  {
    Timed timed("fiber solve");
    tangent_->solve(change);
  }
  const double c = beams.velocity_per_displacement();
  for (double& value : change) value *= c;
  std::vector<double> g(3 * static_cast<std::size_t>(coupling.rows())), lambda;
  coupling.apply_d(change, g.data());
  std::vector<double> pull = g;
  system_.interface().solve(pull.data());
  FBI_PETSC(VecSet(right_, 0.0));
  solver.add_spread(pull, right_);
  solver.project_residual(right_);
  // The force follows from the slip, which is small against both velocities where the penalty is large: the solve must
  // be exact against the change of force, not against the pull on the fluid that its right-hand side is.
  std::vector<double> force(x.size(), 0.0);
  coupling.add_d_transposed(pull.data(), force, 1.0);
  const double whole = interface_norm(system_.comm(), force);
  for (int attempt = 0; attempt < most_attempts; ++attempt) {
    const double tolerance = difference_tolerance * system_.scheme().krylov_tolerance * std::min(1.0, share_);
    const linalg::KrylovResult result = solver.solve(right_, change_, tolerance);
    report_.krylov += result.iterations;
    if (!result.converged && !(result.relative_residual < 0.5)) return false;
    FBI_PETSC(VecGhostUpdateBegin(change_, INSERT_VALUES, SCATTER_FORWARD));
    FBI_PETSC(VecGhostUpdateEnd(change_, INSERT_VALUES, SCATTER_FORWARD));
    system_.interpolate(change_, lambda);
    for (std::size_t k = 0; k < lambda.size(); ++k) lambda[k] -= g[k];
    h = spring_force(system_, lambda);
    const double share = whole > 0.0 ? interface_norm(system_.comm(), h) / whole : 1.0;
    const bool exact = result.converged && share > 0.5 * std::min(1.0, share_);
    share_ = share;
    if (exact) break;
  }
  if (implicit_)
    for (std::size_t k = 0; k < h.size(); ++k) h[k] += force[k];
  for (std::size_t k = 0; k < h.size(); ++k) h[k] += h_[k];
  return true;
}

bool InterfaceMap::nonlinear(const std::vector<double>& x, std::vector<double>& h) {
  fluid::FluidField& fluid = system_.fluid();
  if (!fluid_) {
    fluid_ = fluid.create_vector();
    change_ = fluid.create_vector();
  }
  const std::vector<double> lambda = lambda_;
  FBI_PETSC(VecCopy(fluid.iterate(), fluid_));
  double reference = 0.0;  // what the change of the force disturbs, not what the step started with
  const bool solved = solve_fields(x, h, reference, {difference_tolerance * system_.scheme().krylov_tolerance, 0.0});
  FBI_PETSC(VecCopy(fluid_, fluid.iterate()));
  FBI_PETSC(VecSet(change_, 0.0));
  fluid.increment(change_);  // ghosts and what follows the iterate
  lambda_ = lambda;
  return solved;
}

}  // namespace fbi::fsi
