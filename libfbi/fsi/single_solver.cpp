#include "fsi/single_solver.hpp"

#include <algorithm>

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
      velocity_(4 * nodes_),
      pressure_(4 * nodes_),
      product_(4 * nodes_),
      gradient_(4 * nodes_),
      force_(coupling != nullptr ? 4 * nodes_ : 0),
      right_(owned_),
      solution_(owned_),
      krylov_(
          fluid.mesh().comm, 4 * owned_, [this](const float* v, float* z, float* w) { step(v, z, w); }, restart) {}

void SingleSolver::prepare(const SinglePreconditioner& preconditioner) {
  parts_ = preconditioner;
  const std::vector<double>& weight = *parts_.weight;
  for (std::size_t a = 0; a < nodes_; ++a)
    for (int i = 0; i < 3; ++i) weight_[4 * a + i] = static_cast<float>(weight[3 * a + i]);
  const std::vector<double>& volume = fluid_.lumped_volume();
  for (std::size_t a = 0; a < owned_; ++a) mass_[a] = static_cast<float>(parts_.mass_scale / volume[a]);
  if (coupling_ != nullptr) rows_.resize(3 * static_cast<std::size_t>(coupling_->rows()));
}

linalg::KrylovResult SingleSolver::solve(float* b, float* x, double tolerance, int maximum) {
  return krylov_.solve(b, x, tolerance, maximum);
}

/// velocity_ <- (W^-1 + M^T S^-1 M)^-1 times `v` - gradient_, with ghosts. Collective.
void SingleSolver::velocity_block(const float* v) {
  const Timed timed("velocity block");
  const fluid::Halo& halo = tangent_.halo();
  for (std::size_t k = 0; k < 4 * owned_; ++k) velocity_[k] = weight_[k] * (v[k] - gradient_[k]);
  tangent_.remove_normal(velocity_.data(), static_cast<Index>(owned_));
  halo.update_ghosts(velocity_.data());
  if (!has_multipliers()) return;
  coupling_->interpolate(velocity_.data(), 4, rows_.data());
  {
    const Timed timed_factor("multiplier solve");
    parts_.factor->solve(rows_.data());
  }
  coupling_->spread(rows_.data(), 4, force_.data(), 1.0);
  halo.add_ghosts(force_.data());
  tangent_.remove_normal(force_.data(), static_cast<Index>(owned_));
  for (std::size_t k = 0; k < 4 * owned_; ++k) {
    velocity_[k] -= weight_[k] * force_[k];
    force_[k] = 0.0f;
  }
  std::fill(force_.begin() + static_cast<std::ptrdiff_t>(4 * owned_), force_.end(), 0.0f);
  tangent_.remove_normal(velocity_.data(), static_cast<Index>(owned_));
  halo.update_ghosts(velocity_.data());
}

void SingleSolver::step(const float* v, float* z, float* w) {
  const float scale = static_cast<float>(parts_.continuity_scale);
  {
    const Timed timed("pressure solve");
    for (std::size_t a = 0; a < owned_; ++a) right_[a] = v[4 * a + 3] / scale;
    parts_.pressure->apply(right_.data(), solution_.data());
    const float factor = static_cast<float>(parts_.pressure_scale);
    for (std::size_t a = 0; a < owned_; ++a) {
      solution_[a] = factor * solution_[a] + mass_[a] * right_[a];
      pressure_[4 * a + 3] = solution_[a];
    }
  }
  tangent_.halo().update_ghosts(pressure_.data());
  tangent_.apply_to_pressure(pressure_.data(), gradient_.data());
  velocity_block(v);
  const auto add_multipliers = [this](float* product) {
    const Timed timed("multiplier term");
    coupling_->interpolate(velocity_.data(), 4, rows_.data());
    interface_->solve(rows_.data());
    coupling_->spread(rows_.data(), 4, product, 1.0);
  };
  tangent_.apply_to_velocity(velocity_.data(), product_.data(),
                             has_multipliers() ? std::function<void(float*)>(add_multipliers) : nullptr);
  for (std::size_t a = 0; a < owned_; ++a) {
    for (std::size_t k = 4 * a; k < 4 * a + 3; ++k) {
      z[k] = velocity_[k];
      w[k] = product_[k] + gradient_[k];
    }
    const std::size_t k = 4 * a + 3;
    z[k] = solution_[a];
    w[k] = scale * (product_[k] + gradient_[k]);
  }
}

}  // namespace fbi::fsi
