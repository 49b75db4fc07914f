#include "beam/beam_field.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/error.hpp"
#include "base/log.hpp"
#include "beam/band_lu.hpp"
#include "beam/end_conditions.hpp"
#include "beam/formulation.hpp"
#include "beam/generalized_alpha.hpp"
#include "beam/loads.hpp"

namespace fbi::beam {
namespace {

using Field = std::vector<double>;
using ElementMatrix = Eigen::Matrix<double, element_dofs, element_dofs, Eigen::RowMajor>;
using ElementVector = Eigen::Matrix<double, element_dofs, 1>;

// Everything about one fiber that does not change.
struct Fiber {
  const ElementFormulation* formulation = nullptr;
  ElementProperties section;  // length is filled in for each element
  NodeConstraint start, end;
  Index first_node = 0, nodes = 0, first_element = 0;
  std::size_t band = 0;  // where its matrix starts

  std::size_t first_dof() const { return 6 * static_cast<std::size_t>(first_node); }
  Index dofs() const { return 6 * nodes; }
  void project(double* x) const {
    start.project(x);
    end.project(x + 6 * static_cast<std::size_t>(nodes - 1));
  }
};

// Weights of one time level: G = M (inertia part) + internal (F - F_ext)_{n+1} + previous (F - F_ext)_n.
struct Level {
  bool dynamic = false;
  double dt = 0.0;
  double internal = 1.0, previous = 0.0;
  double inertia = 0.0;  // d a_level/d d_{n+1} [1/time^2]
};

constexpr double epsilon = std::numeric_limits<double>::epsilon();
// Newton corrections that turn a tangent by more than this (radians, or stretch) are shortened: far from the solution
// the linearised rotation of a slender fiber is a stretch, and stiff.
constexpr double largest_tangent_change = 1.0;

ElementProperties element_properties(const FiberParameters& group) {
  ElementProperties element;
  element.axial_stiffness = group.material.young * group.section.area;
  element.bending_stiffness = group.material.young * group.section.inertia;
  element.mass_per_length = group.material.density * group.section.area;
  return element;
}

// Fills area and second moment of area of circular sections.
std::vector<FiberParameters> with_sections(std::vector<FiberParameters> groups) {
  for (FiberParameters& group : groups) {
    Section& section = group.section;
    const double square = section.radius * section.radius;
    if (section.area == 0.0) section.area = M_PI * square;
    if (section.inertia == 0.0) section.inertia = 0.25 * M_PI * square * square;
  }
  return groups;
}

// Largest entry of nodal forces, shape=(nodes,6); the generalised forces of the tangents count as forces on the arm
// `length`.
double largest_force(const double* x, std::size_t size, double length) {
  double norm = 0.0;
  for (std::size_t i = 0; i < size; ++i) norm = std::fmax(norm, std::abs(x[i]) / (i % 6 < 3 ? 1.0 : length));
  return norm;
}

// Largest entry of nodal displacements; changes of tangents count as displacements at the distance `length`.
double largest_length(const double* x, std::size_t size, double length) {
  double norm = 0.0;
  for (std::size_t i = 0; i < size; ++i) norm = std::fmax(norm, std::abs(x[i]) * (i % 6 < 3 ? 1.0 : length));
  return norm;
}

// Text of the first fiber whose reference is not straight, or empty.
std::string check_straight(const mesh::FiberMesh& fibers, const std::vector<FiberParameters>& groups) {
  for (Index f = 0; f < fibers.fibers(); ++f) {
    if (groups[fibers.group[f]].formulation != Formulation::torsion_free) continue;
    for (Index node = fibers.first_node[f]; node + 1 < fibers.first_node[f + 1]; ++node) {
      const Vec3 x1(&fibers.position[3 * static_cast<std::size_t>(node)]);
      const Vec3 x2(&fibers.position[3 * static_cast<std::size_t>(node + 1)]);
      const Vec3 g1(&fibers.tangent[3 * static_cast<std::size_t>(node)]);
      const Vec3 g2(&fibers.tangent[3 * static_cast<std::size_t>(node + 1)]);
      const double length = fibers.element_length[node - f];
      if ((x2 - x1 - length * g1).norm() > 1e-6 * length || (g2 - g1).norm() > 1e-6)
        return log::format(
            "fiber \"%s\" is curved between its nodes %d and %d: the formulation torsion_free needs "
            "initially straight fibers",
            fibers.name[f].c_str(), node - fibers.first_node[f], node - fibers.first_node[f] + 1);
    }
  }
  return {};
}

}  // namespace

struct BeamField::Implementation {
  mesh::FiberMesh mesh;
  std::vector<FiberParameters> groups;
  BeamTimeParameters parameters;
  GeneralizedAlpha scheme;
  Loads loads;
  std::vector<Fiber> fibers;
  Index moving = 0;

