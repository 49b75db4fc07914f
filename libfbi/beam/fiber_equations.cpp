#include "beam/fiber_equations.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.hpp"

namespace fbi::beam {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

ElementProperties element_properties(const FiberParameters& group) {
  ElementProperties element;
  element.axial_stiffness = group.material.young * group.section.area;
  element.bending_stiffness = group.material.young * group.section.inertia;
  element.mass_per_length = group.material.density * group.section.area;
  return element;
}

// Fills the numbers of circular sections.
std::vector<FiberParameters> with_sections(std::vector<FiberParameters> groups) {
  for (FiberParameters& group : groups) {
    Section& section = group.section;
    const double square = section.radius * section.radius;
    if (section.area == 0.0) section.area = M_PI * square;
    for (double* inertia : {&section.inertia, &section.inertia_2, &section.inertia_3})
      if (*inertia == 0.0) *inertia = 0.25 * M_PI * square * square;
    if (section.torsion == 0.0) section.torsion = 0.5 * M_PI * square * square;
  }
  return groups;
}

}  // namespace

template <class Projection>
static void project_nodes(const Fiber& fiber, double* x, Index columns, const Projection& projection) {
  for (const NodeSupport& support : fiber.supports) {
    double* rows = x + 6 * static_cast<std::size_t>(support.node) * columns;
    for (Index c = 0; c < columns; ++c) {
      double entries[6];
      for (int k = 0; k < 6; ++k) entries[k] = rows[static_cast<std::size_t>(k) * columns + c];
      projection(support.constraint, entries);
      for (int k = 0; k < 6; ++k) rows[static_cast<std::size_t>(k) * columns + c] = entries[k];
    }
  }
}

void Fiber::project(double* x, Index columns) const {
  project_nodes(*this, x, columns, [](const NodeConstraint& held, double* entries) { held.project(entries); });
}

void Fiber::project_increment(double* x, Index columns) const {
  project_nodes(*this, x, columns,
                [](const NodeConstraint& held, double* entries) { held.project_increment(entries); });
}

const NodeSupport* Fiber::support_at(Index node) const {
  for (const NodeSupport& support : supports)
    if (support.node == node) return &support;
  return nullptr;
}

double FiberEquations::shortest_element(const Fiber& fiber) const {
  return *std::min_element(element_length(fiber), element_length(fiber) + fiber.nodes - 1);
}

FiberEquations::FiberEquations(const mesh::FiberMesh& fiber_mesh, const std::vector<FiberParameters>& fiber_groups,
                               const BeamTimeParameters& time, const Vec3& gravity)
    : mesh(fiber_mesh),
      groups(with_sections(fiber_groups)),
      parameters(time),
      scheme(time.scheme == TimeScheme::midpoint ? 1.0 : time.rho_inf),
      loads(mesh, groups, gravity),
      fibers(mesh.fibers()) {
  std::size_t band_total = 0;
  bool any_motion = false;
  for (Index f = 0; f < mesh.fibers(); ++f) {
    const FiberParameters& group = groups[mesh.group[f]];
    Fiber& fiber = fibers[f];
    fiber.formulation = element_formulation(group.formulation);
    fiber.section = element_properties(group);
    fiber.first_node = mesh.first_node[f];
    fiber.nodes = mesh.first_node[f + 1] - mesh.first_node[f];
    fiber.first_element = mesh.first_element(f);
    fiber.band = band_total;
    fiber.prescribed = group.formulation == Formulation::prescribed;
    if (fiber.formulation == nullptr) continue;
    ++moving;
    fiber.supports = supports_of(group, mesh, f, parameters.scheme != TimeScheme::static_);
    for (const NodeSupport& support : fiber.supports) fiber.moving_supports = fiber.moving_supports || support.moves();
    fiber.mass_damping = group.damping.mass;
    fiber.stiffness_damping = group.damping.stiffness;
    if (group.formulation == Formulation::torsion_free) band_total += band_size(fiber.dofs());
  }
  move_joined_nodes();
  for (const Fiber& fiber : fibers) any_motion = any_motion || fiber.moving_supports;
  const std::size_t size = 6 * static_cast<std::size_t>(mesh.nodes());
  for (NodalField* field : {&velocity_n, &acceleration_n, &internal_n, &external_n, &work_n, &velocity, &acceleration,
                            &internal, &external, &residual, &full})
    field->assign(size, 0.0);
  dofs_n.resize(size);
  for (std::size_t node = 0; node < size / 6; ++node)
    for (std::size_t k = 0; k < 3; ++k) {
      dofs_n[6 * node + k] = mesh.position[3 * node + k];
      dofs_n[6 * node + 3 + k] = mesh.tangent[3 * node + k];
    }
  dofs = dofs_n;
  if (any_motion) shift.assign(size, 0.0);
  if (loads.has_followers()) frames.initialize(mesh);
  any_rigid = std::any_of(groups.begin(), groups.end(),
                          [](const FiberParameters& group) { return group.formulation == Formulation::rigid; });
  if (any_rigid) {
    pose_n.assign(size, 0.0);
    motion_n.assign(size, 0.0);
    rigid.resize(fibers.size());
    for (Index f = 0; f < mesh.fibers(); ++f) {
      const FiberParameters& group = groups[mesh.group[f]];
      const Fiber& fiber = fibers[f];
      if (group.formulation != Formulation::rigid) continue;
      const std::size_t first = fiber.first_dof();
      rigid[f] = RigidFiber(
          {&dofs[first], &dofs[first] + fiber.dofs()}, {element_length(fiber), element_length(fiber) + fiber.nodes - 1},
          fiber.section.mass_per_length, group.material.density * group.section.inertia, fiber.supports);
      rigid[f].store(rigid[f].last, &pose_n[first], &motion_n[first]);
    }
  }
  if (std::any_of(groups.begin(), groups.end(),
                  [](const FiberParameters& group) { return group.formulation == Formulation::simo_reissner; }))
    triads = std::make_unique<TriadField>(*this);
  scale.assign(fibers.size(), 0.0);
  round_off.assign(fibers.size(), 0.0);
  singular.assign(fibers.size(), 0);
  pivot.assign(size, 0);
  band.assign(band_total, 0.0);
  loads.evaluate(0.0, parameters.scheme == TimeScheme::static_ ? 0.0 : 1.0, load_values);
  batches = std::make_unique<FiberBatches>(*this);
}

