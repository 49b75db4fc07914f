#include "beam/triad_field.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "beam/fiber_equations.hpp"
#include "fem/line_shapes.hpp"

namespace fbi::beam {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();
constexpr Index unknowns = 12;  // of a node and the middle behind it: d, t, a, a_m
constexpr Index first_turn = 6;

using TriadMatrix = Eigen::Matrix<double, triad_element_dofs, triad_element_dofs, Eigen::RowMajor>;
using TriadVector = Eigen::Matrix<double, triad_element_dofs, 1>;

double& at(double* band, Index i, Index j) { return band[TriadBand::entry(i, j)]; }
double at(const double* band, Index i, Index j) { return band[TriadBand::entry(i, j)]; }

// Second axis carried from (x, tangent) to (next_x, next_tangent) without twist: two reflections, fourth order.
Vec3 carried(const Vec3& axis, const Vec3& x, const Vec3& tangent, const Vec3& next_x, const Vec3& next_tangent) {
  const auto reflect = [](const Vec3& v, const Vec3& normal) {
    return Vec3(v - 2 * normal.dot(v) / normal.squaredNorm() * normal);
  };
  const Vec3 first = next_x - x;
  return reflect(reflect(axis, first), next_tangent - reflect(tangent, first));
}

Quaternion triad_of(const Vec3& tangent, const Vec3& axis) {
  Mat3 matrix;
  matrix.col(0) = tangent;
  matrix.col(1) = (axis - axis.dot(tangent) * tangent).normalized();
  matrix.col(2) = tangent.cross(matrix.col(1));
  return normalized(Quaternion(matrix));
}

Vec3 three(const std::vector<double>& field, std::size_t triad) { return Vec3(&field[3 * triad]); }
void set(std::vector<double>& field, std::size_t triad, const Vec3& value) {
  for (int k = 0; k < 3; ++k) field[3 * triad + k] = value[k];
}

}  // namespace

