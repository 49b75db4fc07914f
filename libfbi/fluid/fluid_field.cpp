#include "fluid/fluid_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/counters.hpp"
#include "base/error.hpp"
#include "base/log.hpp"
#include "base/node_vector.hpp"
#include "base/timer.hpp"
#include "fem/hex8.hpp"
#include "fluid/fluid_field_parts.hpp"

namespace fbi::fluid {

namespace {

bool is_zero(const input::VectorExpression& field) {
  return std::all_of(field.begin(), field.end(), [](const input::Expression& f) { return f.is_zero(); });
}

bool depends_on_time(const input::VectorExpression& field) {
  return std::any_of(field.begin(), field.end(), [](const input::Expression& f) { return f.depends_on_time(); });
}

}  // namespace

FluidField::FluidField(const mesh::HexMesh& mesh, const FluidParameters& parameters,
                       const BoundaryConditions& boundaries, const FluidTimeParameters& time)
    : implementation_(std::make_unique<Implementation>(mesh, parameters, boundaries, time)) {
  implementation_->compute_lumped_volume();
  implementation_->compute_pressure_is_free();
  implementation_->compute_smallest_cell();
}

FluidField::~FluidField() = default;

// ---------------------------------------------------------------------------------------------------- setup

void FluidField::Implementation::compute_lumped_volume() {
  std::vector<double> local(mesh.local_nodes(), 0.0);
  cells.add_lumped_volume(local.data());
  {
    LocalArray w(work);
    for (std::size_t n = 0; n < local.size(); ++n) w[4 * n] = local[n];
  }
  add_ghosts(work);
  update_ghosts(work);
  LocalArray w(work);
  lumped_volume.resize(local.size());
  for (std::size_t n = 0; n < local.size(); ++n) lumped_volume[n] = w[4 * n];
}

// The constant pressure is free when it makes no residual in the rows of free velocities: -int div w = 0.
void FluidField::Implementation::compute_pressure_is_free() {
  std::vector<double> constant(unknowns(), 0.0);
  for (std::size_t k = 3; k < unknowns(); k += 4) constant[k] = 1.0;
  double largest = 0, scale = 0;
  {
    LocalArray s(sum);
    std::fill_n(s.data(), unknowns(), 0.0);
    cells.add_residual(constant.data(), rest.data(), s.data());
    // Before the ghosts are added: in a box that is periodic in all directions everything cancels then.
    for (std::size_t k = 0; k < unknowns(); ++k) scale = std::max(scale, std::abs(s[k]));
  }
  add_ghosts(sum);
  LocalArray s(sum);
  boundaries.remove_normal(s.data(), mesh.owned_nodes);
  for (std::size_t k = 0; k < owned(); ++k) {
    if (k % 4 != 3 && !boundaries.is_dirichlet()[k]) largest = std::max(largest, std::abs(s[k]));
  }
  pressure_is_free = mesh.comm.max(largest) <= 1e-10 * mesh.comm.max(scale);
}

void FluidField::Implementation::compute_smallest_cell() {
  double smallest = 1e300;
  for (double volume : cells.volume()) smallest = std::min(smallest, std::cbrt(volume));
  smallest_cell = mesh.comm.min(smallest);
}

double FluidField::Implementation::largest_speed(Vec u) {
  LocalArray a(u);
  double largest = 0;
  for (std::size_t k = 0; k < owned(); k += 4)
    largest = std::max(largest, a[k] * a[k] + a[k + 1] * a[k + 1] + a[k + 2] * a[k + 2]);
  return std::sqrt(mesh.comm.max(largest));
}

// ---------------------------------------------------------------------------------------------------- step

void FluidField::Implementation::evaluate_body_force(double t) {
  if (is_zero(parameters.body_force)) return;
  if (!body_force.empty() && !depends_on_time(parameters.body_force)) return;
  count_parts("body forces evaluated", mesh.local_nodes());
  body_force.resize(unknowns());
  std::string error;
  for (Index n = 0; n < mesh.local_nodes(); ++n) {
    const double* x = mesh.node(n);
    for (int i = 0; i < 3; ++i) {
      const double b = parameters.body_force[i](x[0], x[1], x[2], t);
      if (!std::isfinite(b))
        error = log::format("the body force is not finite at (%g, %g, %g), t = %g", x[0], x[1], x[2], t);
      body_force[4 * static_cast<std::size_t>(n) + i] = b;
    }
  }
  agree_on_error(mesh.comm, ExitCode::diverged, error);
}

// v' - sigma v of the rate formula, minus b.
void FluidField::Implementation::compute_rest() {
  LocalArray now(accepted), earlier(previous), a(rate);
  const NodeVector<double> zero = {};
  for (std::size_t k = 0; k < unknowns(); k += 4) {
    const NodeVector<double> v = load_node(now.data() + k);
    NodeVector<double> value = formula.before * (load_node(earlier.data() + k) - v) - formula.sigma * v +
                               formula.rate * load_node(a.data() + k);
    if (!body_force.empty()) value -= load_node(&body_force[k]);
    store_node(three_and_one<double>(value, zero), &rest[k]);
  }
}

void FluidField::Implementation::update_tau() {
  single_is_new = false;  // every step begins here
  // Without convection tau depends on the time step alone.
  const bool constant = parameters.convective_form == ConvectiveForm::none;
  if (constant && tau_sigma == formula.sigma && tau_dt == dt) return;
  tau_sigma = formula.sigma;
  tau_dt = dt;
  count("tau updates");
  const double speed = largest_speed(iterate);
  LocalArray u(iterate);
  if (steady()) cells.set_step(0.0, 0.0);  // pseudo-time is no part of the answer
  cells.update_tau(u.data(), speed);
  cells.set_step(formula.sigma, dt);
}

void FluidField::set_linearization(Linearization linearization) {
  Implementation& f = *implementation_;
  f.single_is_new = false;
  f.convection = linearization;
  f.cells.set_frozen(linearization != Linearization::newton);
  f.boundaries.set_frozen(linearization != Linearization::newton);
}

void FluidField::update_tau() { implementation_->update_tau(); }

void FluidField::set_pseudo_time(double sigma) {
  Implementation& f = *implementation_;
  f.single_is_new = false;
  f.formula = {sigma, 0.0, 0.0};
  f.cells.set_step(sigma, 0.0);
  LocalArray u(f.iterate);
  for (std::size_t k = 0; k < f.unknowns(); ++k)
    f.rest[k] = k % 4 == 3 ? 0.0 : -sigma * u[k] - (f.body_force.empty() ? 0.0 : f.body_force[k]);
}

void FluidField::begin_step(double time, double dt) {
  const Timed timed("fluid begin step");
  Implementation& f = *implementation_;
  f.dt = f.steady() ? 0.0 : dt;
  const bool by_bdf2 = f.time_parameters.scheme == TimeScheme::bdf2;
  f.theta = f.steady() || f.startup_left > 0 || by_bdf2 ? 1.0 : f.time_parameters.theta;
  if (f.steady())
    f.formula = {};
  else
    f.formula = by_bdf2 && f.startup_left == 0 ? bdf2(dt, f.previous_dt) : one_step_theta(f.theta, dt);
  f.boundaries.set_time(time);
  f.evaluate_body_force(time);
  f.cells.set_step(f.formula.sigma, f.dt);
  {
    LocalArray u(f.iterate), now(f.accepted), before(f.previous), a(f.linearization);
    // Where a step is solved at what is extrapolated, the second step needs it too, unless v_0 is no part of a smooth
    // flow.
    const double needed = f.convection == Linearization::extrapolated && f.impulsive == 0 ? 1 : 2;
    const double ratio = f.accepted_steps >= needed && !f.steady() ? dt / f.previous_dt : 0.0;
    for (std::size_t k = 0; k < f.unknowns(); ++k) u[k] = now[k] + ratio * (now[k] - before[k]);
    f.boundaries.apply(u.data());
    std::copy_n(u.data(), f.unknowns(), a.data());
  }
  f.compute_rest();
  f.update_tau();
}

void FluidField::accept_step() {
  Implementation& f = *implementation_;
  LocalArray u(f.iterate), now(f.accepted), before(f.previous), a(f.rate);
  if (f.steady()) f.formula = {};
  const RateFormula& formula = f.formula;
  const NodeVector<double> zero = {};
  for (std::size_t k = 0; k < f.unknowns(); k += 4) {
    const NodeVector<double> v = load_node(u.data() + k), old = load_node(now.data() + k);
    const NodeVector<double> rate = formula.sigma * (v - old) + formula.before * (load_node(before.data() + k) - old) +
                                    formula.rate * load_node(a.data() + k);
    store_node(three_and_one<double>(rate, zero), a.data() + k);
    store_node(old, before.data() + k);
    store_node(v, now.data() + k);
  }
  f.previous_dt = f.dt;
  f.accepted_steps += 1;
  if (f.startup_left > 0) f.startup_left -= 1;
}

void FluidField::increment(Vec delta) {
  Implementation& f = *implementation_;
  f.single_is_new = false;
  FBI_PETSC(VecAXPY(f.iterate, 1.0, delta));
  update_ghosts(f.iterate);
  // With the convecting velocity of earlier steps tau is theirs too: the equations stay linear.
  if (f.parameters.tau_update == TauUpdate::iteration && f.convection != Linearization::extrapolated) f.update_tau();
}

// ---------------------------------------------------------------------------------------------------- equations

// With a given convecting velocity a the residual is affine in u: R(a) + dR/du (u - a) with the tangent that leaves the
// derivative of a out. Both have the boundary values of the step.
void FluidField::Implementation::sum_residual(const std::function<void(double*)>& add, bool linearize) {
  {
    const bool affine = convection == Linearization::extrapolated;
    LocalArray u(iterate), a(linearization), w(work), s(sum);
    const double* at = affine ? a.data() : u.data();
    std::fill_n(s.data(), unknowns(), 0.0);
    // What is done must not depend on earlier steps: a restarted run has none.
    single_is_new = linearize && !affine && !cells.is_extended();
    if (single_is_new && single == nullptr) single = std::make_unique<SingleTangent>(mesh, cells, boundaries);
    if (single_is_new)
      single->linearize_with_residual(at, rest.data(), s.data());
    else
      cells.add_residual(at, rest.data(), s.data());
    boundaries.add_residual(at, s.data());
    if (affine) {
      for (std::size_t k = 0; k < unknowns(); ++k) w[k] = u[k] - a[k];
      cells.add_tangent(at, rest.data(), w.data(), s.data());
      boundaries.add_tangent(at, w.data(), s.data());
    }
    if (add) add(s.data());
  }
  add_ghosts(sum);
}

void FluidField::residual(Vec r, const std::function<void(double*)>& add, bool linearize) {
  const Timed timed("fluid residual");
  count("fluid residuals");
  Implementation& f = *implementation_;
  f.sum_residual(add, linearize);
  LocalArray s(f.sum);
  PetscScalar* out = nullptr;
  FBI_PETSC(VecGetArrayWrite(r, &out));
  std::copy_n(s.data(), f.owned(), out);
  for (const std::size_t k : f.boundaries.fixed()) out[k] = 0.0;
  f.boundaries.remove_normal(out, f.mesh.owned_nodes);
  FBI_PETSC(VecRestoreArrayWrite(r, &out));
}

void FluidField::reactions(Vec r) {
  Implementation& f = *implementation_;
  f.sum_residual();
  LocalArray s(f.sum);
  PetscScalar* out = nullptr;
  FBI_PETSC(VecGetArrayWrite(r, &out));
  std::copy_n(s.data(), f.owned(), out);
  FBI_PETSC(VecRestoreArrayWrite(r, &out));
}

void FluidField::internal_forces(Vec r) {
  Implementation& f = *implementation_;
  {
    LocalArray u(f.iterate), s(f.sum);
    std::fill_n(s.data(), f.unknowns(), 0.0);
    f.cells.add_residual(u.data(), f.rest.data(), s.data());
  }
  add_ghosts(f.sum);
  LocalArray s(f.sum), out(r);
  std::copy_n(s.data(), f.owned(), out.data());
}

void FluidField::linearize() {
  Implementation& f = *implementation_;
  if (f.convection == Linearization::extrapolated) return;  // at the convecting velocity of the step
  LocalArray u(f.iterate), v(f.linearization);
  std::copy_n(u.data(), f.unknowns(), v.data());
}

void FluidField::apply_jacobian(Vec x, Vec y) {
  const Timed timed("fluid jacobian");
  count("fluid tangent products");
  Implementation& f = *implementation_;
  const std::vector<char>& fixed = f.boundaries.is_dirichlet();
  const PetscScalar* in = nullptr;
  FBI_PETSC(VecGetArrayRead(x, &in));
  {
    LocalArray w(f.work);
    for (std::size_t k = 0; k < f.owned(); ++k) w[k] = fixed[k] ? 0.0 : in[k];
    f.boundaries.remove_normal(w.data(), f.mesh.owned_nodes);
  }
  update_ghosts(f.work);
  {
    LocalArray u(f.linearization), w(f.work), s(f.sum);
    std::fill_n(s.data(), f.unknowns(), 0.0);
    f.cells.add_tangent(u.data(), f.rest.data(), w.data(), s.data());
    f.boundaries.add_tangent(u.data(), w.data(), s.data());
  }
  add_ghosts(f.sum);
  {
    LocalArray s(f.sum);
    PetscScalar* out = nullptr;
    FBI_PETSC(VecGetArrayWrite(y, &out));
    for (std::size_t k = 0; k < f.owned(); ++k) out[k] = fixed[k] ? in[k] : s[k];
    f.boundaries.set_normal(in, out, f.mesh.owned_nodes);
    FBI_PETSC(VecRestoreArrayWrite(y, &out));
  }
  FBI_PETSC(VecRestoreArrayRead(x, &in));
}

SingleTangent* FluidField::single_tangent() {
  Implementation& f = *implementation_;
  if (f.cells.is_extended()) return nullptr;
  const Timed timed("fluid linearisation");
  if (!f.single) f.single = std::make_unique<SingleTangent>(f.mesh, f.cells, f.boundaries);
  if (!f.single_is_new) {
    LocalArray u(f.linearization);
    f.single->linearize(u.data(), f.rest.data());
  }
  f.single_is_new = false;
  return f.single.get();
}

linalg::MatHandle FluidField::assemble_jacobian() {
  const Timed timed("fluid assembly");
  count("fluid tangents assembled");
  Implementation& f = *implementation_;
  if (!f.jacobian) f.jacobian = std::make_unique<NodeMatrix>(f.mesh, 4);
  NodeMatrix& matrix = *f.jacobian;
  matrix.clear();
  LocalArray u(f.linearization);
  f.cells.visit_tangents(u.data(), f.rest.data(), [&](Index cell, const Operator::ElementMatrix& m) {
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b)
        for (int i = 0; i < 4; ++i)
          for (int j = 0; j < 4; ++j) matrix.entry(cell, a, b, i, j) += m[4 * a + i][4 * b + j];
  });
  f.boundaries.visit_tangents(u.data(),
                              [&](Index cell, const Boundaries::Corners& corners, const Boundaries::FaceMatrix& m) {
                                for (int a = 0; a < 4; ++a)
                                  for (int b = 0; b < 4; ++b)
                                    for (int i = 0; i < 3; ++i)
                                      for (int j = 0; j < 3; ++j)
                                        matrix.entry(cell, corners[a], corners[b], i, j) += m[3 * a + i][3 * b + j];
                              });
  matrix.set_normals(f.boundaries.constraints());
  matrix.set_dirichlet(f.boundaries.is_dirichlet());
  return matrix.finish();
}

