/// Parts of the fibers' equations beside the elements: point loads, damping, moved supports, prescribed and rigid
/// fibers.
#include <algorithm>
#include <cmath>
#include <limits>

#include "base/counters.hpp"
#include "beam/differences.hpp"
#include "beam/fiber_equations.hpp"
#include "fem/line_shapes.hpp"

namespace fbi::beam {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

void store3(const Vec3& value, double* x) {
  for (int k = 0; k < 3; ++k) x[k] = value[k];
}

const NodeSupport* first_support(const Fiber& fiber) {
  return fiber.supports.empty() ? nullptr : &fiber.supports.front();
}

}  // namespace

void FiberEquations::project(Index f, double* force) const {
  if (is_rigid(f))
    rigid[f].project(force);
  else
    fibers[f].project(force);
}

// Adds the point loads of element e to the external force, and -d(force)/dq to the tangent.
void FiberEquations::add_point_loads(Index f, Index e, ElementMatrix* tangent) {
  const Fiber& fiber = fibers[f];
  const std::size_t dof = fiber.first_dof() + 6 * static_cast<std::size_t>(e);
  ElementVector force;
  ElementMatrix derivative;
  for (const PointLoad& load : load_values.point[f]) {
    if (load.element != e) continue;
    point_load_force(load, element_length(fiber)[e], frames, fiber.first_node + e, &dofs[dof], force.data(),
                     tangent != nullptr ? derivative.data() : nullptr);
    for (int i = 0; i < element_dofs; ++i) external[dof + i] += force[i];
    if (tangent != nullptr) *tangent -= level.internal * derivative;
  }
}

// Adds damping to the internal force of an element; at the middle of the step for the conserving scheme.
void FiberEquations::add_viscous(const Fiber& fiber, const ElementProperties& element, std::size_t dof,
                                 ElementVector& force, ElementMatrix* tangent) {
  ElementVector q, v, part;
  const double c = level.conserving ? 1 / level.dt : level.dynamic ? scheme.velocity_per_displacement(level.dt) : 0.0;
  for (int i = 0; i < element_dofs; ++i) {
    q[i] = level.conserving ? 0.5 * (dofs_n[dof + i] + dofs[dof + i]) : dofs[dof + i];
    v[i] = level.conserving ? c * (dofs[dof + i] - dofs_n[dof + i]) : velocity[dof + i];
  }
  ElementMatrix by_q, by_v;
  if (fiber.mass_damping > 0.0) {
    fiber.formulation->mass(element, by_v.data());
    force += fiber.mass_damping * (by_v * v);
    if (tangent != nullptr) *tangent += fiber.mass_damping * c * by_v;
  }
  if (fiber.stiffness_damping > 0.0) {
    fiber.formulation->viscous_force(element, q.data(), v.data(), part.data(),
                                     tangent != nullptr ? by_q.data() : nullptr,
                                     tangent != nullptr ? by_v.data() : nullptr);
    force += fiber.stiffness_damping * part;
    if (tangent != nullptr) *tangent += fiber.stiffness_damping * ((level.conserving ? 0.5 : 1.0) * by_q + c * by_v);
  }
}

void FiberEquations::set_initial_velocity() {
  for (Index f = 0; f < mesh.fibers(); ++f) {
    const input::VectorExpression& given = groups[mesh.group[f]].velocity;
    const Fiber& fiber = fibers[f];
    if (fiber.formulation == nullptr || (given[0].is_zero() && given[1].is_zero() && given[2].is_zero())) continue;
    const double length = 1e-3 * shortest_element(fiber);
    for (Index node = fiber.first_node; node < fiber.first_node + fiber.nodes; ++node) {
      const Vec3 x(&mesh.position[3 * static_cast<std::size_t>(node)]);
      const Vec3 g(&mesh.tangent[3 * static_cast<std::size_t>(node)]);
      const std::size_t dof = 6 * static_cast<std::size_t>(node);
      store3(value_of(given, x, 0.0), &velocity_n[dof]);
      store3(derivative_along(given, x, g, 0.0, length), &velocity_n[dof + 3]);
    }
    const std::size_t first = fiber.first_dof();
    if (is_rigid(f)) {
      rigid[f].set_velocity(&velocity_n[first]);
      rigid[f].store(rigid[f].last, &pose_n[first], &motion_n[first]);
    } else {
      fiber.project_increment(&velocity_n[first]);
      if (has_triads(f)) triads->set_initial_spin(*this, f, given);
    }
  }
  velocity = velocity_n;
}

void FiberEquations::start_moving_supports(double dt) {
  loads.evaluate(level.time - dt, 1.0, load_values);
  dofs = dofs_n;
  for (Index f = 0; f < mesh.fibers(); ++f) {
    if (!fibers[f].moving_supports) continue;
    for (NodeSupport& support : fibers[f].supports) {
      support.begin_step(level.time, dt, scheme.alpha_f);
      if (support.direction) support.constraint.axis = support.constraint.force_axis = support.axis_n.value;
    }
    balance_at_start(f, nullptr);
  }
}