TriadField::TriadField(FiberEquations& equations) {
  const mesh::FiberMesh& mesh = equations.mesh;
  const std::size_t nodes = static_cast<std::size_t>(mesh.nodes());
  for (std::vector<double>* field : {&rotation_n, &spin_n, &spin_rate_n, &moment_n, &external_n, &work_n, &spin,
                                     &spin_rate, &moment, &external, &residual, &held_moment, &turn})
    field->assign(6 * nodes, 0.0);
  triad_n.assign(2 * nodes, Quaternion::Identity());
  share_.assign(2 * nodes, 0.0);
  section.resize(equations.fibers.size());
  held_.assign(2 * nodes, 0);
  band_begin_ = turn_band_begin_ = {0};
  elements_.reserve(static_cast<std::size_t>(mesh.elements()));
  const std::array<Quaternion, 3> unused = {Quaternion::Identity(), Quaternion::Identity(), Quaternion::Identity()};
  for (Index f = 0; f < mesh.fibers(); ++f) {
    Fiber& fiber = equations.fibers[f];
    const FiberParameters& group = equations.groups[mesh.group[f]];
    const bool mine = group.formulation == Formulation::simo_reissner;
    band_begin_.push_back(band_begin_.back() + (mine ? TriadBand::size(unknowns * fiber.nodes) : 0));
    turn_band_begin_.push_back(turn_band_begin_.back() + (mine ? TurnBand::size(6 * fiber.nodes) : 0));
    if (mine) {
      section[f] = TriadSection(group.section, group.material);
      // supports hold the triad, not the tangent of the center line
      for (NodeSupport& support : fiber.supports) {
        held_[2 * static_cast<std::size_t>(fiber.first_node + support.node)] = support.constraint.direction;
        support.constraint.direction = false;
      }
    }
    Vec3 x, tangent, axis;
    for (Index e = 0; e + 1 < fiber.nodes; ++e) {
      const std::size_t node = static_cast<std::size_t>(fiber.first_node + e);
      const double length = equations.element_length(fiber)[e];
      const double* q = &equations.dofs_n[6 * node];
      if (mine) {
        if (e == 0) {
          x = Vec3(q);
          tangent = Vec3(q + 3).normalized();
          axis = group.section.direction.norm() > 0 ? group.section.direction : axis_across(tangent);
          axis = (axis - axis.dot(tangent) * tangent).normalized();
          triad_n[2 * node] = triad_of(tangent, axis);
        }
        const std::array<double, 4> h = fem::hermite(0.0), h1 = fem::hermite_first(0.0);
        for (const bool middle : {true, false}) {
          Vec3 next = Vec3::Zero(), next_tangent = Vec3::Zero();
          for (int i = 0; i < 4; ++i) {
            const double factor = i % 2 == 0 ? 1.0 : 0.5 * length;
            next += h[i] * factor * Vec3(q + 3 * i);
            next_tangent += h1[i] * factor * Vec3(q + 3 * i);
          }
          if (!middle) {
            next = Vec3(q + 6);
            next_tangent = Vec3(q + 9);
          }
          next_tangent.normalize();
          axis = carried(axis, x, tangent, next, next_tangent);
          x = next;
          tangent = next_tangent;
          triad_n[2 * node + (middle ? 1 : 2)] = triad_of(tangent, axis);
        }
        for (int c = 0; c < 3; ++c) share_[2 * node + c] += triad_share[c] * length;
      }
      elements_.emplace_back(length, q, mine ? element_triads(triad_n, static_cast<Index>(node)) : unused);
    }
  }
  for (std::size_t t = 0; t < triad_n.size(); ++t) {
    set(rotation_n, t, logarithm(triad_n[t]));
    triad_n[t] = exponential(three(rotation_n, t));
  }
  triad = reference_ = triad_n;
  tangent_.assign(band_begin_.back(), 0.0);
  band_.assign(band_begin_.back(), 0.0);
  turn_band_.assign(turn_band_begin_.back(), 0.0);
  pivot_.assign(unknowns * nodes, 0);
  turn_pivot_.assign(6 * nodes, 0);
  singular_.assign(equations.fibers.size(), 0);
  condensed_.assign(equations.fibers.size(), 0);
}

std::array<Quaternion, 3> TriadField::element_triads(const std::vector<Quaternion>& triads, Index node) const {
  const std::size_t t = 2 * static_cast<std::size_t>(node);
  return {triads[t], triads[t + 1], triads[t + 2]};
}

void TriadField::begin_step() {
  for (std::size_t t = 0; t < triad_n.size(); ++t) triad_n[t] = exponential(three(rotation_n, t));
  triad = triad_n;
  spin = spin_n;
  spin_rate = spin_rate_n;
  std::fill(turn.begin(), turn.end(), 0.0);
  std::fill(condensed_.begin(), condensed_.end(), 0);
}

void TriadField::accept_step() {
  for (std::size_t i = 0; i < work_n.size(); ++i) work_n[i] += 0.5 * (external_n[i] + external[i]) * turn[i];
  for (std::size_t t = 0; t < triad.size(); ++t) {
    set(rotation_n, t, logarithm(triad[t]));
    triad_n[t] = exponential(three(rotation_n, t));
  }
  spin_n = spin;
  spin_rate_n = spin_rate;
  moment_n = moment;
  external_n = external;
}

void TriadField::predict(FiberEquations& equations, Index f) {
  const Fiber& fiber = equations.fibers[f];
  std::vector<double> turns(&spin_n[fiber.first_dof()], &spin_n[fiber.first_dof()] + fiber.dofs());
  add_turns(equations, f, turns.data(), equations.level.dt);
}