linalg::MatHandle FluidField::pressure_laplacian(const std::vector<double>& coefficient, double robin) const {
  const Implementation& f = *implementation_;
  NodeMatrix matrix(f.mesh, 1);
  f.cells.visit_laplacians([&](Index cell, const Operator::ScalarMatrix& m) {
    for (int a = 0; a < 8; ++a)
      for (int b = 0; b < 8; ++b) matrix.entry(cell, a, b, 0, 0) += coefficient[cell] * m[a][b];
  });
  f.boundaries.visit_open_faces(
      [&](Index cell, const Boundaries::Corners& corners, const Boundaries::FaceMass& m, double area) {
        const double h = f.cells.volume()[cell] / area;
        for (int a = 0; a < 4; ++a)
          for (int b = 0; b < 4; ++b)
            matrix.entry(cell, corners[a], corners[b], 0, 0) += robin * coefficient[cell] * m[a][b] / h;
      });
  return matrix.finish();
}

std::array<std::array<bool, 2>, 3> FluidField::open_sides() const {
  const Implementation& f = *implementation_;
  std::array<std::array<bool, 2>, 3> sides{};
  if (!f.mesh.box) return sides;
  int mine = 0, all = 0;
  f.boundaries.visit_open_faces([&](Index, const Boundaries::Corners& corners, const Boundaries::FaceMass&, double) {
    for (std::size_t side = 0; side < fem::hex8_faces.size(); ++side)
      if (corners == fem::hex8_faces[side]) mine |= 1 << side;
  });
  MPI_Allreduce(&mine, &all, 1, MPI_INT, MPI_BOR, f.mesh.comm.get());
  for (int side = 0; side < 6; ++side) sides[side / 2][side % 2] = ((all >> side) & 1) != 0;
  return sides;
}

