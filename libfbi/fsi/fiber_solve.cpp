#include "fsi/fiber_solve.hpp"

#include <algorithm>
#include <cmath>

#include "base/timer.hpp"
#include "fsi/condensation.hpp"

namespace fbi::fsi {
namespace {

constexpr int most_iterations = 50;
constexpr double beyond_tolerance = 1e-4;  // the fibers are solved further than the system: an iteration costs little

std::vector<double> rows_of(const System& system, const std::vector<double>& nodal) {
  std::vector<double> rows(3 * static_cast<std::size_t>(system.coupling().rows()));
  system.coupling().apply_d(nodal, rows.data());
  return rows;
}

}  // namespace

std::vector<double> spring_force(const System& system, std::vector<double> b) {
  system.interface().solve(b.data());
  std::vector<double> force(system.force_old().size(), 0.0);
  system.coupling().add_d_transposed(b.data(), force, 1.0);
  return force;
}

FiberTangent::FiberTangent(System& system, bool with_penalty)
    : system_(system), condensed_(system.interface()), with_penalty_(with_penalty) {
  system_.beams().linearize();
  if (!with_penalty_) return;
  add_compliance(system_, condensed_);
  regular_ = !system_.comm().any(!condensed_.factorize());
}

void FiberTangent::solve(std::vector<double>& force) const {
  std::vector<double> change = force;
  system_.beams().solve(change);
  if (with_penalty_) {
    const double factor = system_.weight() * system_.beams().velocity_per_displacement();
    std::vector<double> rows = rows_of(system_, change);
    condensed_.solve(rows.data());
    system_.coupling().add_d_transposed(rows.data(), force, -factor);
    system_.beams().solve(force);
  } else {
    force = std::move(change);
  }
}

bool solve_fibers(System& system, const std::vector<double>& pull) {
  Timed timed("fiber solve");
  beam::BeamField& beams = system.beams();
  // Cheap beside a solve of the fluid: no need to stop early.
  const double w = system.weight(), tolerance = std::min(1e-6, system.solver_parameters().newton_tolerance);
  double reference = 0.0, last = 0.0;
  for (int iteration = 0; iteration <= most_iterations; ++iteration) {
    const FiberTangent tangent(system, true);
    if (!tangent.is_regular()) return false;
    const std::vector<double> spring = spring_force(system, rows_of(system, beams.velocity()));
    std::vector<double> force(pull.size());
    for (std::size_t k = 0; k < force.size(); ++k)
      force[k] = w * (pull[k] - spring[k]) + (1.0 - w) * system.force_old()[k];
    const double norm = fiber_residual(system, force);
    if (!std::isfinite(norm)) return false;
    reference = std::max({reference, norm, interface_norm(system.comm(), force)});
    if (norm <= std::max(beyond_tolerance * tolerance * reference, fiber_round_off(system))) return true;
    // Round-off may end the descent earlier than both.
    if (iteration > 1 && norm <= tolerance * reference && norm > 0.5 * last) return true;
    last = norm;
    for (std::size_t k = 0; k < force.size(); ++k) force[k] -= beams.residual()[k];
    tangent.solve(force);
    beams.increment(force);
  }
  return false;
}

}  // namespace fbi::fsi