void TriadField::evaluate(FiberEquations& equations, Index f, bool with_tangent) {
  const Fiber& fiber = equations.fibers[f];
  const Level& level = equations.level;
  const std::size_t first = fiber.first_dof(), size = static_cast<std::size_t>(fiber.dofs());
  std::fill_n(&equations.internal[first], size, 0.0);
  std::fill_n(&equations.full[first], size, 0.0);
  std::fill_n(&moment[first], size, 0.0);
  std::fill_n(&external[first], size, 0.0);
  std::copy_n(&equations.load_values.dead[first], size, &equations.external[first]);
  std::fill_n(&residual[first], size, 0.0);
  condensed_[f] = 0;
  double* band = tangent_.data() + band_begin_[f];
  if (with_tangent) std::fill_n(band, TriadBand::size(unknowns * fiber.nodes), 0.0);
  const double shortest = equations.shortest_element(fiber);
  double largest = 0.0;
  const auto enlarge = [&largest](double force) { largest = std::fmax(largest, std::abs(force)); };

  TriadVector force;
  TriadMatrix tangent;
  ElementVector rate, inertia;
  ElementMatrix mass;
  ElementProperties properties = fiber.section;
  for (Index e = 0; e + 1 < fiber.nodes; ++e) {
    const std::size_t node = static_cast<std::size_t>(fiber.first_node + e), dof = 6 * node;
    const TriadElement& element = elements_[static_cast<std::size_t>(fiber.first_element + e)];
    triad_internal_force(section[f], element, &equations.dofs[dof], element_triads(triad, static_cast<Index>(node)),
                         force.data(), with_tangent ? tangent.data() : nullptr);
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 3; ++k) {
        const double value = force[center_line_place[i] + k];
        equations.internal[dof + 3 * i + k] += value;
        equations.full[dof + 3 * i + k] += level.internal * value;
        enlarge(i % 2 == 0 ? value : value / element.length);
      }
    for (int c = 0; c < 3; ++c)
      for (int k = 0; k < 3; ++k) {
        moment[dof + 3 * c + k] += force[triad_place[c] + k];
        enlarge(force[triad_place[c] + k] / element.length);
      }
    if (with_tangent) tangent *= level.internal;
    if (level.dynamic) {
      properties.length = element.length;
      fiber.formulation->mass(properties, mass.data());
      const double alpha_m = equations.scheme.alpha_m;
      for (int i = 0; i < element_dofs; ++i)
        rate[i] = (1 - alpha_m) * equations.acceleration[dof + i] + alpha_m * equations.acceleration_n[dof + i];
      if (fiber.moving_supports)
        for (int i = 0; i < element_dofs; ++i) rate[i] += equations.shift[dof + i];
      inertia.noalias() = mass * rate;
      for (int i = 0; i < element_dofs; ++i) {
        equations.full[dof + i] += inertia[i];
        enlarge(i % 6 < 3 ? inertia[i] : inertia[i] / element.length);
      }
      if (with_tangent)
        for (int i = 0; i < 4; ++i)
          for (int j = 0; j < 4; ++j)
            tangent.block<3, 3>(center_line_place[i], center_line_place[j]) +=
                level.inertia * mass.block<3, 3>(3 * i, 3 * j);
    }
    if (!with_tangent) continue;
    for (Index i = 0; i < triad_element_dofs; ++i) {
      double* row = band + TriadBand::entry(unknowns * e + i, unknowns * e);
      for (Index j = 0; j < triad_element_dofs; ++j) row[j] += tangent(i, j);
    }
  }

  add_point_loads(equations, f, with_tangent);
  const bool dynamic = equations.parameters.scheme != TimeScheme::static_;
  const Vec3& rotary = section[f].rotary;
  for (Index t = 0; t + 1 < 2 * fiber.nodes; ++t) {
    const std::size_t all = 2 * static_cast<std::size_t>(fiber.first_node) + static_cast<std::size_t>(t);
    const Index place = unknowns * (t / 2) + first_turn + 3 * (t % 2);
    const Vec3 inertia_t = share_[all] * rotary;
    Mat3 block = Mat3::Zero();
    const Vec3 omega = three(spin, all);
    const Mat3 map = level.dynamic && with_tangent ? inverse_tangent_map(three(turn, all)) : Mat3::Zero();
    Vec3 value = three(moment, all);
    if (dynamic) {
      const Vec3 swirl = inertia_t.cwiseProduct(omega);
      value += omega.cross(swirl);
      if (level.dynamic && with_tangent)
        block += level.internal * equations.scheme.velocity_per_displacement(level.dt) *
                 (hat(omega) * inertia_t.asDiagonal() - hat(swirl)) * map;
    }
    value -= three(external, all);
    set(moment, all, value);
    Vec3 sum = level.internal * value + level.previous * three(moment_n, all);
    if (level.dynamic) {
      const double alpha_m = equations.scheme.alpha_m;
      const Vec3 level_rate = (1 - alpha_m) * three(spin_rate, all) + alpha_m * three(spin_rate_n, all);
      sum += inertia_t.cwiseProduct(level_rate);
      if (with_tangent) block += level.inertia * (inertia_t.asDiagonal() * map);
    }
    set(held_[all] == 0 ? residual : held_moment, all, sum);
    if (!with_tangent) continue;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) at(band, place + i, place + j) += block(i, j);
  }

  double coordinate = 0.0;
  for (std::size_t i = 0; i < size; ++i) {
    const double load = equations.external[first + i];
    enlarge(i % 6 < 3 ? load : load / shortest);
    enlarge(external[first + i] / shortest);
    if (i % 6 < 3) coordinate = std::fmax(coordinate, std::abs(equations.dofs[first + i]));
    equations.full[first + i] +=
        level.previous * (equations.internal_n[first + i] - equations.external_n[first + i]) - level.internal * load;
    equations.residual[first + i] = equations.full[first + i];
  }
  fiber.project(&equations.residual[first]);
  equations.scale[f] = largest;
  const double stiffness = section[f].force.maxCoeff() + section[f].moment.maxCoeff() / (shortest * shortest);
  equations.round_off[f] =
      4 * epsilon *
      (stiffness * (1 + coordinate / shortest) + level.inertia * fiber.section.mass_per_length * shortest * coordinate);
  if (with_tangent) constrain(equations, f);
}

