#include "fsi/single_solver.hpp"

#include <algorithm>
#include <cmath>

#include "base/counters.hpp"
#include "base/node_vector.hpp"
#include "base/timer.hpp"

namespace fbi::fsi {

namespace {

constexpr double enough_of_it = 0.07;     // residual of the momentum rows that ends sweeps, relative
constexpr float convection_part = 0.35f;  // of C in the pressure: it does not quite commute with the gradient
constexpr float fiber_part = 1.4f;        // of what fibers do to the pressure, to first order
constexpr int most_directions = 8;
constexpr double enough_of_rows = 0.02;  // residual of the multipliers' rows that ends their iteration, relative
constexpr std::size_t strip = 16;        // numbers of four nodes
constexpr std::size_t chunk = 4096;

/// Sum of a b over the velocities of nodes, shape=(nodes,4): strips in floats, then in double.
double velocity_dot(const float* a, const float* b, std::size_t size) {
  double total = 0.0;
  for (std::size_t begin = 0; begin < size; begin += chunk) {
    const std::size_t end = std::min(size, begin + chunk);
    float sum[strip] = {};
    std::size_t k = begin;
    for (; k + strip <= end; k += strip)
      for (std::size_t i = 0; i < strip; ++i) sum[i] += a[k + i] * b[k + i];
    for (std::size_t i = 0; k + i < end; ++i) sum[i] += a[k + i] * b[k + i];
    for (std::size_t i = 0; i < strip; ++i)
      if (i % 4 != 3) total += sum[i];
  }
  return total;
}

void add(float* to, float factor, const float* from, std::size_t size) {
  for (std::size_t k = 0; k < size; ++k) to[k] += factor * from[k];
}

}  // namespace

SingleSolver::SingleSolver(fluid::FluidField& fluid, fluid::SingleTangent& tangent, const coupling::Coupling* coupling,
                           const coupling::InterfaceOperator* interface, int restart)
    : fluid_(fluid),
      tangent_(tangent),
      coupling_(coupling),
      interface_(interface),
      owned_(fluid.mesh().owned_nodes),
      nodes_(fluid.mesh().local_nodes()),
      mass_(owned_),
      force_(coupling != nullptr ? 4 * nodes_ : 0),
      right_(owned_),
      solution_(owned_),
      krylov_(
          fluid.mesh().comm, 4 * owned_, 4 * nodes_,
          [this](const float* v, float factor, float* z, float* w) { step(v, factor, z, w); }, restart) {}

void SingleSolver::prepare(const SinglePreconditioner& preconditioner) {
  parts_ = preconditioner;
  if (parts_.weight != nullptr) {
    const std::vector<double>& weight = *parts_.weight;
    weight_.resize(4 * nodes_);
    for (std::size_t a = 0; a < nodes_; ++a)
      for (int i = 0; i < 3; ++i) weight_[4 * a + i] = static_cast<float>(weight[3 * a + i]);
  }
  const std::vector<double>& volume = fluid_.lumped_volume();
  for (std::size_t a = 0; a < owned_; ++a) mass_[a] = static_cast<float>((*parts_.mass_scale)[a] / volume[a]);
  tangent_.set_continuity_scale(parts_.continuity_scale);
  if (parts_.lines != nullptr) {
    given_.clear();
    for (const std::size_t k : fluid_.boundaries().fixed())
      if (k % 4 != 3) given_.push_back(k);
    line_right_.resize(4 * owned_);
  }
  if (!has_multipliers()) return;
  rows_.resize(3 * static_cast<std::size_t>(coupling_->rows()));
  find_touched();
  if (!has_lines_alone()) return;
  std::vector<char> reached = parts_.lines->reached(touched_);
  if (reached == reached_ && reached_version_ == parts_.lines->version()) return;
  reached_ = std::move(reached);
  reached_version_ = parts_.lines->version();
  find_reached();
}

/// Nodes of the lines that forces reach, with all ghosts, and the given velocities there; elsewhere directions are
/// zero.
void SingleSolver::find_reached() {
  std::vector<char> node = parts_.lines->nodes_of(reached_);
  node.resize(nodes_, 1);
  for (const auto& [begin, end] : reached_nodes_)
    for (std::size_t a = begin; a < end; ++a)
      if (node[a] == 0)
        for (Direction& direction : directions_)
          if (!direction.velocity.empty()) store_node(NodeVector<float>{}, &direction.velocity[4 * a]);
  reached_nodes_.clear();
  for (std::size_t a = 0; a < nodes_; ++a) {
    if (node[a] == 0) continue;
    if (reached_nodes_.empty() || reached_nodes_.back().second != a) reached_nodes_.emplace_back(a, a);
    reached_nodes_.back().second = a + 1;
  }
  reached_given_.clear();
  for (const std::size_t k : given_)
    if (node[k / 4] != 0) reached_given_.push_back(k);
}

linalg::KrylovResult SingleSolver::solve(float* b, float* x, double tolerance, int maximum, const Effort& effort) {
  effort_ = effort;
  if (fluid_.parameters().convective_form == fluid::ConvectiveForm::none) effort_.convection = false;
  if (effort_.convection) {
    if (convection_ == nullptr) convection_ = std::make_unique<PressureConvection>(fluid_);
    convection_->renew();
  }
  return krylov_.solve(b, x, tolerance, maximum, effort_.impatient);
}

void SingleSolver::find_touched() {
  for (const Index node : coupling_->local_m().node) force_[4 * static_cast<std::size_t>(node)] = 1.0f;
  tangent_.halo().add_ghosts(force_.data());
  touched_.clear();
  for (std::size_t a = 0; a < owned_; ++a)
    if (force_[4 * a] != 0.0f) touched_.push_back(static_cast<Index>(a));
  std::fill(force_.begin(), force_.end(), 0.0f);
}

/// velocity = (W^-1 + M^T S^-1 M)^-1 (factor v - gradient), or V^-1 for W^-1, with ghosts; fourth entries stay.
/// Collective.
void SingleSolver::velocity_block(const float* v, float factor, const float* gradient, float* velocity) {
  const Timed timed("velocity block");
  if (has_lines_alone()) return line_block(v, factor, gradient, velocity);
  const fluid::Halo& halo = tangent_.halo();
  for (std::size_t k = 0; k < 4 * owned_; k += 4) {
    NodeVector<float> right = factor * load_node(v + k);
    if (gradient != nullptr) right -= load_node(gradient + k);
    store_node(three_and_one<float>(load_node(&weight_[k]) * right, load_node(velocity + k)), velocity + k);
  }
  tangent_.remove_normal(velocity, static_cast<Index>(owned_));
  halo.update_ghosts(velocity);
  if (!has_multipliers()) return;
  coupling_->interpolate(velocity, rows_.data());
  {
    const Timed timed_factor("multiplier solve");
    parts_.factor->solve(rows_.data());
  }
  coupling_->spread(rows_.data(), force_.data(), 1.0);
  halo.add_ghosts(force_.data());
  tangent_.remove_normal(force_.data(), static_cast<Index>(owned_));
  for (const Index a : touched_) {
    const std::size_t k = 4 * static_cast<std::size_t>(a);
    store_node<float>(load_node(velocity + k) - load_node(&weight_[k]) * load_node(&force_[k]), velocity + k);
    store_node(NodeVector<float>{}, &force_[k]);
  }
  std::fill(force_.begin() + static_cast<std::ptrdiff_t>(4 * owned_), force_.end(), 0.0f);
  tangent_.remove_normal(velocity, static_cast<Index>(owned_));
  halo.update_ghosts(velocity);
}

void SingleSolver::apply_lines(float* r, float* x, const std::vector<char>* only) {
  const Timed timed("lines");
  const std::vector<std::size_t>& given = only != nullptr ? reached_given_ : given_;
  for (const std::size_t k : given) r[k] = 0.0f;
  tangent_.remove_normal(r, static_cast<Index>(owned_));
  parts_.lines->apply(r, x, only);
  for (const std::size_t k : given) x[k] = 0.0f;
  tangent_.remove_normal(x, static_cast<Index>(owned_));
  tangent_.halo().update_ghosts(x);
}

/// velocity_block with V in place of W.
void SingleSolver::line_block(const float* v, float factor, const float* gradient, float* velocity) {
  for (std::size_t k = 0; k < 4 * owned_; k += 4) {
    NodeVector<float> right = factor * load_node(v + k);
    if (gradient != nullptr) right -= load_node(gradient + k);
    store_node(right, &line_right_[k]);
  }
  apply_lines(line_right_.data(), velocity);
  if (has_multipliers()) add_constraint(velocity);
}

void SingleSolver::smoothed_block(const float* r, float* z, float* w) {
  std::copy_n(r, 4 * owned_, line_right_.data());
  apply_lines(line_right_.data(), z);
  tangent_.add_velocity(z, w, nullptr);
  for (std::size_t k = 0; k < 4 * owned_; ++k) w[k] = r[k] - w[k] + (weight_[k] > 0.0f ? z[k] / weight_[k] : 0.0f);
  velocity_block(w, 1.0f, nullptr, z);
  std::fill_n(w, 4 * nodes_, 0.0f);
}

/// T lambda = M velocity to a few per cent: what is left of it comes back as a force of S^-1 times it. In the end rows_
/// is S^-1 M velocity.
void SingleSolver::add_constraint(float* velocity) {
  const Timed timed("multiplier solve");
  const Comm& comm = fluid_.mesh().comm;
  const fluid::Halo& halo = tangent_.halo();
  const std::size_t size = rows_.size();
  ++multiplier_steps_.solves;
  coupling_->interpolate(velocity, rows_.data());
  law_.resize(size);
  residuals_.start();
  for (int i = 0; i < most_directions; ++i) {
    if (i == static_cast<int>(directions_.size())) directions_.emplace_back();
    Direction& here = directions_[i];
    std::vector<double>& product = residuals_.product();
    product.resize(size);
    here.velocity.resize(4 * nodes_);
    here.multipliers = rows_;
    count("multiplier iterations");
    ++multiplier_steps_.steps;
    parts_.factor->precondition(here.multipliers.data());
    coupling_->spread(here.multipliers.data(), force_.data(), 1.0);
    halo.add_ghosts(force_.data());
    apply_lines(force_.data(), here.velocity.data(), &reached_);
    for (const Index a : touched_) store_node(NodeVector<float>{}, &force_[4 * static_cast<std::size_t>(a)]);
    std::fill(force_.begin() + static_cast<std::ptrdiff_t>(4 * owned_), force_.end(), 0.0f);
    coupling_->interpolate(here.velocity.data(), product.data());
    interface_->apply(here.multipliers.data(), law_.data());
    for (std::size_t k = 0; k < size; ++k) product[k] += law_[k];
    // rows_ becomes the residual.
    if (residuals_.step(comm, rows_, enough_of_rows) != linalg::MinimalResiduals::State::goes_on) break;
  }
  // lambda = sum_i c_i z_i.
  const std::vector<double> coefficient = residuals_.coefficients();
  const int used = static_cast<int>(coefficient.size());
  float c[most_directions] = {};
  for (int i = 0; i < used; ++i) c[i] = static_cast<float>(coefficient[i]);
  for (const auto& [begin, end] : reached_nodes_)
    for (std::size_t k = 4 * begin; k < 4 * end; k += 4) {
      NodeVector<float> u = load_node(velocity + k);
      for (int i = 0; i < used; ++i) u -= c[i] * load_node(&directions_[i].velocity[k]);
      store_node(three_and_one<float>(u, load_node(velocity + k)), velocity + k);
    }
  // M velocity is S lambda and what T lambda has left of it.
  interface_->solve(rows_.data());
  for (int i = 0; i < used; ++i)
    for (std::size_t k = 0; k < size; ++k) rows_[k] += coefficient[i] * directions_[i].multipliers[k];
  interface_->clear_inactive(rows_.data());
}

void SingleSolver::add_multipliers(const float* z, float* product) {
  const Timed timed("multiplier term");
  if (!has_lines_alone()) {
    coupling_->interpolate(z, rows_.data());
    interface_->solve(rows_.data());
  }
  coupling_->spread(rows_.data(), product, 1.0);
}

void SingleSolver::apply_velocity(const float* z, float* w) {
  tangent_.add_velocity(z, w,
                        has_multipliers()
                            ? std::function<void(float*)>([this, z](float* product) { add_multipliers(z, product); })
                            : nullptr);
}

void SingleSolver::solve_pressure(float* z, float* w) {
  const Timed timed("pressure solve");
  parts_.pressure->apply(right_.data(), solution_.data());
  if (effort_.convection) {
    for (std::size_t a = 0; a < owned_; ++a) z[4 * a + 3] = solution_[a];
    tangent_.halo().update_ghosts(z);
    std::fill_n(w, 4 * nodes_, 0.0f);
    convection_->add(z, w);
    tangent_.halo().add_ghosts(w);
  }
  const float scale = static_cast<float>(parts_.pressure_scale);
  for (std::size_t a = 0; a < owned_; ++a) z[4 * a + 3] = scale * solution_[a] + mass_[a] * right_[a];
  if (!effort_.convection) return;
  const std::vector<double>& volume = fluid_.lumped_volume();
  for (std::size_t a = 0; a < owned_; ++a)
    z[4 * a + 3] += convection_part / static_cast<float>(volume[a]) * w[4 * a + 3];
}

void SingleSolver::add_fibers(float* z, float* w) {
  const Timed timed("pressure of fibers");
  const fluid::Halo& halo = tangent_.halo();
  // V knows more of the answer to a force than W does.
  const std::vector<char>* only = has_lines_alone() ? &reached_ : nullptr;
  // lambda = T^-1 E p_0
  answer_.assign(4 * nodes_, 0.0f);
  std::copy_n(w, 4 * owned_, line_right_.data());
  apply_lines(line_right_.data(), answer_.data(), only);
  coupling_->interpolate(answer_.data(), rows_.data());
  if (has_lines_alone())
    parts_.factor->precondition(rows_.data());
  else
    parts_.factor->solve(rows_.data());
  // E' lambda in the continuity rows of w
  coupling_->spread(rows_.data(), force_.data(), 1.0);
  halo.add_ghosts(force_.data());
  apply_lines(force_.data(), answer_.data(), only);
  for (const Index a : touched_) store_node(NodeVector<float>{}, &force_[4 * static_cast<std::size_t>(a)]);
  std::fill(force_.begin() + static_cast<std::ptrdiff_t>(4 * owned_), force_.end(), 0.0f);
  std::fill_n(w, 4 * nodes_, 0.0f);
  tangent_.add_velocity(answer_.data(), w, nullptr);
  const float unscaled = 1.0f / static_cast<float>(parts_.continuity_scale);
  first_pressure_.resize(owned_);
  for (std::size_t a = 0; a < owned_; ++a) {
    first_pressure_[a] = z[4 * a + 3];
    right_[a] = unscaled * w[4 * a + 3];
  }
  solve_pressure(z, w);
  for (std::size_t a = 0; a < owned_; ++a) z[4 * a + 3] = first_pressure_[a] - fiber_part * z[4 * a + 3];
  halo.update_ghosts(z);
  tangent_.apply_to_pressure(z, w);
}

void SingleSolver::sweep(float* z, float* w) {
  const std::size_t size = 4 * owned_, room = 4 * nodes_;
  const Comm& comm = fluid_.mesh().comm;
  const double start = comm.sum(velocity_dot(rest_.data(), rest_.data(), size));
  if (!(start > 0.0) || !std::isfinite(start)) return;
  for (int j = 0; j < effort_.sweeps; ++j) {
    if (j == static_cast<int>(sweeps_.size())) sweeps_.emplace_back();
    Sweep& here = sweeps_[j];
    here.z.assign(room, 0.0f);
    here.w.assign(room, 0.0f);
    if (j % 2 == 1 && !has_lines_alone() && parts_.lines != nullptr)
      smoothed_block(rest_.data(), here.z.data(), here.w.data());
    else
      velocity_block(rest_.data(), 1.0f, nullptr, here.z.data());
    apply_velocity(here.z.data(), here.w.data());
    for (int i = 0; i < j; ++i) {
      const double product = comm.sum(velocity_dot(sweeps_[i].w.data(), here.w.data(), size));
      const float h = static_cast<float>(product / sweeps_[i].squared_norm);
      add(here.w.data(), -h, sweeps_[i].w.data(), size);
      add(here.z.data(), -h, sweeps_[i].z.data(), room);
    }
    double sums[2] = {velocity_dot(here.w.data(), here.w.data(), size),
                      velocity_dot(rest_.data(), here.w.data(), size)};
    comm.sum(sums, 2);
    here.squared_norm = sums[0];
    if (!(sums[0] > 0.0)) return;
    const float alpha = static_cast<float>(sums[1] / sums[0]);
    add(z, alpha, here.z.data(), room);
    add(w, alpha, here.w.data(), size);
    add(rest_.data(), -alpha, here.w.data(), size);
    if (comm.sum(velocity_dot(rest_.data(), rest_.data(), size)) <= enough_of_it * enough_of_it * start) return;
  }
}

void SingleSolver::step(const float* v, float factor, float* z, float* w) {
  const float unscaled = factor / static_cast<float>(parts_.continuity_scale);
  for (std::size_t a = 0; a < owned_; ++a) right_[a] = unscaled * v[4 * a + 3];
  solve_pressure(z, w);
  tangent_.halo().update_ghosts(z);
  tangent_.apply_to_pressure(z, w);
  if (effort_.fibers && parts_.lines != nullptr && has_multipliers()) add_fibers(z, w);
  if (effort_.sweeps <= 1) {
    velocity_block(v, factor, w, z);
    apply_velocity(z, w);
    return;
  }
  for (std::size_t a = 0; a < nodes_; ++a)
    for (std::size_t k = 4 * a; k < 4 * a + 3; ++k) z[k] = 0.0f;
  rest_.resize(4 * owned_);
  for (std::size_t k = 0; k < 4 * owned_; ++k) rest_[k] = factor * v[k] - w[k];
  sweep(z, w);
}

}  // namespace fbi::fsi