// A support that moves a node moves those joined to it as well: Newmark's updates of a displacement that the others
// give to them would ring.
void FiberEquations::move_joined_nodes() {
  const auto fiber_of = [this](Index node) -> Fiber& {
    const auto after = std::upper_bound(mesh.first_node.begin(), mesh.first_node.end(), node);
    return fibers[static_cast<std::size_t>(after - mesh.first_node.begin()) - 1];
  };
  const auto support_of = [](const Fiber& fiber, Index node) { return fiber.support_at(node - fiber.first_node); };
  for (bool changed = !mesh.joints.empty(); changed;) {
    changed = false;
    for (const mesh::FiberMesh::LocalJoint& joint : mesh.joints)
      for (const auto& [from, to] : {std::pair(joint.a, joint.b), std::pair(joint.b, joint.a)}) {
        const NodeSupport* source = support_of(fiber_of(from), from);
        if (source == nullptr || !source->motion) continue;
        Fiber& fiber = fiber_of(to);
        const NodeSupport* other = support_of(fiber, to);
        if (other != nullptr && other->motion) continue;
        const std::string& name = mesh.name[static_cast<std::size_t>(&fiber - fibers.data())];
        if (fiber.formulation == nullptr || other != nullptr)
          throw Error(ExitCode::geometry, "fiber \"" + name +
                                              "\" is held where a joint ties it to a support that moves; "
                                              "remove the joint, or give both supports the same \"motion\"");
        NodeSupport support;
        support.node = to - fiber.first_node;
        support.reference = Vec3(&mesh.position[3 * static_cast<std::size_t>(to)]);
        support.constraint =
            NodeConstraint(EndCondition::pinned, Vec3(&mesh.tangent[3 * static_cast<std::size_t>(to)]));
        support.motion = source->motion;
        support.begin_step(0.0, 0.0, 0.0);
        fiber.supports.push_back(support);
        fiber.moving_supports = changed = true;
      }
  }
}