void TriadField::add_point_loads(FiberEquations& equations, Index f, bool with_tangent) {
  const Fiber& fiber = equations.fibers[f];
  const double weight = equations.level.internal;
  double* band = tangent_.data() + band_begin_[f];
  ElementVector force;
  ElementMatrix derivative;
  for (const PointLoad& load : equations.load_values.point[f]) {
    const Index e = load.element;
    const std::size_t node = static_cast<std::size_t>(fiber.first_node + e);
    if (!load.moment) {
      point_load_force(load, equations.element_length(fiber)[e], equations.frames, static_cast<Index>(node),
                       &equations.dofs[6 * node], force.data(), with_tangent ? derivative.data() : nullptr);
      for (std::size_t i = 0; i < element_dofs; ++i) equations.external[6 * node + i] += force[static_cast<Index>(i)];
      if (!with_tangent) continue;
      for (int i = 0; i < element_dofs; ++i)
        for (int j = 0; j < element_dofs; ++j)
          at(band, unknowns * e + center_line_place[i / 3] + i % 3, unknowns * e + center_line_place[j / 3] + j % 3) -=
              weight * derivative(i, j);
      continue;
    }
    // between triads by the functions that interpolate small turns
    const double x = load.x, share[3] = {0.5 * x * (x - 1), 1 - x * x, 0.5 * x * (x + 1)};
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t all = 2 * node + c;
      const Quaternion& axes = load.follower ? reference_[all] : triad[all];
      const Vec3 moment_part = share[c] * (axes.conjugate() * load.value);
      set(external, all, three(external, all) + moment_part);
      if (!with_tangent || load.follower) continue;
      const Mat3 skew = hat(moment_part);
      const Index place = unknowns * e + triad_place[c];
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) at(band, place + i, place + j) -= weight * skew(i, j);
    }
  }
}