// ---------------------------------------------------------------------------------------------------- access

const mesh::HexMesh& FluidField::mesh() const { return implementation_->mesh; }
const FluidParameters& FluidField::parameters() const { return implementation_->parameters; }
linalg::VecHandle FluidField::create_vector() const { return create_ghosted(implementation_->mesh); }
double FluidField::sigma() const { return implementation_->formula.sigma; }
RateFormula FluidField::rate_formula() const { return implementation_->formula; }
bool FluidField::is_linear() const {
  const Implementation& f = *implementation_;
  return f.parameters.convective_form == ConvectiveForm::none && !f.boundaries.has_backflow();
}
bool FluidField::has_single_precision() const { return !implementation_->cells.is_extended(); }
bool FluidField::is_steady() const { return implementation_->steady(); }
bool FluidField::is_second_order() const {
  const FluidTimeParameters& time = implementation_->time_parameters;
  return time.scheme == TimeScheme::bdf2 || (time.scheme == TimeScheme::one_step_theta && time.theta < 0.6);
}
double FluidField::theta() const { return implementation_->theta; }
Vec FluidField::iterate() { return implementation_->iterate; }
Vec FluidField::accepted() { return implementation_->accepted; }
const Boundaries& FluidField::boundaries() const { return implementation_->boundaries; }
bool FluidField::has_normal_constraints() const { return !implementation_->boundaries.constraints().empty(); }
Mat3 FluidField::free_directions(Index node) const {
  const std::vector<NormalConstraint>& constraints = implementation_->boundaries.constraints();
  const auto found = std::lower_bound(constraints.begin(), constraints.end(), node,
                                      [](const NormalConstraint& c, Index n) { return c.node < n; });
  Mat3 free = Mat3::Identity();
  if (found != constraints.end() && found->node == node)
    for (const Vec3& d : found->direction) free -= d * d.transpose();
  return free;
}
void FluidField::remove_normal(double* values, Index nodes) const {
  implementation_->boundaries.remove_normal(values, nodes);
}
void FluidField::set_normal(const double* from, double* to, Index nodes) const {
  implementation_->boundaries.set_normal(from, to, nodes);
}
const std::vector<char>& FluidField::is_dirichlet() const { return implementation_->boundaries.is_dirichlet(); }
bool FluidField::pressure_is_free() const { return implementation_->pressure_is_free; }
std::array<double, 3> FluidField::boundary_flow() const {
  std::array<double, 3> flow = implementation_->boundaries.flow(LocalArray(implementation_->iterate).data());
  implementation_->mesh.comm.sum(flow.data(), 3);
  return flow;
}
const std::vector<double>& FluidField::lumped_volume() const { return implementation_->lumped_volume; }
const std::vector<double>& FluidField::tau_m() const { return implementation_->cells.tau_pressure(); }
double FluidField::tau_streamline(Index cell) const { return implementation_->cells.tau_convection(cell); }
double FluidField::tau_c(Index cell) const { return implementation_->cells.tau_divergence(cell); }
double FluidField::cell_volume(Index cell) const { return implementation_->cells.volume()[cell]; }
double FluidField::pressure_projection(Index cell) const { return implementation_->cells.projection(cell); }
double FluidField::smallest_cell() const { return implementation_->smallest_cell; }