// Internal, inertial and external forces of one fiber, G_b = residual (supports projected out), K_b in the band on
// request.
void FiberEquations::evaluate(Index f, bool with_tangent) {
  if (is_rigid(f)) return evaluate_rigid(f, with_tangent);
  if (has_triads(f)) return triads->evaluate(*this, f, with_tangent);
  const Fiber& fiber = fibers[f];
  const std::size_t first = fiber.first_dof(), size = static_cast<std::size_t>(fiber.dofs());
  std::fill_n(&internal[first], size, 0.0);
  std::fill_n(&full[first], size, 0.0);
  std::copy_n(&load_values.dead[first], size, &external[first]);
  double* matrix = &band[fiber.band];
  if (with_tangent) std::fill_n(matrix, band_size(fiber.dofs()), 0.0);

  const double shortest = shortest_element(fiber);
  double largest = 0.0;
  const auto enlarge = [&largest](const double* force, double length) {
    for (int k = 0; k < 6; ++k) largest = std::fmax(largest, std::abs(force[k]) / (k < 3 ? 1.0 : length));
  };
  ElementProperties element = fiber.section;
  ElementVector force, rate;
  ElementMatrix tangent, mass;
  for (Index e = 0; e + 1 < fiber.nodes; ++e) {
    element.length = element_length(fiber)[e];
    const std::size_t dof = first + 6 * static_cast<std::size_t>(e);
    if (level.conserving)
      fiber.formulation->conserving_force(element, &dofs_n[dof], &dofs[dof], force.data(),
                                          with_tangent ? tangent.data() : nullptr);
    else
      fiber.formulation->internal_force(element, &dofs[dof], force.data(), with_tangent ? tangent.data() : nullptr);
    if (parameters.scheme != TimeScheme::static_ && (fiber.mass_damping > 0.0 || fiber.stiffness_damping > 0.0))
      add_viscous(fiber, element, dof, force, with_tangent ? &tangent : nullptr);
    for (int i = 0; i < element_dofs; ++i) {
      internal[dof + i] += force[i];
      full[dof + i] += (level.conserving ? 1.0 : level.internal) * force[i];
    }
    enlarge(force.data(), element.length);
    enlarge(force.data() + 6, element.length);
    if (with_tangent && !level.conserving) tangent *= level.internal;
    if (level.dynamic) {
      fiber.formulation->mass(element, mass.data());
      for (int i = 0; i < element_dofs; ++i)
        rate[i] = (1 - scheme.alpha_m) * acceleration[dof + i] + scheme.alpha_m * acceleration_n[dof + i];
      if (fiber.moving_supports)
        for (int i = 0; i < element_dofs; ++i) rate[i] += shift[dof + i];
      force.noalias() = mass * rate;
      for (int i = 0; i < element_dofs; ++i) full[dof + i] += force[i];
      enlarge(force.data(), element.length);
      enlarge(force.data() + 6, element.length);
      if (with_tangent) tangent += level.inertia * mass;
    }
    if (!load_values.point[f].empty()) add_point_loads(f, e, with_tangent ? &tangent : nullptr);
    if (with_tangent) assemble_element(fiber, e, tangent);
  }

  double coordinate = 0.0;
  for (std::size_t i = 0; i < size; i += 6) {
    enlarge(&external[first + i], shortest);
    for (int k = 0; k < 3; ++k) coordinate = std::fmax(coordinate, std::abs(dofs[first + i + k]));
  }
  for (std::size_t i = first; i < first + size; ++i) {
    const double internal_part = level.conserving ? 0.0 : level.previous * internal_n[i];
    full[i] += internal_part - level.previous * external_n[i] - level.internal * external[i];
    residual[i] = full[i];
  }
  fiber.project(&residual[first]);
  scale[f] = largest;
  round_off[f] = round_off_of(f, coordinate);
}

double FiberEquations::round_off_of(Index f, double coordinate) const {
  const Fiber& fiber = fibers[f];
  const double shortest = shortest_element(fiber);
  const double viscous = level.dynamic ? fiber.stiffness_damping * scheme.velocity_per_displacement(level.dt)
                                       : 0.0;  // relative to elastic
  const double stiffness =
      (1 + viscous) * (fiber.section.axial_stiffness + fiber.section.bending_stiffness / (shortest * shortest));
  return 4 * epsilon *
         (stiffness * (1 + coordinate / shortest) +
          level.inertia * fiber.section.mass_per_length * shortest * coordinate);
}

// Projects the supports out and adds the element matrix to the band.
void FiberEquations::assemble_element(const Fiber& fiber, Index e, ElementMatrix& matrix) {
  const NodeSupport* support[2] = {fiber.support_at(e), fiber.support_at(e + 1)};
  double position_scale = 0.0, tangent_scale = 0.0;
  for (int k = 0; k < 3; ++k) {
    position_scale = std::fmax(position_scale, std::fmax(std::abs(matrix(k, k)), std::abs(matrix(6 + k, 6 + k))));
    tangent_scale = std::fmax(tangent_scale, std::fmax(std::abs(matrix(3 + k, 3 + k)), std::abs(matrix(9 + k, 9 + k))));
  }
  for (int end = 0; end < 2; ++end)
    if (support[end] != nullptr) support[end]->constraint.project_element(matrix.data(), end);
  for (int end = 0; end < 2; ++end)
    if (support[end] != nullptr)
      support[end]->constraint.fill_element(matrix.data(), end, position_scale, tangent_scale);
  double* target = &band[fiber.band];
  for (Index i = 0; i < element_dofs; ++i) {
    double* row = target + band_entry(6 * e + i, 6 * e);
    for (Index j = 0; j < element_dofs; ++j) row[j] += matrix(i, j);
  }
}