// Projects the supports out of the tangent and fills what is empty, so that it stays regular.
void TriadField::constrain(const FiberEquations& equations, Index f) {
  const Fiber& fiber = equations.fibers[f];
  double* band = tangent_.data() + band_begin_[f];
  const Index rows = unknowns * fiber.nodes;
  for (const NodeSupport& support : fiber.supports) {
    const NodeConstraint& constraint = support.constraint;
    const Index node = unknowns * support.node;
    const Index low = std::max<Index>(0, node - unknowns), high = std::min<Index>(rows, node + triad_element_dofs);
    double scale[3] = {};  // of positions, tangents, turns
    for (Index k = 0; k < 9; ++k) scale[k / 3] = std::fmax(scale[k / 3], std::abs(at(band, node + k, node + k)));
    double entries[6];
    if (constraint.active()) {
      for (const bool by_row : {true, false})
        for (Index j = low; j < high; ++j) {
          const auto entry = [&](Index k) -> double& { return by_row ? at(band, node + k, j) : at(band, j, node + k); };
          for (Index k = 0; k < 6; ++k) entries[k] = entry(k);
          constraint.project(entries);
          for (Index k = 0; k < 6; ++k) entry(k) = entries[k];
        }
      for (Index k = 0; k < 6; ++k) {
        std::fill_n(entries, 6, 0.0);
        entries[k] = 1.0;
        constraint.project(entries);
        for (Index l = 0; l < 6; ++l)
          at(band, node + l, node + k) += scale[k / 3] * ((k == l ? 1.0 : 0.0) - entries[l]);
      }
    }
    if (held_[2 * static_cast<std::size_t>(fiber.first_node + support.node)] == 0) continue;
    for (Index k = first_turn; k < 9; ++k) {
      for (Index j = low; j < high; ++j) at(band, node + k, j) = at(band, j, node + k) = 0.0;
      at(band, node + k, node + k) = scale[2];
    }
  }
  for (Index k = rows - 3; k < rows; ++k) at(band, k, k) = 1.0;
}

void TriadField::assemble_mass(FiberEquations& equations, Index f) {
  const Fiber& fiber = equations.fibers[f];
  double* band = tangent_.data() + band_begin_[f];
  std::fill_n(band, TriadBand::size(unknowns * fiber.nodes), 0.0);
  ElementMatrix mass;
  ElementProperties properties = fiber.section;
  for (Index e = 0; e + 1 < fiber.nodes; ++e) {
    properties.length = equations.element_length(fiber)[e];
    fiber.formulation->mass(properties, mass.data());
    for (int i = 0; i < element_dofs; ++i)
      for (int j = 0; j < element_dofs; ++j)
        at(band, unknowns * e + center_line_place[i / 3] + i % 3, unknowns * e + center_line_place[j / 3] + j % 3) +=
            mass(i, j);
  }
  for (Index t = 0; t + 1 < 2 * fiber.nodes; ++t) {
    const std::size_t all = 2 * static_cast<std::size_t>(fiber.first_node) + static_cast<std::size_t>(t);
    const Index place = unknowns * (t / 2) + first_turn + 3 * (t % 2);
    for (int k = 0; k < 3; ++k) at(band, place + k, place + k) = share_[all] * section[f].rotary[k];
  }
  constrain(equations, f);
}

bool TriadField::factorize(FiberEquations& equations, Index f) {
  const Fiber& fiber = equations.fibers[f];
  double* band = band_.data() + band_begin_[f];
  std::copy_n(tangent_.data() + band_begin_[f], TriadBand::size(unknowns * fiber.nodes), band);
  singular_[f] = !TriadBand::factorize(band, &pivot_[2 * fiber.first_dof()], unknowns * fiber.nodes);
  equations.singular[f] = singular_[f];
  return !singular_[f];
}

