#include "fsi/system.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/error.hpp"
#include "base/log.hpp"
#include "base/node_vector.hpp"
#include "base/timer.hpp"
#include "linalg/vector_access.hpp"

namespace fbi::fsi {

constexpr Index most_joined_nodes = 2000;  // 36e6 entries of S, as many of its factors

System::System(fluid::FluidField* fluid, beam::BeamField* beams, const mesh::FiberMesh* fibers,
               const coupling::CouplingParameters& coupling_parameters, const SchemeParameters& scheme,
               const SolverParameters& solver)
    : fluid_(fluid),
      beams_(beams),
      fibers_(fibers),
      coupling_parameters_(coupling_parameters),
      scheme_(scheme),
      solver_parameters_(with_tolerances(solver,
                                         fluid != nullptr && !fluid->is_steady() && scheme.scheme == Scheme::monolithic,
                                         fluid != nullptr && fluid->is_second_order())),
      comm_(fluid != nullptr ? fluid->mesh().comm : fibers->comm) {
  if (beams_ != nullptr) {
    fibers_move_ = comm_.any(beams_->moving_fibers() > 0);
    has_joints_ = comm_.any(!fibers_->joined.empty());
    force_old_.assign(6 * static_cast<std::size_t>(fibers_->nodes()), 0.0);
    last_force_ = last_motion_ = force_older_ = force_oldest_ = force_old_;
  }
  if (fluid_ != nullptr) {
    fluid_->set_linearization(solver.nonlinear);
    for (Index a = 0; a < fluid_->mesh().owned_nodes; ++a)
      node_size_.push_back(static_cast<float>(std::cbrt(fluid_->lumped_volume()[a])));
  }
  if (fluid_ == nullptr || beams_ == nullptr) return;
  check_group_sizes();
  coupling_ = std::make_unique<coupling::Coupling>(fluid_->mesh(), *fibers_, coupling_parameters_);
  interface_ = std::make_unique<coupling::InterfaceOperator>(*fibers_);
  lambda_.assign(3 * static_cast<std::size_t>(coupling_->rows()), 0.0);
  lambda_old_ = lambda_;
}

void System::check_group_sizes() const {
  std::string text;
  const bool keeps_blocks =
      (scheme_.scheme == Scheme::monolithic && scheme_.direction != Direction::fluid_only) || scheme_.implicit_penalty;
  for (const std::vector<Index>& group : fibers_->joined) {
    Index nodes = 0;
    for (const Index f : group) nodes += fibers_->first_node[f + 1] - fibers_->first_node[f];
    if (nodes <= most_joined_nodes || !keeps_blocks) continue;
    text = log::format(
        "fiber \"%s\" hangs together with others by joints, %d nodes in all; %s keeps a "
        "dense block of them and takes at most %d: use coarser fibers, fewer joints, or \"scheme\": "
        "\"aitken\" without implicit_penalty",
        fibers_->name[group[0]].c_str(), nodes,
        scheme_.scheme == Scheme::monolithic ? "the monolithic scheme" : "implicit_penalty", most_joined_nodes);
    break;
  }
  agree_on_error(comm_, ExitCode::usage, text);
}

double System::weight() const {
  if (scheme_.coupling_weight == CouplingWeight::one_minus_alpha_f) return 1.0 - beams_->alpha_f();
  return fluid_->theta();
}

namespace {

constexpr double most_net_flow = 0.05;  // of the given velocities; what discretisation leaves is far below

/// Small net flows, of curved walls cut into flat faces, are spread over the continuity rows; large ones are errors.
void check_boundary_flow(const fluid::FluidField& fluid, double time) {
  constexpr double round_off = 1e-9;  // slip and periodic faces leave some
  const std::array<double, 3> flow = fluid.boundary_flow();
  if (!(std::abs(flow[0]) > most_net_flow * flow[1] + round_off * flow[2])) return;
  throw Error(ExitCode::usage,
              log::format("at t = %.6g the velocities given on the boundary leave a net flow of %.6g out of a fluid "
                          "that has no open face; make them balance, or give one face the type outflow",
                          time, flow[0]));
}

}  // namespace

void System::begin_step(double time, double dt) {
  dt_ = dt;
  if (beams_ != nullptr) {
    // The first step has no step before it; the motion that it goes on from is that of the initial velocity.
    if (time < 1.5 * dt)
      for (std::size_t k = 0; k < last_motion_.size(); ++k) last_motion_[k] = dt * beams_->accepted_velocity()[k];
    beams_->begin_step(time, dt);
  }
  if (fluid_ == nullptr) return;
  fluid_->begin_step(time, dt);
  if (fluid_->pressure_is_free()) check_boundary_flow(*fluid_, time);
  if (coupling_ != nullptr && coupling_->needs_stabilization()) {
    warn_of_fast_flow();
    coupling_->set_stabilization(stabilization());
  }
  if (solver_ == nullptr)
    solver_ = std::make_unique<FluidSolver>(*fluid_, fluid_feels_fibers() ? coupling_.get() : nullptr,
                                            fluid_feels_fibers() ? interface_.get() : nullptr, solver_parameters_);
}

void System::warn_of_fast_flow() {
  constexpr double calibrated = 2.0;  // within 3 % up to 1, 7 % at 2
  const fluid::FluidParameters& parameters = fluid_->parameters();
  const double reynolds = parameters.density * fluid_->max_velocity() * fluid_->smallest_cell() / parameters.viscosity;
  if (warned_of_fast_flow_ || !(reynolds > calibrated)) return;
  warned_of_fast_flow_ = true;
  log::warning(
      "\"penalty\": \"auto\" holds for slow flow past the fibers: the Reynolds number of a cell, rho |v| h/mu, should "
      "stay below %g and is up to %.3g: the drag of the fibers will be too small",
      calibrated, reynolds);
}

std::vector<coupling::CellViscosity> System::stabilization() const {
  const double viscosity = fluid_->parameters().viscosity;
  std::vector<coupling::CellViscosity> cells(fluid_->mesh().local_cells());
  for (Index c = 0; c < fluid_->mesh().local_cells(); ++c) {
    const double size = std::cbrt(fluid_->cell_volume(c));
    cells[c] = {fluid_->tau_m()[c] * viscosity / (size * size), fluid_->tau_c(c) / viscosity};
  }
  return cells;
}

void System::accept_step() {
  if (coupling_ != nullptr) {
    if (scheme_.direction != Direction::fluid_only) last_force_ = fiber_force(lambda_);
    lambda_old_ = lambda_;
    if (!coupling_->has_fixed_rows()) line_force_ = coupling_->at_nodes(lambda_old_);
    force_oldest_ = std::move(force_older_);
    force_older_ = force_old_;
    std::fill(force_old_.begin(), force_old_.end(), 0.0);
    coupling_->add_d_transposed(lambda_.data(), force_old_, 1.0);
  }
  older_dt_ = last_dt_;
  last_dt_ = dt_;
  if (fluid_ != nullptr) fluid_->accept_step();
  if (beams_ == nullptr) return;
  last_motion_ = beams_->accepted_dofs();
  beams_->accept_step();
  for (std::size_t k = 0; k < last_motion_.size(); ++k) last_motion_[k] = beams_->accepted_dofs()[k] - last_motion_[k];
}

bool System::update_geometry(const std::vector<double>& dofs) {
  if (!comm_.any(!has_geometry_ || geometry_dofs_ != dofs)) return false;
  Timed timed("search and D, M, kappa");
  coupling_->update(dofs);
  geometry_dofs_ = dofs;
  has_geometry_ = true;
  return true;
}

bool System::take_staleness() {
  const bool stale = stale_ || solver_dt_ != dt_;
  stale_ = false;
  solver_dt_ = dt_;
  return stale;
}

std::vector<double> System::first_positions() const {
  if (scheme_.geometry_update == GeometryUpdate::iterated) return beams_->dofs();
  std::vector<double> dofs = beams_->accepted_dofs();
  const double ratio = last_dt_ > 0.0 ? dt_ / last_dt_ : 1.0;
  if (scheme_.geometry_update == GeometryUpdate::extrapolated)
    for (std::size_t k = 0; k < dofs.size(); ++k) dofs[k] += ratio * last_motion_[k];
  return dofs;
}

std::array<double, 3> System::extrapolation(int degree) const {
  const double h0 = dt_, h1 = last_dt_ > 0.0 ? last_dt_ : dt_, h2 = older_dt_ > 0.0 ? older_dt_ : h1;
  if (degree == 0 || !(h0 > 0.0)) return {1.0, 0.0, 0.0};
  if (degree == 1) return {1.0 + h0 / h1, -h0 / h1, 0.0};
  return {(h0 + h1) * (h0 + h1 + h2) / (h1 * (h1 + h2)), -h0 * (h0 + h1 + h2) / (h1 * h2),
          h0 * (h0 + h1) / ((h1 + h2) * h2)};
}

std::vector<std::pair<std::string, std::vector<double>*>> System::fiber_state() {
  std::vector<std::pair<std::string, std::vector<double>*>> list;
  if (beams_ != nullptr) list = beams_->state();
  if (is_coupled())
    list.insert(list.end(), {{"coupling_force", &force_old_},
                             {"coupling_force_older", &force_older_},
                             {"coupling_force_oldest", &force_oldest_},
                             {"last_motion", &last_motion_}});
  return list;
}

std::vector<double> System::line_force() const {
  return coupling_->has_fixed_rows() || line_force_.empty() ? coupling_->at_nodes(lambda_old_) : line_force_;
}

void System::interpolate(Vec u, std::vector<double>& out) const { fsi::interpolate(*coupling_, u, out); }

void System::drop_caches() {
  has_geometry_ = stale_ = false;
  solver_dt_ = -1.0;
  solver_.reset();
}

std::vector<double> System::fiber_force(const std::vector<double>& lambda) const {
  const double w = weight();
  std::vector<double> force(force_old_.size());
  for (std::size_t k = 0; k < force.size(); ++k) force[k] = (1.0 - w) * force_old_[k];
  coupling_->add_d_transposed(lambda.data(), force, w);
  return force;
}

std::vector<double> System::slip() const {
  std::vector<double> slip, fiber(3 * static_cast<std::size_t>(coupling_->rows()));
  interpolate(fluid_->iterate(), slip);
  coupling_->apply_d(beams_->velocity(), fiber.data());
  for (std::size_t k = 0; k < slip.size(); ++k) slip[k] -= fiber[k];
  return slip;
}

double System::constraint_violation() const {
  if (coupling_ == nullptr || solver_ == nullptr) return 0.0;
  const std::vector<double> difference = slip();
  double largest = 0.0;
  for (Index p = 0; p < coupling_->rows(); ++p) {
    if (!interface_->is_active(p)) continue;
    for (int i = 0; i < 3; ++i)
      largest = std::max(largest, std::abs(difference[3 * static_cast<std::size_t>(p) + i]) / coupling_->kappa()[p]);
  }
  largest = comm_.max(largest);
  const double speed = fluid_->max_velocity();
  return speed > 0.0 ? largest / speed : largest;
}

void System::fluid_residual(const std::vector<double>& lambda, Vec r, bool linearize) const {
  std::function<void(double*)> forces;
  if (fluid_feels_fibers()) forces = [&](double* force) { coupling_->spread(lambda.data(), force, 1.0); };
  fluid_->residual(r, forces, linearize);
  solver_->project_residual(r);
}

double System::fluid_norm(Vec r) const {
  const double scale = solver_->continuity_scale();
  const double* values = nullptr;
  FBI_PETSC(VecGetArrayRead(r, &values));
  const NodeVector<double> weight = {1.0, 1.0, 1.0, scale};
  NodeVector<double> sum = {};
  for (Index a = 0; a < fluid_->mesh().owned_nodes; ++a) {
    const NodeVector<double> row = weight * load_node(values + 4 * static_cast<std::size_t>(a));
    sum += row * row;
  }
  FBI_PETSC(VecRestoreArrayRead(r, &values));
  return std::sqrt(comm_.sum(sum[0] + sum[1] + sum[2] + sum[3]));
}

FluidScale System::fluid_scale() const {
  const double sigma = fluid_->is_steady() ? 0.0 : fluid_->sigma();
  const fluid::FluidParameters& parameters = fluid_->parameters();
  const std::vector<double>& volume = fluid_->lumped_volume();
  const double* values = nullptr;
  FBI_PETSC(VecGetArrayRead(fluid_->iterate(), &values));
  NodeVector<double> sum = {};
  for (Index a = 0; a < fluid_->mesh().owned_nodes; ++a) {
    const double h = node_size_[a];
    const double factor = parameters.viscosity * h + parameters.density * sigma * volume[a];
    const NodeVector<double> row =
        load_node(values + 4 * static_cast<std::size_t>(a)) * NodeVector<double>{factor, factor, factor, h * h};
    sum += row * row;
  }
  FBI_PETSC(VecRestoreArrayRead(fluid_->iterate(), &values));
  double sums[2] = {sum[0] + sum[1] + sum[2], sum[3]};
  comm_.sum(sums, 2);
  return {.momentum = std::sqrt(sums[0]), .forces = std::sqrt(sums[0] + sums[1])};
}

}  // namespace fbi::fsi