  // state at t_n
  Field dofs_n, velocity_n, acceleration_n, internal_n, external_n, work_n;
  // iterate at t_{n+1}
  Field dofs, velocity, acceleration, internal, external;
  Field residual, full;  // G_b with and without the projection of the supports
  LoadValues load_values;
  Level level;
  bool evaluated = false;                // residual, internal and external belong to the iterate
  std::vector<double> scale, round_off;  // of each fiber: largest single force, level of round-off in the residual
  Field band;
  std::vector<Index> pivot;
  std::vector<char> singular;

  Implementation(const mesh::FiberMesh& fiber_mesh, const std::vector<FiberParameters>& fiber_groups,
                 const BeamTimeParameters& time, const Vec3& gravity);

  const double* element_length(const Fiber& fiber) const { return &mesh.element_length[fiber.first_element]; }
  void evaluate(Index f, bool with_tangent);
  void evaluate_all(bool with_tangent);
  void assemble_element(const Fiber& fiber, Index e, ElementMatrix& matrix);
  bool factorize(Index f);
  void solve(const Fiber& fiber, bool is_singular, double* b, Index columns) const;
  void update_rates(const Fiber& fiber);
  void add_increment(const Fiber& fiber, const double* delta, double factor);
  void predict(Index f);
  int newton(Index f, const Field& force);
};

BeamField::Implementation::Implementation(const mesh::FiberMesh& fiber_mesh,
                                          const std::vector<FiberParameters>& fiber_groups,
                                          const BeamTimeParameters& time, const Vec3& gravity)
    : mesh(fiber_mesh),
      groups(with_sections(fiber_groups)),
      parameters(time),
      scheme(time.rho_inf),
      loads(mesh, groups, gravity),
      fibers(mesh.fibers()) {
  std::size_t band_total = 0;
  for (Index f = 0; f < mesh.fibers(); ++f) {
    const FiberParameters& group = groups[mesh.group[f]];
    Fiber& fiber = fibers[f];
    fiber.formulation = element_formulation(group.formulation);
    fiber.section = element_properties(group);
    fiber.first_node = mesh.first_node[f];
    fiber.nodes = mesh.first_node[f + 1] - mesh.first_node[f];
    fiber.first_element = mesh.first_element(f);
    fiber.band = band_total;
    if (fiber.formulation == nullptr) continue;
    ++moving;
    band_total += band_size(fiber.dofs());
    const auto tangent = [this](Index node) { return Vec3(&mesh.tangent[3 * static_cast<std::size_t>(node)]); };
    fiber.start = NodeConstraint(group.start, tangent(fiber.first_node));
    fiber.end = NodeConstraint(group.end, tangent(fiber.first_node + fiber.nodes - 1));
  }
  const std::size_t size = 6 * static_cast<std::size_t>(mesh.nodes());
  for (Field* field : {&velocity_n, &acceleration_n, &internal_n, &external_n, &work_n, &velocity, &acceleration,
                       &internal, &external, &residual, &full})
    field->assign(size, 0.0);
  dofs_n.resize(size);
  for (std::size_t node = 0; node < size / 6; ++node)
    for (std::size_t k = 0; k < 3; ++k) {
      dofs_n[6 * node + k] = mesh.position[3 * node + k];
      dofs_n[6 * node + 3 + k] = mesh.tangent[3 * node + k];
    }
  dofs = dofs_n;
  scale.assign(fibers.size(), 0.0);
  round_off.assign(fibers.size(), 0.0);
  singular.assign(fibers.size(), 0);
  pivot.assign(size, 0);
  band.assign(band_total, 0.0);
  loads.evaluate(0.0, parameters.scheme == TimeScheme::static_ ? 0.0 : 1.0, load_values);
}

// Internal, inertial and external forces of one fiber, G_b = residual (supports projected out), K_b in the band on
// request.
void BeamField::Implementation::evaluate(Index f, bool with_tangent) {
  const Fiber& fiber = fibers[f];
  const std::size_t first = fiber.first_dof(), size = static_cast<std::size_t>(fiber.dofs());
  std::fill_n(&internal[first], size, 0.0);
  std::fill_n(&full[first], size, 0.0);
  double* matrix = &band[fiber.band];
  if (with_tangent) std::fill_n(matrix, band_size(fiber.dofs()), 0.0);

  double largest = 0.0, shortest = std::numeric_limits<double>::max();
  const auto enlarge = [&largest](const double* force, double length) {
    for (int k = 0; k < 6; ++k) largest = std::fmax(largest, std::abs(force[k]) / (k < 3 ? 1.0 : length));
  };
  ElementProperties element = fiber.section;
  ElementVector force, rate;
  ElementMatrix tangent, mass;
  for (Index e = 0; e + 1 < fiber.nodes; ++e) {
    element.length = element_length(fiber)[e];
    shortest = std::min(shortest, element.length);
    const std::size_t dof = first + 6 * static_cast<std::size_t>(e);
    fiber.formulation->internal_force(element, &dofs[dof], force.data(), with_tangent ? tangent.data() : nullptr);
    for (int i = 0; i < element_dofs; ++i) {
      internal[dof + i] += force[i];
      full[dof + i] += level.internal * force[i];
    }
    enlarge(force.data(), element.length);
    enlarge(force.data() + 6, element.length);
    if (with_tangent) tangent *= level.internal;
    if (level.dynamic) {
      fiber.formulation->mass(element, mass.data());
      for (int i = 0; i < element_dofs; ++i)
        rate[i] = (1 - scheme.alpha_m) * acceleration[dof + i] + scheme.alpha_m * acceleration_n[dof + i];
      force.noalias() = mass * rate;
      for (int i = 0; i < element_dofs; ++i) full[dof + i] += force[i];
      enlarge(force.data(), element.length);
      enlarge(force.data() + 6, element.length);
      if (with_tangent) tangent += level.inertia * mass;
    }
    if (with_tangent) assemble_element(fiber, e, tangent);
  }

  std::copy_n(&load_values.dead[first], size, &external[first]);
  for (int end = 0; end < 2; ++end) {
    const std::size_t dof = first + (end == 0 ? 0 : size - 6) + 3;
    const Vec3& moment = load_values.moment[f][end];
    if (moment.squaredNorm() == 0.0) continue;
    const Vec3 follower = moment_force(moment, Vec3(&dofs[dof]));
    for (int k = 0; k < 3; ++k) external[dof + k] += follower[k];
  }
  double coordinate = 0.0;
  for (std::size_t i = 0; i < size; i += 6) {
    enlarge(&external[first + i], shortest);
    for (int k = 0; k < 3; ++k) coordinate = std::fmax(coordinate, std::abs(dofs[first + i + k]));
  }
  for (std::size_t i = first; i < first + size; ++i) {
    full[i] += level.previous * (internal_n[i] - external_n[i]) - level.internal * external[i];
    residual[i] = full[i];
  }
  fiber.project(&residual[first]);
  scale[f] = largest;
  const double stiffness = fiber.section.axial_stiffness + fiber.section.bending_stiffness / (shortest * shortest);
  round_off[f] =
      4 * epsilon *
      (stiffness * (1 + coordinate / shortest) + level.inertia * fiber.section.mass_per_length * shortest * coordinate);
}

// Adds the tangents of end moments, projects the supports out and adds the element matrix to the band.
void BeamField::Implementation::assemble_element(const Fiber& fiber, Index e, ElementMatrix& matrix) {
  const Index f = static_cast<Index>(&fiber - fibers.data());
  const bool at_end[2] = {e == 0, e + 2 == fiber.nodes};
  for (int end = 0; end < 2; ++end) {
    if (!at_end[end]) continue;
    const Vec3& moment = load_values.moment[f][end];
    const std::size_t dof = fiber.first_dof() + 6 * static_cast<std::size_t>(e + end) + 3;
    if (moment.squaredNorm() > 0.0)
      matrix.block<3, 3>(6 * end + 3, 6 * end + 3) -= level.internal * moment_force_tangent(moment, Vec3(&dofs[dof]));
  }
  const NodeConstraint* constraint[2] = {&fiber.start, &fiber.end};
  double position_scale = 0.0, tangent_scale = 0.0;
  for (int k = 0; k < 3; ++k) {
    position_scale = std::fmax(position_scale, std::fmax(std::abs(matrix(k, k)), std::abs(matrix(6 + k, 6 + k))));
    tangent_scale = std::fmax(tangent_scale, std::fmax(std::abs(matrix(3 + k, 3 + k)), std::abs(matrix(9 + k, 9 + k))));
  }
  for (int end = 0; end < 2; ++end)
    if (at_end[end]) constraint[end]->project_element(matrix.data(), end);
  for (int end = 0; end < 2; ++end)
    if (at_end[end]) constraint[end]->fill_element(matrix.data(), end, position_scale, tangent_scale);
  double* target = &band[fiber.band];
  for (Index i = 0; i < element_dofs; ++i) {
    double* row = target + band_entry(6 * e + i, 6 * e);
    for (Index j = 0; j < element_dofs; ++j) row[j] += matrix(i, j);
  }
}

void BeamField::Implementation::evaluate_all(bool with_tangent) {
  for (Index f = 0; f < mesh.fibers(); ++f)
    if (fibers[f].formulation != nullptr) evaluate(f, with_tangent);
  evaluated = true;
}

bool BeamField::Implementation::factorize(Index f) {
  const Fiber& fiber = fibers[f];
  singular[f] = !band_factorize(&band[fiber.band], &pivot[fiber.first_dof()], fiber.dofs());
  return !singular[f];
}

void BeamField::Implementation::solve(const Fiber& fiber, bool is_singular, double* b, Index columns) const {
  if (is_singular) {
    std::fill_n(b, static_cast<std::size_t>(fiber.dofs()) * columns, std::numeric_limits<double>::quiet_NaN());
    return;
  }
  band_solve(&band[fiber.band], &pivot[fiber.first_dof()], fiber.dofs(), b, columns);
}

void BeamField::Implementation::update_rates(const Fiber& fiber) {
  if (!level.dynamic) return;
  const std::size_t first = fiber.first_dof();
  for (std::size_t i = first; i < first + static_cast<std::size_t>(fiber.dofs()); ++i) {
    const double change = dofs[i] - dofs_n[i];
    velocity[i] = scheme.velocity(change, velocity_n[i], acceleration_n[i], level.dt);
    acceleration[i] = scheme.acceleration(change, velocity_n[i], acceleration_n[i], level.dt);
  }
}

void BeamField::Implementation::add_increment(const Fiber& fiber, const double* delta, double factor) {
  const std::size_t first = fiber.first_dof(), size = static_cast<std::size_t>(fiber.dofs());
  double ends[2][6];
  std::copy_n(delta, 6, ends[0]);
  std::copy_n(delta + size - 6, 6, ends[1]);
  fiber.start.project(ends[0]);
  fiber.end.project(ends[1]);
  for (std::size_t i = 0; i < size; ++i) {
    const double change = i < 6 ? ends[0][i] : i >= size - 6 ? ends[1][i - (size - 6)] : delta[i];
    dofs[first + i] += factor * change;
  }
  update_rates(fiber);
}

// Iterate d_n + dt v_n, or d_n where that gives the smaller residual: moving on is better for the slow motion, standing
// still for stiff modes (omega dt > 1) that the loads have set ringing. dt^2/2 a_n would multiply those by (omega
// dt)^2.
void BeamField::Implementation::predict(Index f) {
  const Fiber& fiber = fibers[f];
  const std::size_t first = fiber.first_dof(), size = static_cast<std::size_t>(fiber.dofs());
  const double length = *std::min_element(element_length(fiber), element_length(fiber) + fiber.nodes - 1);
  const auto largest_residual = [&] {
    update_rates(fiber);
    evaluate(f, false);
    return largest_force(&residual[first], size, length);
  };
  const double standing = largest_residual();
  for (std::size_t i = first; i < first + size; ++i) dofs[i] += level.dt * velocity_n[i];
  if (std::isless(largest_residual(), standing)) return;
  std::copy_n(&dofs_n[first], size, &dofs[first]);
  update_rates(fiber);
}

int BeamField::Implementation::newton(Index f, const Field& force) {
  const Fiber& fiber = fibers[f];
  const std::size_t first = fiber.first_dof(), size = static_cast<std::size_t>(fiber.dofs());
  const double length = *std::min_element(element_length(fiber), element_length(fiber) + fiber.nodes - 1);
  std::vector<double> delta(size), change(size);
  double applied = 0.0;
  if (!force.empty()) applied = largest_force(&force[first], size, length);
  for (int iteration = 0; iteration < parameters.max_iterations; ++iteration) {
    evaluate(f, true);
    bool finite = true;
    for (std::size_t i = 0; i < size; ++i) {
      delta[i] = (force.empty() ? 0.0 : force[first + i]) - full[first + i];
      finite = finite && std::isfinite(delta[i]);
    }
    if (!finite) return -1;
    fiber.project(delta.data());
    if (largest_force(delta.data(), size, length) <=
        std::max(parameters.tolerance * std::max(scale[f], applied), round_off[f]))
      return iteration;
    if (!factorize(f)) return -1;
    solve(fiber, false, delta.data(), 1);
    double turn = 0.0;
    for (std::size_t i = 0; i < size; ++i) {
      if (!std::isfinite(delta[i])) return -1;
      if (i % 6 >= 3) turn = std::fmax(turn, std::abs(delta[i]));
    }
    const double factor = turn > largest_tangent_change ? largest_tangent_change / turn : 1.0;
    add_increment(fiber, delta.data(), factor);
    for (std::size_t i = 0; i < size; ++i) change[i] = dofs[first + i] - dofs_n[first + i];
    if (factor == 1.0 && largest_length(delta.data(), size, length) <=
                             parameters.tolerance * largest_length(change.data(), size, length))
      return iteration + 1;
  }
  return -1;
}

BeamField::BeamField(const mesh::FiberMesh& fibers, const std::vector<FiberParameters>& groups,
                     const BeamTimeParameters& time, const Vec3& gravity) {
  agree_on_error(fibers.comm, ExitCode::geometry, check_straight(fibers, groups));
  implementation_ = std::make_unique<Implementation>(fibers, groups, time, gravity);
}

BeamField::~BeamField() = default;

bool BeamField::is_fixed(Index fiber) const { return implementation_->fibers[fiber].formulation == nullptr; }
Index BeamField::moving_fibers() const { return implementation_->moving; }

void BeamField::initialize(const std::vector<double>& force) {
  Implementation& b = *implementation_;
  if (b.parameters.scheme == TimeScheme::static_) return;
  b.level = Level();
  for (Index f = 0; f < b.mesh.fibers(); ++f) {
    const Fiber& fiber = b.fibers[f];
    if (fiber.formulation == nullptr) continue;
    b.evaluate(f, false);
    const std::size_t first = fiber.first_dof(), size = static_cast<std::size_t>(fiber.dofs());
    std::fill_n(&b.band[fiber.band], band_size(fiber.dofs()), 0.0);
    b.level.internal = 0.0;  // the mass alone, without the tangent of end moments
    ElementMatrix mass;
    ElementProperties element = fiber.section;
    for (Index e = 0; e + 1 < fiber.nodes; ++e) {
      element.length = b.element_length(fiber)[e];
      fiber.formulation->mass(element, mass.data());
      b.assemble_element(fiber, e, mass);
    }
    b.level.internal = 1.0;
    for (std::size_t i = first; i < first + size; ++i)
      b.acceleration_n[i] = (force.empty() ? 0.0 : force[i]) - b.full[i];
    fiber.project(&b.acceleration_n[first]);
    b.solve(fiber, !b.factorize(f), &b.acceleration_n[first], 1);
    fiber.project(&b.acceleration_n[first]);
    std::copy_n(&b.internal[first], size, &b.internal_n[first]);
    std::copy_n(&b.external[first], size, &b.external_n[first]);
  }
  b.acceleration = b.acceleration_n;
}

void BeamField::begin_step(double time, double dt) {
  Implementation& b = *implementation_;
  b.level = Level();
  b.evaluated = false;
  b.dofs = b.dofs_n;
  b.velocity = b.velocity_n;
  b.acceleration = b.acceleration_n;
  const bool dynamic = b.parameters.scheme == TimeScheme::generalized_alpha;
  b.loads.evaluate(time, dynamic ? 1.0 : time, b.load_values);
  if (!dynamic) return;
  b.level.dynamic = true;
  b.level.dt = dt;
  b.level.internal = 1 - b.scheme.alpha_f;
  b.level.previous = b.scheme.alpha_f;
  b.level.inertia = b.scheme.inertia_per_displacement(dt);
  for (Index f = 0; f < b.mesh.fibers(); ++f)
    if (!is_fixed(f)) b.predict(f);
}

double BeamField::velocity_per_displacement() const {
  const Implementation& b = *implementation_;
  return b.level.dynamic ? b.scheme.velocity_per_displacement(b.level.dt) : 0.0;
}

double BeamField::alpha_f() const {
  const Implementation& b = *implementation_;
  return b.parameters.scheme == TimeScheme::static_ ? 0.0 : b.scheme.alpha_f;
}

void BeamField::linearize() {
  Implementation& b = *implementation_;
  b.evaluate_all(true);
  for (Index f = 0; f < b.mesh.fibers(); ++f)
    if (!is_fixed(f)) b.factorize(f);
}

const std::vector<double>& BeamField::residual() const { return implementation_->residual; }

double BeamField::force_scale() const {
  double largest = 0.0;
  for (const double scale : implementation_->scale) largest = std::fmax(largest, scale);
  return largest;
}

void BeamField::solve(Index fiber, double* b) const {
  const Fiber& f = implementation_->fibers[fiber];
  if (f.formulation == nullptr) {
    std::fill_n(b, f.dofs(), 0.0);
    return;
  }
  f.project(b);
  implementation_->solve(f, implementation_->singular[fiber], b, 1);
  f.project(b);
}

void BeamField::remove_constrained(std::vector<double>& force) const {
  for (const Fiber& fiber : implementation_->fibers) {
    if (fiber.formulation != nullptr)
      fiber.project(&force[fiber.first_dof()]);
    else
      std::fill_n(force.begin() + static_cast<std::ptrdiff_t>(fiber.first_dof()), fiber.dofs(), 0.0);
  }
}

void BeamField::compliance(Index fiber, const double* d, Index rows, RowMatrix& block) const {
  const Fiber& f = implementation_->fibers[fiber];
  block.setZero(3 * rows, 3 * rows);
  if (f.formulation == nullptr) return;
  const Index functions = 2 * f.nodes, columns = 3 * rows;
  RowMatrix x = RowMatrix::Zero(f.dofs(), columns);
  for (Index r = 0; r < rows; ++r)
    for (Index i = 0; i < functions; ++i)
      for (Index k = 0; k < 3; ++k) x(3 * i + k, 3 * r + k) = d[static_cast<std::size_t>(r) * functions + i];
  const auto project_columns = [&f, &x, columns] {
    for (const Index node : {Index(0), static_cast<Index>(f.nodes - 1)}) {
      const NodeConstraint& constraint = node == 0 ? f.start : f.end;
      if (!constraint.active()) continue;
      for (Index c = 0; c < columns; ++c) {
        Eigen::Matrix<double, 6, 1> column = x.block<6, 1>(6 * node, c);
        constraint.project(column.data());
        x.block<6, 1>(6 * node, c) = column;
      }
    }
  };
  project_columns();
  implementation_->solve(f, implementation_->singular[fiber], x.data(), columns);
  project_columns();
  for (Index r = 0; r < rows; ++r)
    for (Index i = 0; i < functions; ++i) {
      const double weight = d[static_cast<std::size_t>(r) * functions + i];
      if (weight != 0.0) block.middleRows(3 * r, 3) += weight * x.middleRows(3 * i, 3);
    }
}

void BeamField::increment(const std::vector<double>& delta) {
  Implementation& b = *implementation_;
  b.evaluated = false;
  for (const Fiber& fiber : b.fibers)
    if (fiber.formulation != nullptr) b.add_increment(fiber, &delta[fiber.first_dof()], 1.0);
}

int BeamField::solve_step(const std::vector<double>& force) {
  Implementation& b = *implementation_;
  b.evaluated = false;
  int most = 0;
  bool failed = false;
  for (Index f = 0; f < b.mesh.fibers(); ++f) {
    if (is_fixed(f)) continue;
    int iterations = b.newton(f, force);
    if (iterations < 0 && b.level.dynamic) {  // a poor predictor: once more from d_n
      const std::size_t first = b.fibers[f].first_dof();
      std::copy_n(&b.dofs_n[first], b.fibers[f].dofs(), &b.dofs[first]);
      b.update_rates(b.fibers[f]);
      iterations = b.newton(f, force);
    }
    failed = failed || iterations < 0;
    most = std::max(most, iterations);
  }
  const GlobalIndex all = b.mesh.comm.max(static_cast<GlobalIndex>(failed ? -1 : most));
  return b.mesh.comm.any(failed) ? -1 : static_cast<int>(all);
}

void BeamField::accept_step() {
  Implementation& b = *implementation_;
  if (!b.evaluated) b.evaluate_all(false);
  for (const Fiber& fiber : b.fibers) {
    if (fiber.formulation == nullptr) continue;
    const std::size_t first = fiber.first_dof();
    for (std::size_t i = first; i < first + static_cast<std::size_t>(fiber.dofs()); ++i)
      b.work_n[i] += 0.5 * (b.external_n[i] + b.external[i]) * (b.dofs[i] - b.dofs_n[i]);
  }
  b.dofs_n = b.dofs;
  b.velocity_n = b.velocity;
  b.acceleration_n = b.acceleration;
  b.internal_n = b.internal;
  b.external_n = b.external;
}

const std::vector<double>& BeamField::dofs() const { return implementation_->dofs; }
const std::vector<double>& BeamField::velocity() const { return implementation_->velocity; }
const std::vector<double>& BeamField::acceleration() const { return implementation_->acceleration; }
const std::vector<double>& BeamField::accepted_dofs() const { return implementation_->dofs_n; }
const std::vector<double>& BeamField::accepted_velocity() const { return implementation_->velocity_n; }
const std::vector<double>& BeamField::accepted_acceleration() const { return implementation_->acceleration_n; }

std::vector<double> BeamField::reactions(const std::vector<double>& force) const {
  Implementation& b = *implementation_;
  if (!b.evaluated) b.evaluate_all(false);
  std::vector<double> reaction(b.full.size(), 0.0);
  for (const Fiber& fiber : b.fibers) {
    if (fiber.formulation == nullptr) continue;
    for (const Index node : {Index(0), static_cast<Index>(fiber.nodes - 1)}) {
      const NodeConstraint& constraint = node == 0 ? fiber.start : fiber.end;
      if (!constraint.active()) continue;
      const std::size_t dof = fiber.first_dof() + 6 * static_cast<std::size_t>(node);
      double all[6], free[6];
      for (int k = 0; k < 6; ++k) all[k] = free[k] = b.full[dof + k] - (force.empty() ? 0.0 : force[dof + k]);
      constraint.project(free);
      for (int k = 0; k < 6; ++k) reaction[dof + k] = all[k] - free[k];
    }
  }
  return reaction;
}

Vec3 BeamField::linear_momentum(const std::vector<double>& rate) const {
  const Implementation& b = *implementation_;
  Vec3 momentum = Vec3::Zero();
  ElementMatrix mass;
  for (const Fiber& fiber : b.fibers) {
    if (fiber.formulation == nullptr) continue;
    ElementProperties element = fiber.section;
    for (Index e = 0; e + 1 < fiber.nodes; ++e) {
      element.length = b.element_length(fiber)[e];
      fiber.formulation->mass(element, mass.data());
      const Eigen::Map<const ElementVector> v(&rate[fiber.first_dof() + 6 * static_cast<std::size_t>(e)]);
      momentum += (mass.middleRows<3>(0) + mass.middleRows<3>(6)) * v;
    }
  }
  return momentum;
}

Energy BeamField::energy() const {
  const Implementation& b = *implementation_;
  Energy energy;
  ElementMatrix mass;
  for (const Fiber& fiber : b.fibers) {
    if (fiber.formulation == nullptr) continue;
    ElementProperties element = fiber.section;
    for (Index e = 0; e + 1 < fiber.nodes; ++e) {
      element.length = b.element_length(fiber)[e];
      const std::size_t dof = fiber.first_dof() + 6 * static_cast<std::size_t>(e);
      energy.internal += fiber.formulation->energy(element, &b.dofs_n[dof]);
      fiber.formulation->mass(element, mass.data());
      const Eigen::Map<const ElementVector> v(&b.velocity_n[dof]);
      energy.kinetic += 0.5 * v.dot(mass * v);
    }
    for (std::size_t i = fiber.first_dof(); i < fiber.first_dof() + static_cast<std::size_t>(fiber.dofs()); ++i)
      energy.external_work += b.work_n[i];
  }
  return energy;
}

double BeamField::highest_frequency() const {
  const Implementation& b = *implementation_;
  std::map<Index, ElementProperties> shortest;  // of each group: the shortest element is the stiffest
  for (Index f = 0; f < b.mesh.fibers(); ++f) {
    const Fiber& fiber = b.fibers[f];
    if (fiber.formulation == nullptr) continue;
    ElementProperties element = fiber.section;
    element.length = *std::min_element(b.element_length(fiber), b.element_length(fiber) + fiber.nodes - 1);
    const auto [entry, is_new] = shortest.try_emplace(b.mesh.group[f], element);
    if (!is_new && element.length < entry->second.length) entry->second = element;
  }
  double highest = 0.0;
  for (const auto& [group, element] : shortest) {
    const double q[element_dofs] = {0, 0, 0, 1, 0, 0, element.length, 0, 0, 1, 0, 0};
    ElementVector force;
    ElementMatrix tangent, mass;
    const ElementFormulation* formulation = element_formulation(b.groups[group].formulation);
    formulation->internal_force(element, q, force.data(), tangent.data());
    formulation->mass(element, mass.data());
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> modes(tangent, mass, Eigen::EigenvaluesOnly);
    highest = std::fmax(highest, std::sqrt(std::fmax(0.0, modes.eigenvalues()[element_dofs - 1])));
  }
  return highest;
}

std::vector<std::pair<std::string, std::vector<double>*>> BeamField::state() {
  Implementation& b = *implementation_;
  return {{"dofs", &b.dofs_n},
          {"velocity", &b.velocity_n},
          {"acceleration", &b.acceleration_n},
          {"internal_force", &b.internal_n},
          {"external_force", &b.external_n},
          {"external_work", &b.work_n}};
}

}  // namespace fbi::beam