void TriadField::condense(FiberEquations& equations, Index f) {
  const Fiber& fiber = equations.fibers[f];
  const double* band = tangent_.data() + band_begin_[f];
  double* turns = turn_band_.data() + turn_band_begin_[f];
  const Index size = fiber.dofs(), rows = unknowns * fiber.nodes;
  std::fill_n(turns, TurnBand::size(size), 0.0);
  for (Index i = 0; i < size; ++i)
    for (Index j = std::max<Index>(0, i - TurnBand::half_bandwidth);
         j <= std::min<Index>(size - 1, i + TurnBand::half_bandwidth); ++j)
      turns[TurnBand::entry(i, j)] =
          at(band, unknowns * (i / 6) + first_turn + i % 6, unknowns * (j / 6) + first_turn + j % 6);
  condensed_[f] = 1;
  if (!TurnBand::factorize(turns, &turn_pivot_[fiber.first_dof()], size)) {
    singular_[f] = equations.singular[f] = 1;
    return;
  }
  std::vector<double> y(&residual[fiber.first_dof()], &residual[fiber.first_dof()] + size);
  TurnBand::solve(turns, &turn_pivot_[fiber.first_dof()], size, y.data(), 1);
  for (Index i = 0; i < size; ++i) {
    const Index row = unknowns * (i / 6) + i % 6;
    double sum = 0.0;
    for (Index j = std::max<Index>(0, row - TriadBand::half_bandwidth);
         j <= std::min<Index>(rows - 1, row + TriadBand::half_bandwidth); ++j)
      if (j % unknowns >= first_turn) sum += at(band, row, j) * y[6 * (j / unknowns) + j % unknowns - first_turn];
    equations.residual[fiber.first_dof() + i] -= sum;
  }
}

void TriadField::solve(const FiberEquations& equations, Index f, double* b, Index columns) const {
  const Fiber& fiber = equations.fibers[f];
  const std::size_t width = static_cast<std::size_t>(columns), block = 6 * width;
  const std::size_t nodes = static_cast<std::size_t>(fiber.nodes);
  if (singular_[f]) {
    std::fill_n(b, nodes * block, std::numeric_limits<double>::quiet_NaN());
    return;
  }
  fiber.project(b, columns);
  std::vector<double> x(2 * nodes * block, 0.0);
  for (std::size_t n = 0; n < nodes; ++n) std::copy_n(b + n * block, block, &x[2 * n * block]);
  TriadBand::solve(band_.data() + band_begin_[f], &pivot_[2 * fiber.first_dof()], unknowns * fiber.nodes, x.data(),
                   columns);
  for (std::size_t n = 0; n < nodes; ++n) std::copy_n(&x[2 * n * block], block, b + n * block);
  fiber.project_increment(b, columns);
}

void TriadField::solve_all(const FiberEquations& equations, Index f, double* b, Index columns) const {
  const Fiber& fiber = equations.fibers[f];
  const std::size_t nodes = static_cast<std::size_t>(fiber.nodes), block = 6 * static_cast<std::size_t>(columns);
  if (singular_[f]) {
    std::fill_n(b, 2 * nodes * block, std::numeric_limits<double>::quiet_NaN());
    return;
  }
  fiber.project(b, columns);
  for (const NodeSupport& support : fiber.supports)
    if (is_held(fiber.first_node + support.node))
      std::fill_n(b + (nodes + static_cast<std::size_t>(support.node)) * block, block / 2, 0.0);
  std::vector<double> x(2 * nodes * block);
  for (std::size_t n = 0; n < nodes; ++n) {
    std::copy_n(b + n * block, block, &x[2 * n * block]);
    std::copy_n(b + (nodes + n) * block, block, &x[(2 * n + 1) * block]);
  }
  TriadBand::solve(band_.data() + band_begin_[f], &pivot_[2 * fiber.first_dof()], unknowns * fiber.nodes, x.data(),
                   columns);
  for (std::size_t n = 0; n < nodes; ++n) {
    std::copy_n(&x[2 * n * block], block, b + n * block);
    std::copy_n(&x[(2 * n + 1) * block], block, b + (nodes + n) * block);
  }
  fiber.project_increment(b, columns);
}

void TriadField::add_to_diagonal(const FiberEquations& equations, Index f, Index unknown, double value) {
  const Index size = equations.fibers[f].dofs(), i = unknown % size;
  const Index row = unknowns * (i / 6) + i % 6 + (unknown < size ? 0 : first_turn);
  at(tangent_.data() + band_begin_[f], row, row) += value;
}

