#include "fsi/single_solver.hpp"

#include <algorithm>
#include <cstdlib>

#include "base/timer.hpp"

namespace fbi::fsi {

SingleSolver::SingleSolver(fluid::FluidField& fluid, fluid::SingleTangent& tangent, const coupling::Coupling* coupling,
                           const coupling::InterfaceOperator* interface, int restart)
    : fluid_(fluid),
      tangent_(tangent),
      coupling_(coupling),
      interface_(interface),
      owned_(fluid.mesh().owned_nodes),
      nodes_(fluid.mesh().local_nodes()),
      weight_(4 * nodes_),
      mass_(owned_),
      force_(coupling != nullptr ? 4 * nodes_ : 0),
      right_(owned_),
      solution_(owned_),
      krylov_(
          fluid.mesh().comm, 4 * owned_, 4 * nodes_,
          [this](const float* v, float factor, float* z, float* w) { step(v, factor, z, w); }, restart) {}

void SingleSolver::prepare(const SinglePreconditioner& preconditioner) {
  parts_ = preconditioner;
  const std::vector<double>& weight = *parts_.weight;
  for (std::size_t a = 0; a < nodes_; ++a)
    for (int i = 0; i < 3; ++i) weight_[4 * a + i] = static_cast<float>(weight[3 * a + i]);
  const std::vector<double>& volume = fluid_.lumped_volume();
  for (std::size_t a = 0; a < owned_; ++a) mass_[a] = static_cast<float>(parts_.mass_scale / volume[a]);
  tangent_.set_continuity_scale(parts_.continuity_scale);
  if (!has_multipliers()) return;
  rows_.resize(3 * static_cast<std::size_t>(coupling_->rows()));
  find_touched();
}

linalg::KrylovResult SingleSolver::solve(float* b, float* x, double tolerance, int maximum) {
  return krylov_.solve(b, x, tolerance, maximum);
}

void SingleSolver::find_touched() {
  for (const Index node : coupling_->local_m().node) force_[4 * static_cast<std::size_t>(node)] = 1.0f;
  tangent_.halo().add_ghosts(force_.data());
  touched_.clear();
  for (std::size_t a = 0; a < owned_; ++a)
    if (force_[4 * a] != 0.0f) touched_.push_back(static_cast<Index>(a));
  std::fill(force_.begin(), force_.end(), 0.0f);
}

/// velocity = (W^-1 + M^T S^-1 M)^-1 (factor v - gradient), with ghosts; fourth entries stay. Collective.
void SingleSolver::velocity_block(const float* v, float factor, const float* gradient, float* velocity) {
  const Timed timed("velocity block");
  const fluid::Halo& halo = tangent_.halo();
  for (std::size_t a = 0; a < owned_; ++a)
    for (std::size_t k = 4 * a; k < 4 * a + 3; ++k) velocity[k] = weight_[k] * (factor * v[k] - gradient[k]);
  tangent_.remove_normal(velocity, static_cast<Index>(owned_));
  halo.update_ghosts(velocity);
  if (!has_multipliers()) return;
  coupling_->interpolate(velocity, 4, rows_.data());
  {
    const Timed timed_factor("multiplier solve");
    parts_.factor->solve(rows_.data());
  }
  coupling_->spread(rows_.data(), 4, force_.data(), 1.0);
  halo.add_ghosts(force_.data());
  tangent_.remove_normal(force_.data(), static_cast<Index>(owned_));
  for (const Index a : touched_)
    for (std::size_t k = 4 * static_cast<std::size_t>(a); k < 4 * static_cast<std::size_t>(a) + 3; ++k) {
      velocity[k] -= weight_[k] * force_[k];
      force_[k] = 0.0f;
    }
  std::fill(force_.begin() + static_cast<std::ptrdiff_t>(4 * owned_), force_.end(), 0.0f);
  tangent_.remove_normal(velocity, static_cast<Index>(owned_));
  halo.update_ghosts(velocity);
}

void SingleSolver::step(const float* v, float factor, float* z, float* w) {
  {
    const Timed timed("pressure solve");
    const float unscaled = factor / static_cast<float>(parts_.continuity_scale);
    for (std::size_t a = 0; a < owned_; ++a) right_[a] = unscaled * v[4 * a + 3];
    parts_.pressure->apply(right_.data(), solution_.data());
    const float scale = static_cast<float>(parts_.pressure_scale);
    for (std::size_t a = 0; a < owned_; ++a) z[4 * a + 3] = scale * solution_[a] + mass_[a] * right_[a];
  }
  tangent_.halo().update_ghosts(z);
  tangent_.apply_to_pressure(z, w);
  velocity_block(v, factor, w, z);
  const auto add_multipliers = [this, z](float* product) {
    const Timed timed("multiplier term");
    coupling_->interpolate(z, 4, rows_.data());
    interface_->solve(rows_.data());
    coupling_->spread(rows_.data(), 4, product, 1.0);
  };
  tangent_.add_velocity(z, w, has_multipliers() ? std::function<void(float*)>(add_multipliers) : nullptr);
}

}  // namespace fbi::fsi
