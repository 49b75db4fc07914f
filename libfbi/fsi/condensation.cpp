#include "fsi/condensation.hpp"

#include <algorithm>
#include <cmath>

#include "base/counters.hpp"
#include "base/timer.hpp"

namespace fbi::fsi {
namespace {

constexpr double round_off_margin = 10.0;  // the norm of all rows against the largest entry

/// The velocities that the fibers reach without the new coupling force: v_b + c K_b^-1 ((1-w) f_n - G_b).
std::vector<double> free_velocity(System& system) {
  const mesh::FiberMesh& fibers = system.fibers();
  beam::BeamField& beams = system.beams();
  std::vector<double> velocity = beams.velocity();
  const double c = beams.velocity_per_displacement(), w = system.weight();
  std::vector<double> increment(velocity.size());
  for (std::size_t k = 0; k < increment.size(); ++k)
    increment[k] = (1.0 - w) * system.force_old()[k] - beams.residual()[k];
  beams.solve(increment);
  for (Index f = 0; f < fibers.fibers(); ++f) {
    if (beams.is_fixed(f)) continue;
    const std::size_t end = 6 * static_cast<std::size_t>(fibers.first_node[f + 1]);
    for (std::size_t k = 6 * static_cast<std::size_t>(fibers.first_node[f]); k < end; ++k)
      velocity[k] += c * increment[k];
  }
  return velocity;
}

}  // namespace

void add_compliance(const System& system, coupling::InterfaceOperator& s) {
  const coupling::Coupling& coupling = system.coupling();
  const mesh::FiberMesh& fibers = system.fibers();
  const beam::BeamField& beams = system.beams();
  const double factor = beams.velocity_per_displacement() * system.weight();
  if (factor == 0.0) return;
  count("condensations");
  std::vector<const double*> all_d;
  std::vector<Index> all_rows;
  for (Index f = 0; f < fibers.fibers(); ++f) {
    all_d.push_back(coupling.d_block(f).data());
    all_rows.push_back(coupling.first_row_of(f + 1) - coupling.first_row_of(f));
  }
  beams.compliances(all_d, all_rows,
                    [&](Index f, const Eigen::Ref<const beam::RowMatrix>& block) { s.add(f, factor, block); });
  beam::RowMatrix compliance;
  for (std::size_t g = 0; g < fibers.joined.size(); ++g) {
    std::vector<const double*> d;
    std::vector<Index> rows;
    for (const Index f : fibers.joined[g]) {
      d.push_back(coupling.d_block(f).data());
      rows.push_back(coupling.first_row_of(f + 1) - coupling.first_row_of(f));
    }
    beams.compliance_joined(static_cast<Index>(g), d, rows, compliance);
    s.add_joined(static_cast<Index>(g), factor, compliance);
  }
}

bool condense(System& system, std::vector<double>& g) {
  Timed timed("condensation");
  coupling::InterfaceOperator& interface = system.interface();
  const coupling::Coupling& coupling = system.coupling();
  beam::BeamField& beams = system.beams();
  interface.reset(coupling);
  g.assign(3 * static_cast<std::size_t>(coupling.rows()), 0.0);
  if (system.fibers_follow() && beams.velocity_per_displacement() != 0.0) {
    add_compliance(system, interface);
    coupling.apply_d(free_velocity(system), g.data());
  } else {
    coupling.apply_d(beams.velocity(), g.data());
  }
  return !system.comm().any(!interface.factorize());
}

void multipliers(System& system, const std::vector<double>& interpolated, const std::vector<double>& g,
                 std::vector<double>& lambda) {
  lambda.resize(interpolated.size());
  for (std::size_t k = 0; k < lambda.size(); ++k) lambda[k] = interpolated[k] - g[k];
  system.interface().solve(lambda.data());
}

void multipliers(System& system, const std::vector<double>& g, std::vector<double>& lambda) {
  system.interpolate(system.fluid().iterate(), lambda);
  multipliers(system, lambda, g, lambda);
}

double fiber_residual(const System& system, const std::vector<double>& force) {
  const beam::BeamField& beams = system.beams();
  std::vector<double> residual = beams.residual();
  for (std::size_t k = 0; k < force.size(); ++k) residual[k] -= force[k];
  beams.remove_constrained(residual);
  const double value = std::hypot(interface_norm(system.comm(), residual),
                                  std::sqrt(system.comm().sum(beams.squared_moment_residual())));
  return system.has_joints() ? std::hypot(value, std::sqrt(system.comm().sum(beams.squared_joint_residual()))) : value;
}

double fiber_round_off(const System& system) {
  const Comm& comm = system.comm();
  return std::max(system.solver_parameters().newton_absolute_tolerance * comm.max(system.beams().force_scale()),
                  round_off_margin * comm.max(system.beams().round_off()));
}

std::vector<double> move_fibers(System& system, const std::vector<double>& force) {
  Timed timed("fiber increments");
  beam::BeamField& beams = system.beams();
  std::vector<double> delta(force.size());
  for (std::size_t k = 0; k < delta.size(); ++k) delta[k] = force[k] - beams.residual()[k];
  beams.solve(delta);
  beams.increment(delta);
  return delta;
}

void linearize_fibers(System& system) {
  if (system.beams().is_linearized()) return;
  Timed timed("fiber tangents");
  system.beams().linearize();
}

void evaluate_fibers(System& system) {
  Timed timed("fiber residual");
  system.beams().evaluate();
}

namespace {

/// G_b - force without what supports carry: its squared norm for each fiber, without joints and moments.
std::vector<double> squared_residuals(const System& system, const std::vector<double>& force) {
  const mesh::FiberMesh& fibers = system.fibers();
  std::vector<double> residual = system.beams().residual();
  for (std::size_t k = 0; k < residual.size(); ++k) residual[k] -= force[k];
  system.beams().remove_constrained(residual);
  std::vector<double> squares(fibers.fibers(), 0.0);
  for (Index f = 0; f < fibers.fibers(); ++f)
    for (std::size_t k = 6 * static_cast<std::size_t>(fibers.first_node[f]);
         k < 6 * static_cast<std::size_t>(fibers.first_node[f + 1]); ++k)
      squares[f] += residual[k] * residual[k];
  return squares;
}

/// Takes back the increments and multipliers of fibers whose residual they made larger.
/// @param before  squared residuals before the increment, shape=(fibers) [force^2]
/// @param small   squared residual that is no matter [force^2]
/// @param delta   the increment, shape=(fiber nodes,6)
/// @param lambda  multipliers that belong to it, shape=(rows,3), and old_lambda those before
void take_back(System& system, const std::vector<double>& before, double small, const std::vector<double>& old_lambda,
               const std::vector<double>& delta, std::vector<double>& lambda) {
  const mesh::FiberMesh& fibers = system.fibers();
  const coupling::Coupling& coupling = system.coupling();
  const std::vector<double> after = squared_residuals(system, system.fiber_force(lambda));
  std::vector<double> back(delta.size(), 0.0);
  bool any = false;
  for (Index f = 0; f < fibers.fibers(); ++f) {
    if (fibers.is_joined(f) || after[f] <= std::max(before[f], small)) continue;
    any = true;
    count_parts("fiber corrections taken back", 1);
    for (std::size_t k = 6 * static_cast<std::size_t>(fibers.first_node[f]);
         k < 6 * static_cast<std::size_t>(fibers.first_node[f + 1]); ++k)
      back[k] = -delta[k];
    const std::size_t first = 3 * static_cast<std::size_t>(coupling.first_row_of(f));
    const std::size_t last = 3 * static_cast<std::size_t>(coupling.first_row_of(f + 1));
    std::copy(old_lambda.begin() + static_cast<std::ptrdiff_t>(first),
              old_lambda.begin() + static_cast<std::ptrdiff_t>(last),
              lambda.begin() + static_cast<std::ptrdiff_t>(first));
  }
  if (!any) return;
  system.beams().increment(back);
  evaluate_fibers(system);
}

}  // namespace

bool correct_fibers(System& system, int most, double enough, bool condensed, std::vector<double>& g,
                    std::vector<double>& lambda, double& norm) {
  const double small = enough * enough / std::max<double>(1.0, static_cast<double>(system.fibers().global_fibers));
  for (int iteration = 0; iteration < most && norm > enough; ++iteration) {
    count("fiber corrections");
    const std::vector<double> before = squared_residuals(system, system.fiber_force(lambda));
    const std::vector<double> old_lambda = lambda;
    if (iteration > 0 || !condensed) {
      linearize_fibers(system);
      if (!condense(system, g)) return false;
      multipliers(system, g, lambda);
    }
    const std::vector<double> delta = move_fibers(system, system.fiber_force(lambda));
    evaluate_fibers(system);
    take_back(system, before, small, old_lambda, delta, lambda);
    const double last = norm;
    norm = fiber_residual(system, system.fiber_force(lambda));
    if (!(norm < 0.5 * last)) break;
  }
  return true;
}

double interface_norm(const Comm& comm, const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) sum += value * value;
  return std::sqrt(comm.sum(sum));
}

}  // namespace fbi::fsi