std::vector<double> TriadField::turns(const FiberEquations& equations, Index f, const double* delta) const {
  const Fiber& fiber = equations.fibers[f];
  const Index size = fiber.dofs(), rows = unknowns * fiber.nodes;
  std::vector<double> y(static_cast<std::size_t>(size));
  if (singular_[f]) {
    std::fill(y.begin(), y.end(), std::numeric_limits<double>::quiet_NaN());
    return y;
  }
  const double* band = tangent_.data() + band_begin_[f];
  for (Index i = 0; i < size; ++i) {
    const Index row = unknowns * (i / 6) + first_turn + i % 6;
    double sum = residual[fiber.first_dof() + i];
    for (Index j = std::max<Index>(0, row - TriadBand::half_bandwidth);
         j <= std::min<Index>(rows - 1, row + TriadBand::half_bandwidth); ++j)
      if (j % unknowns < first_turn) sum += at(band, row, j) * delta[6 * (j / unknowns) + j % unknowns];
    y[i] = -sum;
  }
  TurnBand::solve(turn_band_.data() + turn_band_begin_[f], &turn_pivot_[fiber.first_dof()], size, y.data(), 1);
  return y;
}

void TriadField::add_turns(const FiberEquations& equations, Index f, const double* turns, double factor) {
  const Fiber& fiber = equations.fibers[f];
  condensed_[f] = 0;
  for (Index t = 0; t + 1 < 2 * fiber.nodes; ++t) {
    const std::size_t all = 2 * static_cast<std::size_t>(fiber.first_node) + static_cast<std::size_t>(t);
    if (held_[all] != 0) continue;
    Quaternion& q = triad[all];
    q = normalized(q * exponential(factor * Vec3(turns + 3 * t)));
  }
  update_rates(equations, f);
}

void TriadField::update_rates(const FiberEquations& equations, Index f) {
  const Fiber& fiber = equations.fibers[f];
  for (Index t = 0; t + 1 < 2 * fiber.nodes; ++t) {
    const std::size_t all = 2 * static_cast<std::size_t>(fiber.first_node) + static_cast<std::size_t>(t);
    set(turn, all, logarithm(triad_n[all].conjugate() * triad[all]));
    if (!equations.level.dynamic) continue;
    for (std::size_t i = 3 * all; i < 3 * all + 3; ++i) {
      spin[i] = equations.scheme.velocity(turn[i], spin_n[i], spin_rate_n[i], equations.level.dt);
      spin_rate[i] = equations.scheme.acceleration(turn[i], spin_n[i], spin_rate_n[i], equations.level.dt);
    }
  }
}

void TriadField::set_initial_spin(const FiberEquations& equations, Index f, const input::VectorExpression& given) {
  const Fiber& fiber = equations.fibers[f];
  const double spacing = 1e-3 * equations.shortest_element(fiber);
  for (Index e = 0; e + 1 < fiber.nodes; ++e) {
    const std::size_t node = static_cast<std::size_t>(fiber.first_node + e);
    const double length = equations.element_length(fiber)[e];
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t all = 2 * node + c;
      const std::array<double, 4> h = fem::hermite_first(static_cast<double>(c) - 1.0);
      Vec3 tangent = Vec3::Zero(), rate = Vec3::Zero(), x = Vec3::Zero();
      const std::array<double, 4> h0 = fem::hermite(static_cast<double>(c) - 1.0);
      for (std::size_t i = 0; i < 4; ++i) {
        const double weight = h[i] * (i % 2 == 0 ? 2 / length : 1.0);
        x += h0[i] * (i % 2 == 0 ? 1.0 : 0.5 * length) * Vec3(&equations.dofs_n[6 * node + 3 * i]);
        tangent += weight * Vec3(&equations.dofs_n[6 * node + 3 * i]);
        rate += weight * Vec3(&equations.velocity_n[6 * node + 3 * i]);
      }
      Vec3 omega = tangent.cross(rate) / tangent.squaredNorm();
      if (equations.mesh.is_joined(f)) {
        Mat3 gradient;
        for (int k = 0; k < 3; ++k) gradient.col(k) = derivative_along(given, x, Vec3::Unit(k), 0.0, spacing);
        const Vec3 curl(gradient(2, 1) - gradient(1, 2), gradient(0, 2) - gradient(2, 0),
                        gradient(1, 0) - gradient(0, 1));
        omega += 0.5 * curl.dot(tangent) / tangent.squaredNorm() * tangent;
      }
      set(spin_n, all, held_[all] != 0 ? Vec3(Vec3::Zero()) : Vec3(triad_n[all].conjugate() * omega));
      set(spin, all, three(spin_n, all));
    }
  }
}