RigidFiber::State FiberEquations::rigid_state(Index f) const {
  const std::size_t first = fibers[f].first_dof();
  return rigid[f].restore(&pose_n[first], &motion_n[first]);
}

void FiberEquations::accept_bodies_and_frames() {
  for (Index f = 0; f < mesh.fibers(); ++f) {
    if (!is_rigid(f)) continue;
    RigidFiber& body = rigid[f];
    const std::size_t first = fibers[f].first_dof();
    body.now.rotation = Eigen::Quaterniond(body.now.rotation).normalized().toRotationMatrix();
    body.fill(body.now, &dofs[first], &velocity[first], &acceleration[first]);
    body.store(body.now, &pose_n[first], &motion_n[first]);
    body.last = body.now;
  }
  for (Index node = 0; node < static_cast<Index>(frames.last.size() / 6); ++node)
    frames.advance(node, Vec3(&dofs[6 * static_cast<std::size_t>(node) + 3]));
}

void FiberEquations::rigid_reaction(Index f, const double* force, double* reaction) const {
  const Fiber& fiber = fibers[f];
  if (fiber.supports.empty()) return;
  const RigidFiber& body = rigid[f];
  Vector6 w = body.residual;
  if (force != nullptr) w -= body.wrench(force, body.middle);
  w -= body.basis * (body.basis.transpose() * w);
  const std::size_t node = 6 * static_cast<std::size_t>(fiber.supports.front().node);
  store3(w.head<3>(), reaction + node);
  const Vec3 tangent = body.middle * body.offset[node / 3 + 1];
  store3((body.middle * w.tail<3>()).cross(tangent) / tangent.squaredNorm(), reaction + node + 3);
}

void FiberEquations::begin_step(Index f) {
  Fiber& fiber = fibers[f];
  if (fiber.prescribed) {
    // Formulas without time say the same again: dofs are those of the last step.
    if (!fiber.placed) place_prescribed(fiber);
    fiber.placed = !depends_on_time(groups[mesh.group[f]].motion);
    return;
  }
  if (fiber.formulation == nullptr) return;
  if (fiber.moving_supports)
    for (NodeSupport& support : fiber.supports)
      support.begin_step(level.time, level.dt, level.dynamic ? scheme.alpha_f : 0.0);
  if (!is_rigid(f)) return update_rates(fiber);
  const std::size_t first = fiber.first_dof();
  RigidFiber& body = rigid[f];
  body.last = body.restore(&pose_n[first], &motion_n[first]);
  body.wrench_n = body.balance(body.last, &external_n[first], Vec3(&internal_n[first]));
  body.begin_step(scheme, level.dt, first_support(fiber));
  body.fill(body.now, &dofs[first], &velocity[first], &acceleration[first]);
}

void FiberEquations::balance_at_start(Index f, const double* force) {
  Fiber& fiber = fibers[f];
  const std::size_t first = fiber.first_dof(), size = static_cast<std::size_t>(fiber.dofs());
  if (is_rigid(f)) {
    RigidFiber& body = rigid[f];
    body.last = body.restore(&pose_n[first], &motion_n[first]);
    std::vector<double> forces(size);
    const Vec3 couple = rigid_loads(f, load_values, body.last, forces.data());
    std::copy_n(forces.begin(), size, &external_n[first]);
    store3(couple, &internal_n[first]);
    if (force != nullptr)
      for (std::size_t i = 0; i < size; ++i) forces[i] += force[i];
    body.balance_at_start(forces.data(), couple, first_support(fiber));
    body.store(body.last, &pose_n[first], &motion_n[first]);
    body.fill(body.last, &dofs_n[first], &velocity_n[first], &acceleration_n[first]);
    return;
  }
  std::fill_n(&acceleration_n[first], size, 0.0);
  for (const NodeSupport& support : fiber.supports) {
    const std::size_t dof = first + 6 * static_cast<std::size_t>(support.node);
    if (support.moves()) support.initial_rates(&dofs_n[dof], &velocity_n[dof], &acceleration_n[dof]);
  }
  std::copy_n(&velocity_n[first], size, &velocity[first]);
  evaluate(f, false);
  std::vector<double> given(&acceleration_n[first], &acceleration_n[first] + size), b(size);
  for (std::size_t i = 0; i < size; ++i) b[i] = (force == nullptr ? 0.0 : force[i]) - full[first + i];
  if (fiber.moving_supports) {
    ElementMatrix mass;
    ElementProperties element = fiber.section;
    for (Index e = 0; e + 1 < fiber.nodes; ++e) {
      element.length = element_length(fiber)[e];
      fiber.formulation->mass(element, mass.data());
      const ElementVector part = mass * Eigen::Map<const ElementVector>(&given[6 * static_cast<std::size_t>(e)]);
      for (int i = 0; i < element_dofs; ++i) b[6 * static_cast<std::size_t>(e) + i] -= part[i];
    }
  }
  assemble_mass(f);
  factorize(f);
  solve(f, b.data(), 1);
  for (std::size_t i = 0; i < size; ++i) acceleration_n[first + i] = given[i] + b[i];
  std::copy_n(&internal[first], size, &internal_n[first]);
  std::copy_n(&external[first], size, &external_n[first]);
  if (has_triads(f)) triads->initialize(*this, f);
}

