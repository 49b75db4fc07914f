#include "fsi/fluid_solver.hpp"

#include <algorithm>
#include <cmath>

#include "base/counters.hpp"
#include "base/node_vector.hpp"
#include "base/timer.hpp"
#include "coupling/complete_rows.hpp"
#include "fluid/boundary_conditions.hpp"
#include "linalg/vector_access.hpp"
#include "mesh/exchange.hpp"

namespace fbi::fsi {

using linalg::GhostedForm;
using linalg::Read;
using linalg::Write;

namespace {

constexpr int single_restart = 40;
constexpr double tired_effort = 1.5;      // iterations with a factor that lags, against those when it was new
constexpr double useless_effort = 3.0;    // the same: then factors for an earlier S are of no use
constexpr double most_lost_steps = 4.0;   // for multipliers of lines: in the time of as many there is a new factor
constexpr double most_effort = 4.0;       // iterations a decade, then blocks give way to sparse factors and lines to W
constexpr double longest_effort = 8.0;    // the same, of a solve that is not repeated with new factors
constexpr int few_iterations = 15;        // of a solve that says nothing about its effort
constexpr int longest_rest = 64;          // preparations for which lines are left out, at most
constexpr double other_sigma = 0.25;      // change of 1/dt after which a factor is not that of the problem any more
constexpr int tired_iterations = 40;      // of one solve, then it is renewed
constexpr double loose_tolerance = 3e-3;  // above, one sweep of the velocity block in an iteration is fastest
constexpr double slow_flow = 2.0;     // VelocityWeight::strength up to which the same holds, elsewhere a few suffice
constexpr double viscous_flow = 0.5;  // mu/(rho sigma h^2) around fibers from which they are a part of the pressure
constexpr double fast_flow = 4.0;     // strength from which lines are between sweeps with W, and not in its place
constexpr double calmer = 0.7;        // part of that strength below which they come back
constexpr int few_sweeps = 3, many_sweeps = 8;
constexpr double single_digits = 1e-5;   // a solve in single precision goes no further
constexpr double trusted_digits = 1e-4;  // to which its own estimate of the residual is trusted
constexpr double refined_enough = 0.1;   // factor by which a round of refinement must reduce the residual
// Unknowns of steady flow below which factors are used: those of a cube of cells take some 5 GiB then. In time the
// iteration is faster, also where factors are kept.
constexpr GlobalIndex steady_direct_below = 150000;

}  // namespace

bool solves_directly(const SolverParameters& parameters, const fluid::FluidField& fluid) {
  if (parameters.linear == LinearSolver::automatic)
    return fluid.is_steady() && 4 * fluid.mesh().global_nodes < steady_direct_below;
  return parameters.linear == LinearSolver::direct;
}

FluidSolver::FluidSolver(fluid::FluidField& fluid, const coupling::Coupling* coupling,
                         const coupling::InterfaceOperator* interface, const SolverParameters& parameters)
    : fluid_(fluid), coupling_(coupling), interface_(interface), parameters_(parameters), comm_(fluid.mesh().comm) {
  const mesh::HexMesh& mesh = fluid_.mesh();
  ghosted_ = fluid_.create_vector();
  residual_ = fluid_.create_vector();
  increment_ = fluid_.create_vector();
  if (coupling_ != nullptr) rows_.resize(3 * static_cast<std::size_t>(coupling_->rows()));
  // What makes continuity rows forces when there is no time step: rho |v| + mu/h.
  steady_scale_ =
      fluid_.parameters().density * fluid_.max_velocity() + fluid_.parameters().viscosity / fluid_.smallest_cell();
  if (solves_directly(parameters_, fluid_)) {
    direct_ = std::make_unique<ExtendedSystem>(fluid_, coupling_, interface_);
    return;
  }
  scaled_ = fluid_.create_vector();
  if (parameters_.linear == LinearSolver::reference) {
    reference_ = std::make_unique<AssembledSystem>(fluid_, coupling_, interface_, parameters_);
    return;
  }
  weight_ = std::make_unique<VelocityWeight>(fluid_);
  pressure_ = std::make_unique<PressureBlock>(fluid_);
  if (is_single() && fluid_.has_single_precision()) lines_ = make_velocity_lines(fluid_);
  work_ = fluid_.create_vector();
  FBI_PETSC(VecCreateMPI(comm_.get(), mesh.owned_nodes, mesh.independent_nodes, pressure_right_.out()));
  FBI_PETSC(VecDuplicate(pressure_right_, pressure_solution_.out()));
  krylov_ = std::make_unique<linalg::Krylov>(
      comm_, ghosted_, [this](Vec x, Vec y) { apply_operator(x, y); },
      [this](Vec r, Vec x) { apply_preconditioner(r, x); });
}

FluidSolver::~FluidSolver() = default;

double FluidSolver::continuity_scale() const {
  if (fluid_.is_steady()) return steady_scale_;
  return fluid_.parameters().density * fluid_.sigma() * fluid_.smallest_cell();
}

double FluidSolver::project_residual(Vec r) const {
  if (!fluid_.pressure_is_free()) return 0.0;
  const mesh::HexMesh& mesh = fluid_.mesh();
  Write values(r);
  double sum = 0.0;
  for (Index a = 0; a < mesh.owned_nodes; ++a) sum += values.get()[4 * static_cast<std::size_t>(a) + 3];
  const double mean = comm_.sum(sum) / static_cast<double>(mesh.independent_nodes);
  for (Index a = 0; a < mesh.owned_nodes; ++a) values.get()[4 * static_cast<std::size_t>(a) + 3] -= mean;
  return mean;
}

void FluidSolver::remove_mean_pressure(Vec x) const {
  if (!fluid_.pressure_is_free()) return;
  const mesh::HexMesh& mesh = fluid_.mesh();
  const std::vector<double>& volume = fluid_.lumped_volume();
  Write values(x);
  double sums[2] = {0.0, 0.0};
  for (Index a = 0; a < mesh.owned_nodes; ++a) {
    sums[0] += volume[a] * values.get()[4 * static_cast<std::size_t>(a) + 3];
    sums[1] += volume[a];
  }
  comm_.sum(sums, 2);
  for (Index a = 0; a < mesh.owned_nodes; ++a) values.get()[4 * static_cast<std::size_t>(a) + 3] -= sums[0] / sums[1];
}

void interpolate(const coupling::Coupling& coupling, Vec u, std::vector<double>& out) {
  Timed timed("M v");
  out.resize(3 * static_cast<std::size_t>(coupling.rows()));
  GhostedForm form(u);
  Read values(form.get());
  coupling.interpolate(values.get(), out.data());
}

void FluidSolver::add_spread(const std::vector<double>& lambda, Vec r, bool dirichlet_rows) const {
  Timed timed("M^T lambda");
  {
    GhostedForm form(ghosted_);
    FBI_PETSC(VecSet(form.get(), 0.0));
    Write values(form.get());
    coupling_->spread(lambda.data(), values.get(), 1.0);
  }
  FBI_PETSC(VecGhostUpdateBegin(ghosted_, ADD_VALUES, SCATTER_REVERSE));
  FBI_PETSC(VecGhostUpdateEnd(ghosted_, ADD_VALUES, SCATTER_REVERSE));
  if (!dirichlet_rows && fluid_.has_normal_constraints())
    fluid_.remove_normal(Write(ghosted_).get(), fluid_.mesh().owned_nodes);
  Read force(ghosted_);
  Write residual(r);
  const std::vector<char>& dirichlet = fluid_.is_dirichlet();
  const std::size_t owned = 4 * static_cast<std::size_t>(fluid_.mesh().owned_nodes);
  for (std::size_t k = 0; k < owned; ++k)
    if (dirichlet_rows || dirichlet[k] == 0) residual.get()[k] += force.get()[k];
}

void FluidSolver::apply_operator(Vec x, Vec y) {
  fluid_.apply_jacobian(x, y);
  if (coupling_ != nullptr && coupling_->global_rows() > 0) {
    {
      Read from(x);
      Write to(ghosted_);
      const std::vector<char>& dirichlet = fluid_.is_dirichlet();
      const std::size_t owned = 4 * static_cast<std::size_t>(fluid_.mesh().owned_nodes);
      for (std::size_t k = 0; k < owned; ++k) to.get()[k] = dirichlet[k] != 0 ? 0.0 : from.get()[k];
      fluid_.remove_normal(to.get(), fluid_.mesh().owned_nodes);
    }
    FBI_PETSC(VecGhostUpdateBegin(ghosted_, INSERT_VALUES, SCATTER_FORWARD));
    FBI_PETSC(VecGhostUpdateEnd(ghosted_, INSERT_VALUES, SCATTER_FORWARD));
    interpolate(*coupling_, ghosted_, rows_);
    interface_->solve(rows_.data());
    add_spread(rows_, y);
  }
  Write values(y);
  const double scale = continuity_scale();
  for (Index a = 0; a < fluid_.mesh().owned_nodes; ++a) values.get()[4 * static_cast<std::size_t>(a) + 3] *= scale;
}

void FluidSolver::velocity_block(const double* r, double* x) {
  Timed timed("velocity block");
  const std::vector<double>& weight = weight_->values();
  const Index owned = fluid_.mesh().owned_nodes;
  for (Index a = 0; a < owned; ++a)
    for (int i = 0; i < 3; ++i) {
      const std::size_t k = 4 * static_cast<std::size_t>(a) + i;
      x[k] = weight[3 * static_cast<std::size_t>(a) + i] * r[k];
    }
  fluid_.remove_normal(x, owned);
  if (coupling_ == nullptr || coupling_->global_rows() == 0) return;
  {
    Write to(ghosted_);
    for (Index a = 0; a < owned; ++a) {
      for (int i = 0; i < 3; ++i)
        to.get()[4 * static_cast<std::size_t>(a) + i] = x[4 * static_cast<std::size_t>(a) + i];
      to.get()[4 * static_cast<std::size_t>(a) + 3] = 0.0;
    }
  }
  FBI_PETSC(VecGhostUpdateBegin(ghosted_, INSERT_VALUES, SCATTER_FORWARD));
  FBI_PETSC(VecGhostUpdateEnd(ghosted_, INSERT_VALUES, SCATTER_FORWARD));
  interpolate(*coupling_, ghosted_, rows_);
  factor_.solve(rows_.data());
  {
    GhostedForm form(ghosted_);
    FBI_PETSC(VecSet(form.get(), 0.0));
    Write values(form.get());
    coupling_->spread(rows_.data(), values.get(), 1.0);
  }
  FBI_PETSC(VecGhostUpdateBegin(ghosted_, ADD_VALUES, SCATTER_REVERSE));
  FBI_PETSC(VecGhostUpdateEnd(ghosted_, ADD_VALUES, SCATTER_REVERSE));
  Read force(ghosted_);
  for (Index a = 0; a < owned; ++a)
    for (int i = 0; i < 3; ++i) {
      const std::size_t k = 4 * static_cast<std::size_t>(a) + i;
      x[k] -= weight[3 * static_cast<std::size_t>(a) + i] * force.get()[k];
    }
  fluid_.remove_normal(x, owned);
}

void FluidSolver::apply_preconditioner(Vec r, Vec x) {
  Timed timed("preconditioner");
  const Index owned = fluid_.mesh().owned_nodes;
  const double scale = continuity_scale();
  const std::vector<char>& dirichlet = fluid_.is_dirichlet();
  const std::vector<double>&volume = fluid_.lumped_volume(), &mass = pressure_->mass();
  const double scale_of_pressure = pressure_->scale();
  {
    Timed timed_pressure("pressure cycle");
    {
      Read right(r);
      Write to(pressure_right_);
      for (Index a = 0; a < owned; ++a) to.get()[a] = right.get()[4 * static_cast<std::size_t>(a) + 3] / scale;
    }
    pressure_->solver().apply(pressure_right_, pressure_solution_);
    Read right(pressure_right_);
    Read solution(pressure_solution_);
    Write p(x);
    for (Index a = 0; a < owned; ++a) {
      const std::size_t k = 4 * static_cast<std::size_t>(a);
      for (int i = 0; i < 3; ++i) p.get()[k + i] = 0.0;
      p.get()[k + 3] = scale_of_pressure * solution.get()[a] + mass[a] / volume[a] * right.get()[a];
    }
  }
  apply_operator(x, work_);
  {
    Read right(r);
    Write rest(work_);
    for (Index a = 0; a < owned; ++a)
      for (int i = 0; i < 3; ++i) {
        const std::size_t k = 4 * static_cast<std::size_t>(a) + i;
        rest.get()[k] = right.get()[k] - rest.get()[k];
      }
  }
  Read rest(work_), right(r);
  Write u(x);
  velocity_block(rest.get(), u.get());
  for (Index a = 0; a < owned; ++a)
    for (int i = 0; i < 3; ++i) {
      const std::size_t k = 4 * static_cast<std::size_t>(a) + i;
      if (dirichlet[k] != 0) u.get()[k] = right.get()[k];
    }
  fluid_.set_normal(right.get(), u.get(), owned);
}

bool FluidSolver::renew_velocity(bool geometry_changed, bool interface_changed, bool anew) {
  const bool renewed = weight_->renew();
  const bool coupled = coupling_ != nullptr && coupling_->global_rows() > 0;
  is_fast_ = coupled && weight_->strength() > (is_fast_ ? calmer : 1.0) * fast_flow;
  lines_current_ = lines_current_ && !renewed;
  if (lines_rest_ > 0) --lines_rest_;
  if ((uses_lines() || smooths_with_lines()) && !lines_current_) {
    lines_->renew(*weight_);
    lines_current_ = true;
  }
  // A few digits of slow flow are there before tau_C shows.
  const bool demanding = parameters_.precision == Precision::twofold || !fluid_.has_single_precision() ||
                         parameters_.krylov_tolerance < loose_tolerance || weight_->strength() > slow_flow;
  pressure_->renew_mass(*weight_, demanding);
  is_viscous_ = is_viscous();
  if (!coupled) return true;
  // The factor belongs to M: fixed fibers keep theirs for good. It may lag behind S and W, which change less in a step
  // than M does in a few. With lines it preconditions an iteration with the present M, and may lag behind M as well.
  const bool follows = uses_lines() ? geometry_changed && !coupling_->has_fixed_rows()
                                    : geometry_changed || (interface_changed && factor_follows_);
  const bool tired =
      !age_.exact && (age_.lost_steps > most_lost_steps || age_.effort > tired_effort * age_.fresh_effort);
  const bool renew = follows || tired || anew || factor_of_lines_ != uses_lines() || age_.rows != coupling_->rows() ||
                     std::abs(age_.sigma - fluid_.sigma()) > other_sigma * fluid_.sigma();
  age_.exact = age_.exact && !interface_changed && !geometry_changed;
  if (!comm_.any(renew)) return true;
  return renew_factor(uses_lines());
}

/// M^T 1 of all ranks, shape=(local nodes); empty on one rank. Collective.
std::vector<double> FluidSolver::sums_of_columns() const {
  std::vector<double> sums;
  if (comm_.size() == 1) return sums;
  const std::vector<double> ones(3 * static_cast<std::size_t>(coupling_->rows()), 1.0);
  {
    GhostedForm form(ghosted_);
    FBI_PETSC(VecSet(form.get(), 0.0));
    Write values(form.get());
    coupling_->spread(ones.data(), values.get(), 1.0);
  }
  FBI_PETSC(VecGhostUpdateBegin(ghosted_, ADD_VALUES, SCATTER_REVERSE));
  FBI_PETSC(VecGhostUpdateEnd(ghosted_, ADD_VALUES, SCATTER_REVERSE));
  FBI_PETSC(VecGhostUpdateBegin(ghosted_, INSERT_VALUES, SCATTER_FORWARD));
  FBI_PETSC(VecGhostUpdateEnd(ghosted_, INSERT_VALUES, SCATTER_FORWARD));
  GhostedForm form(ghosted_);
  Read values(form.get());
  sums.resize(fluid_.mesh().local_nodes());
  for (std::size_t a = 0; a < sums.size(); ++a) sums[a] = values.get()[4 * a];
  return sums;
}

bool FluidSolver::renew_factor(bool of_lines) {
  Timed timed("multiplier factor");
  count("multiplier factorizations");
  factor_of_lines_ = of_lines;
  linalg::MultiplierRows rows = coupling::complete_rows(
      fluid_.mesh(), *coupling_, of_lines ? lines_->diagonal() : weight_->values(), sums_of_columns());
  std::vector<linalg::InterfaceBlock> blocks;
  for (Index f = 0; f < interface_->fibers(); ++f) {
    if (interface_->is_joined(f)) continue;
    const Index first = interface_->first_row_of(f), count = interface_->first_row_of(f + 1) - first;
    blocks.push_back({first, count, interface_->is_local(f) ? nullptr : interface_->block(f).data(),
                      interface_->law().data() + 9 * static_cast<std::size_t>(first)});
  }
  for (Index g = 0; g < interface_->groups(); ++g)
    if (interface_->joined_block(g).size() > 0)
      blocks.push_back({0, static_cast<Index>(interface_->joined_rows(g).size()), interface_->joined_block(g).data(),
                        nullptr, interface_->joined_rows(g).data()});
  age_ = {coupling_->rows(), fluid_.sigma(), true};
  using Use = linalg::MultiplierFactor::Use;
  const Use use = exact_factor_ ? Use::exact : of_lines ? Use::preconditioner : Use::solves;
  // Sparse factors know the rows of other ranks that their own meet.
  const bool overlaps =
      comm_.size() > 1 && !of_lines && comm_.any(exact_factor_ || !linalg::MultiplierBlocks::suits(rows, blocks));
  const mesh::HexMesh& mesh = fluid_.mesh();
  if (overlaps) factor_.clear();
  const bool done = overlaps
                        ? factor_.factorize(std::make_unique<linalg::RowOverlap>(
                              comm_, rows, blocks, mesh::chunk_begins(comm_, mesh.first_node, mesh.independent_nodes)))
                        : factor_.factorize(std::move(rows), blocks, use);
  const bool failed = comm_.any(!done);
  if (failed) age_.rows = -1;
  return !failed;
}

bool FluidSolver::prepare(bool geometry_changed, bool interface_changed, bool anew) {
  geometry_changed = geometry_changed || anew;
  interface_changed = interface_changed || anew;
  if (direct_ != nullptr) {
    const bool kept = fluid_.is_linear() && factor_sigma_ == fluid_.sigma() && !geometry_changed && !interface_changed;
    factor_sigma_ = fluid_.sigma();
    return kept || direct_->factorize();
  }
  if (reference_ != nullptr) return reference_->prepare(geometry_changed, continuity_scale());
  pressure_->renew();
  if (!renew_velocity(geometry_changed, interface_changed, anew)) return false;
  if (parameters_.precision == Precision::twofold) return true;
  fluid::SingleTangent* tangent = fluid_.single_tangent();
  if (tangent == nullptr) return true;
  if (single_ == nullptr)
    single_ = std::make_unique<SingleSolver>(fluid_, *tangent, coupling_, interface_, single_restart);
  prepare_single();
  return true;
}

void FluidSolver::prepare_single() {
  const bool lines = uses_lines() || smooths_with_lines();
  single_->prepare({&pressure_->solver(), pressure_->scale(), &pressure_->mass(), continuity_scale(),
                    uses_lines() ? nullptr : &weight_->values(), lines ? lines_.get() : nullptr, &factor_});
}

bool FluidSolver::smooths_with_lines() const { return lines_ != nullptr && weight_->strength() > slow_flow; }

bool FluidSolver::is_viscous() const {
  if (coupling_ == nullptr || coupling_->global_rows() == 0 || fluid_.is_steady()) return false;
  const double square = fluid_.parameters().viscosity / (viscous_flow * fluid_.parameters().density * fluid_.sigma());
  const double smallest = fluid_.smallest_cell();
  if (smallest * smallest >= square) return false;
  // Small cells where no fiber is do not count.
  double sums[2] = {0.0, 0.0};
  for (const Index node : coupling_->local_m().node) {
    sums[0] += fluid_.lumped_volume()[node];
    sums[1] += 1.0;
  }
  comm_.sum(sums, 2);
  return std::pow(sums[0] / sums[1], 2.0 / 3.0) < square;
}

linalg::KrylovResult FluidSolver::solve_single(Vec b, Vec x, double tolerance, int maximum, bool impatient) {
  const std::size_t size = 4 * static_cast<std::size_t>(fluid_.mesh().owned_nodes);
  const std::vector<std::size_t>& fixed = fluid_.boundaries().fixed();
  single_right_.resize(size);
  single_solution_.resize(size);
  linalg::KrylovResult result;
  double norm = 0.0;
  FBI_PETSC(VecNorm(b, NORM_2, &norm));
  if (!(norm > 0.0) || !std::isfinite(norm)) {
    FBI_PETSC(VecSet(x, 0.0));
    result.converged = norm == 0.0;
    result.relative_residual = norm;
    return result;
  }
  double residual = norm;
  SingleSolver::Effort effort;
  if (weight_->strength() > slow_flow)
    effort = {many_sweeps, true, is_viscous_};
  else if (tolerance < loose_tolerance)
    effort.sweeps = few_sweeps;
  effort.impatient = impatient;
  for (int round = 0;; ++round) {
    {
      Read right(round == 0 ? b : work_);
      const double scale = 1.0 / residual;
      for (std::size_t k = 0; k < size; ++k) single_right_[k] = static_cast<float>(scale * right.get()[k]);
      for (const std::size_t k : fixed) single_right_[k] = 0.0f;
      single_->remove_normal(single_right_.data(), fluid_.mesh().owned_nodes);
    }
    const double wanted = std::max(tolerance * norm / residual, single_digits);
    const linalg::KrylovResult part =
        single_->solve(single_right_.data(), single_solution_.data(), wanted, maximum - result.iterations, effort);
    result.iterations += part.iterations;
    result.stalled = part.stalled;
    if (!std::isfinite(part.relative_residual)) {
      if (round == 0) FBI_PETSC(VecSet(x, 0.0));
      return result;
    }
    {
      Write to(x);
      const float* solution = single_solution_.data();
      if (round == 0) {
        Read given(b);
        for (std::size_t k = 0; k < size; ++k) to.get()[k] = residual * solution[k];
        for (const std::size_t k : fixed) to.get()[k] = given.get()[k];
        fluid_.set_normal(given.get(), to.get(), fluid_.mesh().owned_nodes);
      } else {
        for (std::size_t k = 0; k < size; ++k) to.get()[k] += residual * solution[k];
      }
    }
    // The iteration around this solve evaluates its residual in double precision: no need to do it here as well.
    if (round == 0 && part.converged && tolerance >= trusted_digits) {
      result.relative_residual = part.relative_residual;
      result.converged = true;
      return result;
    }
    apply_operator(x, work_);
    FBI_PETSC(VecAYPX(work_, -1.0, b));
    const double before = residual;
    FBI_PETSC(VecNorm(work_, NORM_2, &residual));
    result.relative_residual = residual / norm;
    result.converged = residual <= tolerance * norm;
    if (result.converged || result.stalled || !(residual < refined_enough * before) || result.iterations >= maximum)
      return result;
  }
}

linalg::KrylovResult FluidSolver::solve(Vec b, Vec x, double tolerance) {
  Timed timed("linear solve");
  count("linear solves");
  const mesh::HexMesh& mesh = fluid_.mesh();
  if (direct_ != nullptr) {
    linalg::KrylovResult result;
    result.iterations = 1;
    result.converged = direct_->solve(b, x);
    remove_mean_pressure(x);
    return result;
  }
  {
    Read from(b);
    Write to(scaled_);
    const NodeVector<double> scale = {1.0, 1.0, 1.0, continuity_scale()};
    for (std::size_t k = 0; k < 4 * static_cast<std::size_t>(mesh.owned_nodes); k += 4)
      store_node<double>(scale * load_node(from.get() + k), to.get() + k);
  }
  linalg::KrylovResult result;
  if (reference_ != nullptr) {
    result = reference_->solve(scaled_, x, tolerance);
  } else {
    const bool coupled = coupling_ != nullptr && coupling_->global_rows() > 0;
    const bool approximate = coupled && !exact_factor_ && comm_.any(factor_.is_approximate());
    const bool lags = coupled && (!age_.exact || approximate), lines = uses_lines();
    const double effort = approximate || lines ? longest_effort : 2.0 * age_.fresh_effort;
    const int expected = static_cast<int>(effort * -std::log10(std::min(tolerance, 1.0)));
    const int enough = lags || lines ? std::min(parameters_.krylov_iterations, std::max(tired_iterations, expected))
                                     : parameters_.krylov_iterations;
    const bool aged = coupled && !lines && !age_.exact;
    result = iterate(x, tolerance, enough, lags || lines);
    // Where the penalty is large and fibers are stiff, S is another one in every iteration of a step.
    const bool useless = age_.fresh_effort > 0.0 && result.iterations > few_iterations &&
                         age_.effort > useless_effort * age_.fresh_effort;
    if (aged && (!result.converged || useless)) factor_follows_ = true;
    // Inverses of blocks do not suffice where stiff fibers share cells and the penalty is large.
    const bool slow = result.iterations > few_iterations && age_.effort > most_effort;
    if (slow && lines && !age_.exact) {
      age_.rows = -1;  // the next solve has new ones
    } else if (approximate && !aged && (!result.converged || slow)) {
      exact_factor_ = true;
      age_.rows = -1;
      count("multiplier blocks given up");
    }
    const auto again = [&](int maximum) {
      const int before = result.iterations;
      result = iterate(x, tolerance, maximum, false);
      result.iterations += before;
    };
    if (!result.converged && lines) {
      // Nor do a few steps for the multipliers of lines then.
      lines_rest_ = next_rest_;
      next_rest_ = std::min(4 * next_rest_, longest_rest);
      count("velocity lines left out");
      if (!coupled || renew_factor(false)) {
        prepare_single();
        again(parameters_.krylov_iterations);
      }
    } else if (!result.converged && lags && renew_factor(false)) {
      again(parameters_.krylov_iterations);
    }
  }
  remove_mean_pressure(x);
  return result;
}

/// solve_single, again with a new factor where an old one of lines has failed. Notes the steps for the multipliers
/// beyond those of a new factor: they add up to the time of one. Collective.
linalg::KrylovResult FluidSolver::iterate_single(Vec x, double tolerance, int maximum, bool impatient) {
  linalg::KrylovResult result;
  for (;;) {
    single_->reset_multiplier_steps();
    const int before = result.iterations;
    result = solve_single(scaled_, x, tolerance, maximum, impatient);
    result.iterations += before;
    const SingleSolver::MultiplierSteps& steps = single_->multiplier_steps();
    if (factor_of_lines_ && steps.solves > 0) {
      if (age_.fresh_steps == 0.0) age_.fresh_steps = steps.mean();
      age_.lost_steps += std::max(0.0, steps.steps - age_.fresh_steps * steps.solves);
    }
    if (result.converged || !factor_of_lines_ || age_.exact || !renew_factor(true)) return result;
  }
}

/// x = solution for scaled_, by the mixed or the double precision iteration. Collective.
linalg::KrylovResult FluidSolver::iterate(Vec x, double tolerance, int maximum, bool impatient) {
  linalg::KrylovResult result;
  if (single_ != nullptr) result = iterate_single(x, tolerance, maximum, impatient);
  if (!result.converged && !result.stalled && result.iterations < maximum) {
    // Double precision has W.
    if (factor_of_lines_ && !renew_factor(false)) return result;
    const int before = result.iterations;
    result = krylov_->solve(scaled_, x, tolerance, maximum - before);
    result.iterations += before;
  }
  if (result.relative_residual > 0.0 && result.relative_residual < 1.0) {
    age_.effort = result.iterations / -std::log10(result.relative_residual);
    if (age_.exact && age_.fresh_effort == 0.0) age_.fresh_effort = age_.effort;
  }
  return result;
}

}  // namespace fbi::fsi