void FiberEquations::evaluate_all(bool with_tangent) {
  batches->evaluate(*this, with_tangent);
  for (Index f = 0; f < mesh.fibers(); ++f) {
    if (fibers[f].formulation == nullptr) continue;
    if (!batches->has(f) || (with_tangent && !batches->is_factorized(f))) evaluate(f, with_tangent);
  }
  evaluated = true;
}

void FiberEquations::factorize_all() {
  for (Index f = 0; f < mesh.fibers(); ++f) {
    if (fibers[f].formulation == nullptr || batches->is_factorized(f)) continue;
    factorize(f);
    condense(f);
  }
}

void FiberEquations::assemble_mass(Index f) {
  if (has_triads(f)) return triads->assemble_mass(*this, f);
  const Fiber& fiber = fibers[f];
  std::fill_n(&band[fiber.band], band_size(fiber.dofs()), 0.0);
  ElementMatrix mass;
  ElementProperties element = fiber.section;
  for (Index e = 0; e + 1 < fiber.nodes; ++e) {
    element.length = element_length(fiber)[e];
    fiber.formulation->mass(element, mass.data());
    assemble_element(fiber, e, mass);
  }
}

bool FiberEquations::factorize(Index f) {
  if (has_triads(f)) return triads->factorize(*this, f);
  batches->leave(f);
  const Fiber& fiber = fibers[f];
  if (is_rigid(f)) {
    singular[f] = !rigid[f].factorize();
    return !singular[f];
  }
  singular[f] = !band_factorize(&band[fiber.band], &pivot[fiber.first_dof()], fiber.dofs());
  return !singular[f];
}

void FiberEquations::condense(Index f) {
  if (has_triads(f)) triads->condense(*this, f);
}

void FiberEquations::solve(Index f, double* b, Index columns) const {
  if (has_triads(f)) return triads->solve(*this, f, b, columns);
  if (batches->is_factorized(f)) return batches->solve(f, b, columns);
  const Fiber& fiber = fibers[f];
  if (singular[f]) {
    std::fill_n(b, static_cast<std::size_t>(fiber.dofs()) * columns, std::numeric_limits<double>::quiet_NaN());
    return;
  }
  if (is_rigid(f)) return rigid[f].solve(b, columns);
  fiber.project(b, columns);
  band_solve(&band[fiber.band], &pivot[fiber.first_dof()], fiber.dofs(), b, columns);
  fiber.project_increment(b, columns);
}

void FiberEquations::update_rates(const Fiber& fiber) {
  const std::size_t first = fiber.first_dof();
  const std::size_t f = static_cast<std::size_t>(&fiber - fibers.data());
  if (is_rigid(static_cast<Index>(f))) {
    rigid[f].update_rates(scheme, level.dt, fiber.supports.empty() ? nullptr : &fiber.supports.front());
    rigid[f].fill(rigid[f].now, &dofs[first], &velocity[first], &acceleration[first]);
    return;
  }
  for (const NodeSupport& support : fiber.supports)
    if (support.moves()) support.place(&dofs[first + 6 * static_cast<std::size_t>(support.node)]);
  if (!level.dynamic) return;
  for (std::size_t i = first; i < first + static_cast<std::size_t>(fiber.dofs()); ++i) {
    const double change = dofs[i] - dofs_n[i];
    velocity[i] = scheme.velocity(change, velocity_n[i], acceleration_n[i], level.dt);
    acceleration[i] = scheme.acceleration(change, velocity_n[i], acceleration_n[i], level.dt);
  }
  for (const NodeSupport& support : fiber.supports) {
    if (!support.moves()) continue;
    const std::size_t dof = first + 6 * static_cast<std::size_t>(support.node);
    support.set_rates(scheme, level.dt, &dofs_n[dof], &velocity_n[dof], &acceleration_n[dof], &dofs[dof],
                      &velocity[dof], &acceleration[dof]);
    support.shift(scheme, &dofs_n[dof], &velocity_n[dof], &acceleration_n[dof], &dofs[dof], &velocity[dof],
                  &acceleration[dof], &shift[dof]);
  }
}

void FiberEquations::add_increment(const Fiber& fiber, const double* delta, double factor) {
  const std::size_t first = fiber.first_dof();
  const std::size_t f = static_cast<std::size_t>(&fiber - fibers.data());
  if (is_rigid(static_cast<Index>(f))) {
    rigid[f].turn_by(rigid[f].twist_of(delta), factor);
  } else {
    double change[6];
    for (Index node = 0; node < fiber.nodes; ++node) {
      const std::size_t at = 6 * static_cast<std::size_t>(node);
      std::copy_n(delta + at, 6, change);
      if (const NodeSupport* support = fiber.support_at(node)) support->constraint.project_increment(change);
      for (std::size_t k = 0; k < 6; ++k) dofs[first + at + k] += factor * change[k];
    }
  }
  update_rates(fiber);
}

}  // namespace fbi::beam