// Positions, tangents and their rates at t_{n+1}: the formulas and their derivatives along the fiber and in time.
void FiberEquations::place_prescribed(const Fiber& fiber) {
  const input::VectorExpression& motion = groups[mesh.group[&fiber - fibers.data()]].motion;
  const double step = 0.25 * level.dt, length = 1e-3 * shortest_element(fiber);
  count_parts("prescribed fibers placed", 1);
  for (Index node = fiber.first_node; node < fiber.first_node + fiber.nodes; ++node) {
    const Vec3 x(&mesh.position[3 * static_cast<std::size_t>(node)]);
    const Vec3 g(&mesh.tangent[3 * static_cast<std::size_t>(node)]);
    const Motion at = motion_in_time(motion, x, level.time, step);
    const std::size_t dof = 6 * static_cast<std::size_t>(node);
    store3(x + at.value, &dofs[dof]);
    store3(at.rate, &velocity[dof]);
    store3(at.acceleration, &acceleration[dof]);
    // differences of values, rates and accelerations at neighboring points
    store3(g + derivative_along(motion, x, g, level.time, length), &dofs[dof + 3]);
    const Motion ahead = motion_in_time(motion, x + 10 * length * g, level.time, step),
                 behind = motion_in_time(motion, x - 10 * length * g, level.time, step);
    const Motion ahead_2 = motion_in_time(motion, x + 20 * length * g, level.time, step),
                 behind_2 = motion_in_time(motion, x - 20 * length * g, level.time, step);
    const double scale = 1 / (120 * length);
    store3(scale * (8 * (ahead.rate - behind.rate) - (ahead_2.rate - behind_2.rate)), &velocity[dof + 3]);
    store3(scale * (8 * (ahead.acceleration - behind.acceleration) - (ahead_2.acceleration - behind_2.acceleration)),
           &acceleration[dof + 3]);
  }
}

// Nodal external forces of a rigid fiber in a pose, shape=(dofs); returns the couple of its moments in the body.
Vec3 FiberEquations::rigid_loads(Index f, const LoadValues& values, const RigidFiber::State& state,
                                 double* forces) const {
  const Fiber& fiber = fibers[f];
  std::copy_n(&values.dead[fiber.first_dof()], fiber.dofs(), forces);
  Vec3 couple = Vec3::Zero();
  for (PointLoad load : values.point[f]) {
    if (load.moment) {
      couple += load.follower ? load.value : Vec3(state.rotation.transpose() * load.value);
      continue;
    }
    // turns with the body, whatever its tangent does
    load.value = state.rotation * load.value;
    const double l = element_length(fiber)[load.element];
    std::array<double, 4> h = fem::hermite(load.x);
    h[1] *= 0.5 * l;
    h[3] *= 0.5 * l;
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 3; ++k)
        forces[6 * static_cast<std::size_t>(load.element) + 3 * i + k] += h[i] * load.value[k];
  }
  return couple;
}

void FiberEquations::evaluate_rigid(Index f, bool with_tangent) {
  const Fiber& fiber = fibers[f];
  const std::size_t first = fiber.first_dof(), size = static_cast<std::size_t>(fiber.dofs());
  RigidFiber& body = rigid[f];
  const Vec3 couple = rigid_loads(f, load_values, body.now, &external[first]);
  std::fill_n(&internal[first], size, 0.0);
  store3(couple, &internal[first]);
  body.evaluate(scheme, level.dt, &external[first], couple, with_tangent);
  body.spread(body.residual, &full[first]);
  body.spread(body.basis * (body.basis.transpose() * body.residual), &residual[first]);

  const double length = shortest_element(fiber);
  double largest = 0.0, coordinate = 0.0;
  for (std::size_t i = 0; i < size; ++i) {
    largest = std::fmax(largest, std::abs(external[first + i]) / (i % 6 < 3 ? 1.0 : length));
    if (i % 6 < 3) coordinate = std::fmax(coordinate, std::abs(dofs[first + i]));
  }
  double extent = length;
  for (const Vec3& r : body.offset) extent = std::fmax(extent, r.norm());
  largest = std::fmax(largest, body.mass * body.now.acceleration.norm());
  largest = std::fmax(largest, (body.inertia * body.now.spin_rate).norm() / extent);
  largest = std::fmax(largest, body.now.spin.cross(body.inertia * body.now.spin).norm() / extent);
  scale[f] = largest;
  round_off[f] = 4 * epsilon * (largest + level.inertia * body.mass * (coordinate + extent));
}

}  // namespace fbi::beam