void TriadField::initialize(const FiberEquations& equations, Index f) {
  const Fiber& fiber = equations.fibers[f];
  for (Index t = 0; t + 1 < 2 * fiber.nodes; ++t) {
    const std::size_t all = 2 * static_cast<std::size_t>(fiber.first_node) + static_cast<std::size_t>(t);
    set(moment_n, all, three(moment, all));
    set(external_n, all, three(external, all));
    const Vec3 inertia = share_[all] * section[f].rotary;
    set(spin_rate_n, all, -three(residual, all).cwiseQuotient(inertia));  // zero where held
    set(spin_rate, all, three(spin_rate_n, all));
  }
}

double TriadField::squared_residual(const FiberEquations& equations, Index f) const {
  const Fiber& fiber = equations.fibers[f];
  const double length = equations.shortest_element(fiber);
  double sum = 0.0;
  for (std::size_t i = fiber.first_dof(); i < fiber.first_dof() + static_cast<std::size_t>(fiber.dofs()); ++i)
    sum += residual[i] * residual[i] / (length * length);
  return sum;
}

double TriadField::internal_energy(const FiberEquations& equations, Index f) const {
  const Fiber& fiber = equations.fibers[f];
  double energy = 0.0;
  for (Index e = 0; e + 1 < fiber.nodes; ++e) {
    const std::size_t node = static_cast<std::size_t>(fiber.first_node + e);
    std::array<Quaternion, 3> triads;
    for (std::size_t c = 0; c < 3; ++c) triads[c] = exponential(three(rotation_n, 2 * node + c));
    energy += triad_energy(section[f], elements_[static_cast<std::size_t>(fiber.first_element + e)],
                           &equations.dofs_n[6 * node], triads);
  }
  return energy;
}

double TriadField::rotary_energy(const FiberEquations& equations, Index f) const {
  const Fiber& fiber = equations.fibers[f];
  double energy = 0.0;
  for (Index t = 0; t + 1 < 2 * fiber.nodes; ++t) {
    const std::size_t all = 2 * static_cast<std::size_t>(fiber.first_node) + static_cast<std::size_t>(t);
    const Vec3 omega = three(spin_n, all);
    energy += 0.5 * share_[all] * omega.dot(section[f].rotary.cwiseProduct(omega));
  }
  return energy;
}

double TriadField::moment_work(const FiberEquations& equations, Index f) const {
  const Fiber& fiber = equations.fibers[f];
  double work = 0.0;
  for (std::size_t i = fiber.first_dof(); i < fiber.first_dof() + static_cast<std::size_t>(fiber.dofs()); ++i)
    work += work_n[i];
  return work;
}

Vec3 TriadField::rotary_momentum(const FiberEquations& equations, Index f) const {
  const Fiber& fiber = equations.fibers[f];
  Vec3 momentum = Vec3::Zero();
  for (Index t = 0; t + 1 < 2 * fiber.nodes; ++t) {
    const std::size_t all = 2 * static_cast<std::size_t>(fiber.first_node) + static_cast<std::size_t>(t);
    momentum +=
        exponential(three(rotation_n, all)) * Vec3(share_[all] * section[f].rotary.cwiseProduct(three(spin_n, all)));
  }
  return momentum;
}

}  // namespace fbi::beam