double FluidField::relative_rate() {
  const Implementation& f = *implementation_;
  LocalArray now(f.accepted), before(f.previous);
  double sums[2] = {0.0, 0.0};
  for (std::size_t k = 0; k < f.owned(); ++k) {
    if (k % 4 == 3) continue;
    const double volume = f.lumped_volume[k / 4], change = now[k] - before[k];
    sums[0] += volume * change * change;
    sums[1] += volume * now[k] * now[k];
  }
  f.mesh.comm.sum(sums, 2);
  return sums[1] > 0 ? std::sqrt(sums[0] / sums[1]) / f.previous_dt : std::numeric_limits<double>::infinity();
}

double FluidField::kinetic_energy() {
  Implementation& f = *implementation_;
  LocalArray u(f.iterate);
  return 0.5 * f.parameters.density * f.mesh.comm.sum(f.cells.velocity_squared(u.data()));
}

double FluidField::cfl() {
  Implementation& f = *implementation_;
  LocalArray u(f.iterate);
  return f.dt * f.mesh.comm.max(f.cells.largest_rate(u.data()));
}

double FluidField::max_velocity() { return implementation_->largest_speed(implementation_->iterate); }

Vec3 FluidField::momentum(Vec u) {
  const Implementation& f = *implementation_;
  const PetscScalar* array = nullptr;
  FBI_PETSC(VecGetArrayRead(u, &array));
  Vec3 total = Vec3::Zero();
  for (std::size_t n = 0; n < static_cast<std::size_t>(f.mesh.owned_nodes); ++n)
    for (int i = 0; i < 3; ++i) total[i] += f.parameters.density * f.lumped_volume[n] * array[4 * n + i];
  FBI_PETSC(VecRestoreArrayRead(u, &array));
  f.mesh.comm.sum(total.data(), 3);
  return total;
}

std::vector<std::pair<std::string, Vec>> FluidField::state() {
  const Implementation& f = *implementation_;
  if (f.steady()) return {{"velocity_pressure", f.accepted}};  // no step follows
  return {{"velocity_pressure", f.accepted}, {"velocity_pressure_before", f.previous}, {"acceleration", f.rate}};
}

std::vector<std::pair<std::string, double*>> FluidField::scalars() {
  Implementation& f = *implementation_;
  return {{"dt_before", &f.previous_dt},
          {"accepted_steps", &f.accepted_steps},
          {"startup_steps_left", &f.startup_left},
          {"impulsive", &f.impulsive}};
}

void FluidField::state_restored() {
  Implementation& f = *implementation_;
  update_ghosts(f.accepted);
  update_ghosts(f.previous);
  update_ghosts(f.rate);
  std::copy_n(LocalArray(f.accepted).data(), f.unknowns(), LocalArray(f.iterate).data());
}

}  // namespace fbi::fluid
