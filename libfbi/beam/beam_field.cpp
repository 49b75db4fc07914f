#include "beam/beam_field.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "base/counters.hpp"
#include "base/error.hpp"
#include "base/log.hpp"
#include "beam/fiber_equations.hpp"
#include "beam/joints.hpp"
#include "beam/newton.hpp"

namespace fbi::beam {
namespace {

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
            "initially straight fibers; use \"formulation\": \"simo_reissner\", which may be curved at rest",
            fibers.name[f].c_str(), node - fibers.first_node[f], node - fibers.first_node[f] + 1);
    }
  }
  return {};
}

// Text of the first fiber that begins along the axis that its section should have across it, or empty.
std::string check_direction(const mesh::FiberMesh& fibers, const std::vector<FiberParameters>& groups) {
  for (Index f = 0; f < fibers.fibers(); ++f) {
    const FiberParameters& group = groups[fibers.group[f]];
    const Vec3& direction = group.section.direction;
    if (group.formulation != Formulation::simo_reissner || direction.norm() == 0.0) continue;
    const Vec3 tangent(&fibers.tangent[3 * static_cast<std::size_t>(fibers.first_node[f])]);
    if (direction.normalized().cross(tangent.normalized()).norm() < 1e-6)
      return log::format(
          "fiber \"%s\" starts along its section.direction; give a direction across it: it is axis 2 of the section",
          fibers.name[f].c_str());
  }
  return {};
}

}  // namespace

struct BeamField::Implementation : FiberEquations {
  using FiberEquations::FiberEquations;
  std::unique_ptr<Joints> joints;  // null without joints on this rank
  bool joints_singular = false;
  bool linearized = false;  // residual and factors belong to the iterate

  void evaluate_with_joints() {
    evaluate_all(false);
    for (Index g = 0; joints != nullptr && g < joints->groups(); ++g) joints->add_forces(*this, g);
  }
  bool is_joined(Index f) const { return joints != nullptr && mesh.joined_group[f] >= 0; }
};

BeamField::BeamField(const mesh::FiberMesh& fibers, const std::vector<FiberParameters>& groups,
                     const BeamTimeParameters& time, const Vec3& gravity) {
  agree_on_error(fibers.comm, ExitCode::geometry, check_straight(fibers, groups));
  agree_on_error(fibers.comm, ExitCode::geometry, check_direction(fibers, groups));
  std::string error;
  try {
    implementation_ = std::make_unique<Implementation>(fibers, groups, time, gravity);
  } catch (const Error& refused) {
    error = refused.what();
  }
  agree_on_error(fibers.comm, ExitCode::geometry, error);
  if (!fibers.joined.empty()) implementation_->joints = std::make_unique<Joints>(*implementation_, error);
  agree_on_error(fibers.comm, ExitCode::usage, error);
}

BeamField::~BeamField() = default;

bool BeamField::is_fixed(Index fiber) const { return implementation_->fibers[fiber].formulation == nullptr; }
Index BeamField::moving_fibers() const { return implementation_->moving; }

void BeamField::initialize(const std::vector<double>& force) {
  Implementation& b = *implementation_;
  b.at_start = true;
  b.level = Level();
  if (b.triads != nullptr) b.triads->begin_step();
  b.set_initial_velocity();
  for (Index f = 0; f < b.mesh.fibers(); ++f)
    if (b.fibers[f].prescribed) b.begin_step(f);
  b.dofs_n = b.dofs;
  if (b.parameters.scheme == TimeScheme::static_) return;
  for (Index f = 0; f < b.mesh.fibers(); ++f) {
    const Fiber& fiber = b.fibers[f];
    if (fiber.formulation == nullptr) continue;
    b.balance_at_start(f, force.empty() ? nullptr : &force[fiber.first_dof()]);
  }
  std::string torn;
  if (b.joints != nullptr) torn = b.joints->balance_acceleration(b);
  agree_on_error(b.mesh.comm, ExitCode::usage, torn);
  b.dofs = b.dofs_n;
  b.velocity = b.velocity_n;
  b.acceleration = b.acceleration_n;
}

void BeamField::begin_step(double time, double dt) {
  Implementation& b = *implementation_;
  b.level = Level();
  b.level.time = time;
  const bool dynamic = b.parameters.scheme != TimeScheme::static_;
  if (dynamic && b.at_start && time < 1.5 * dt) {  // not after a restart
    b.start_moving_supports(dt);
    const std::string torn = b.joints != nullptr ? b.joints->start_moving_supports(b) : "";
    agree_on_error(b.mesh.comm, ExitCode::usage, torn);
  }
  b.evaluated = b.linearized = false;
  b.dofs = b.dofs_n;
  b.velocity = b.velocity_n;
  b.acceleration = b.acceleration_n;
  if (b.triads != nullptr) b.triads->begin_step();
  b.loads.evaluate(time, dynamic ? 1.0 : time, b.load_values);
  if (b.joints != nullptr) b.joints->begin_step(b);
  b.level.dynamic = dynamic;
  b.level.dt = dynamic ? dt : 0.0;
  if (!dynamic) {
    for (Index f = 0; f < b.mesh.fibers(); ++f) b.begin_step(f);
    return;
  }
  b.level.conserving = b.parameters.scheme == TimeScheme::midpoint;
  b.level.internal = 1 - b.scheme.alpha_f;
  b.level.previous = b.scheme.alpha_f;
  b.level.inertia = b.scheme.inertia_per_displacement(dt);
  for (Index f = 0; f < b.mesh.fibers(); ++f) {
    b.begin_step(f);
    if (!is_fixed(f) && !b.is_joined(f) && !b.batches->has(f)) predict(b, f);
  }
  predict_batches(b);
  for (Index g = 0; b.joints != nullptr && g < b.joints->groups(); ++g) predict_group(b, *b.joints, g);
}

double BeamField::velocity_per_displacement() const {
  const Implementation& b = *implementation_;
  return b.level.dynamic ? b.scheme.velocity_per_displacement(b.level.dt) : 0.0;
}

double BeamField::alpha_f() const {
  const Implementation& b = *implementation_;
  return b.parameters.scheme == TimeScheme::static_ ? 0.0 : b.scheme.alpha_f;
}

void BeamField::set_downhill(bool downhill) { implementation_->downhill = downhill; }

void BeamField::linearize() {
  Implementation& b = *implementation_;
  count_parts("fiber tangents", b.moving);
  b.evaluate_all(true);
  for (Index g = 0; b.joints != nullptr && g < b.joints->groups(); ++g) {
    b.joints->add_forces(b, g);
    b.joints->add_springs(b, g);
  }
  b.factorize_all();
  b.linearized = true;
  b.joints_singular = false;
  for (Index g = 0; b.joints != nullptr && g < b.joints->groups(); ++g)
    if (!b.joints->factorize(b, g)) b.joints_singular = true;
}

void BeamField::evaluate() {
  Implementation& b = *implementation_;
  // Residuals of triads and joints are condensed by tangents.
  if (b.triads != nullptr || b.joints != nullptr)
    linearize();
  else if (!b.evaluated)
    b.evaluate_all(false);
}

bool BeamField::is_linearized() const { return implementation_->linearized; }

const std::vector<double>& BeamField::residual() const { return implementation_->residual; }

double BeamField::force_scale() const {
  double largest = 0.0;
  for (const double scale : implementation_->scale) largest = std::fmax(largest, scale);
  return largest;
}

double BeamField::squared_moment_residual() const {
  const Implementation& b = *implementation_;
  double sum = 0.0;
  for (Index f = 0; f < b.mesh.fibers(); ++f)
    if (b.has_triads(f)) sum += b.triads->squared_residual(b, f);
  return sum;
}

double BeamField::round_off() const {
  double largest = 0.0;
  for (const double value : implementation_->round_off) largest = std::fmax(largest, value);
  return largest;
}

void BeamField::solve(Index fiber, double* b) const {
  if (is_fixed(fiber))
    std::fill_n(b, implementation_->fibers[fiber].dofs(), 0.0);
  else
    implementation_->solve(fiber, b, 1);
}

void BeamField::solve(std::vector<double>& b) {
  Implementation& all = *implementation_;
  all.batches->solve(b.data());
  for (Index f = 0; f < all.mesh.fibers(); ++f)
    if (!all.is_joined(f) && !all.batches->is_factorized(f)) solve(f, &b[all.fibers[f].first_dof()]);
  for (Index g = 0; all.joints != nullptr && g < all.joints->groups(); ++g) {
    std::vector<double> part = all.joints->gather(g, b);
    if (all.joints_singular)
      std::fill(part.begin(), part.end(), std::numeric_limits<double>::quiet_NaN());
    else
      all.joints->solve(all, g, part);
    all.joints->scatter(g, part, b);
  }
}

void BeamField::compliance_joined(Index group, const std::vector<const double*>& d, const std::vector<Index>& rows,
                                  RowMatrix& block) const {
  const Implementation& b = *implementation_;
  if (b.joints_singular) {
    block.setConstant(1, 1, std::numeric_limits<double>::quiet_NaN());
    return;
  }
  b.joints->compliance(b, group, d, rows, block);
}

double BeamField::squared_joint_residual() const {
  const Implementation& b = *implementation_;
  double sum = 0.0;
  for (Index g = 0; b.joints != nullptr && g < b.joints->groups(); ++g) sum += std::pow(b.joints->gap_force(b, g), 2);
  return sum;
}

void BeamField::remove_constrained(std::vector<double>& force) const {
  for (Index f = 0; f < implementation_->mesh.fibers(); ++f) {
    const Fiber& fiber = implementation_->fibers[f];
    if (fiber.formulation != nullptr)
      implementation_->project(f, &force[fiber.first_dof()]);
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
  implementation_->solve(fiber, x.data(), columns);
  for (Index r = 0; r < rows; ++r)
    for (Index i = 0; i < functions; ++i) {
      const double weight = d[static_cast<std::size_t>(r) * functions + i];
      if (weight != 0.0) block.middleRows(3 * r, 3) += weight * x.middleRows(3 * i, 3);
    }
}

void BeamField::compliances(const std::vector<const double*>& d, const std::vector<Index>& rows,
                            const std::function<void(Index, const Eigen::Ref<const RowMatrix>&)>& take) const {
  const Implementation& b = *implementation_;
  b.batches->compliance(d, rows, [&](Index f, const double* values) {
    take(f, Eigen::Map<const RowMatrix>(values, 3 * rows[f], 3 * rows[f]));
  });
  RowMatrix block;
  for (Index f = 0; f < b.mesh.fibers(); ++f) {
    if (is_fixed(f) || b.is_joined(f) || b.batches->is_factorized(f)) continue;
    compliance(f, d[f], rows[f], block);
    take(f, block);
  }
}

void BeamField::increment(const std::vector<double>& delta) {
  Implementation& b = *implementation_;
  b.evaluated = b.linearized = false;
  for (Index f = 0; f < b.mesh.fibers(); ++f) {
    const Fiber& fiber = b.fibers[f];
    if (fiber.formulation == nullptr) continue;
    if (b.has_triads(f) && b.is_joined(f)) {
      b.triads->add_turns(b, f, b.joints->turns(b, f), 1.0);
    } else if (b.has_triads(f)) {
      if (!b.triads->is_condensed(f)) {
        b.evaluate(f, true);
        b.factorize(f);
        b.condense(f);
      }
      const std::vector<double> turns = b.triads->turns(b, f, &delta[fiber.first_dof()]);
      b.triads->add_turns(b, f, turns.data(), 1.0);
    }
    b.add_increment(fiber, &delta[fiber.first_dof()], 1.0);
  }
  for (Index g = 0; b.joints != nullptr && g < b.joints->groups(); ++g) b.joints->advance(g, 1.0);
}

int BeamField::solve_step(const std::vector<double>& force) {
  Implementation& b = *implementation_;
  count_parts("fiber solves", b.moving);
  b.evaluated = b.linearized = false;
  int most = 0;
  bool failed = false;
  for (Index f = 0; f < b.mesh.fibers(); ++f) {
    if (is_fixed(f) || b.is_joined(f)) continue;
    const int iterations = solve_fiber(b, f, force);
    failed = failed || iterations < 0;
    most = std::max(most, iterations);
  }
  for (Index g = 0; b.joints != nullptr && g < b.joints->groups(); ++g) {
    const int iterations = solve_group(b, *b.joints, g, force);
    failed = failed || iterations < 0;
    most = std::max(most, iterations);
  }
  const GlobalIndex all = b.mesh.comm.max(static_cast<GlobalIndex>(failed ? -1 : most));
  return b.mesh.comm.any(failed) ? -1 : static_cast<int>(all);
}

void BeamField::accept_step() {
  Implementation& b = *implementation_;
  if (!b.evaluated) b.evaluate_with_joints();
  for (const Fiber& fiber : b.fibers) {
    if (fiber.formulation == nullptr) continue;
    const std::size_t first = fiber.first_dof();
    for (std::size_t i = first; i < first + static_cast<std::size_t>(fiber.dofs()); ++i)
      b.work_n[i] += 0.5 * (b.external_n[i] + b.external[i]) * (b.dofs[i] - b.dofs_n[i]);
  }
  b.accept_bodies_and_frames();
  b.at_start = false;
  b.dofs_n = b.dofs;
  b.velocity_n = b.velocity;
  b.acceleration_n = b.acceleration;
  b.internal_n = b.internal;
  b.external_n = b.external;
  if (b.triads != nullptr) b.triads->accept_step();
}

const std::vector<double>& BeamField::dofs() const { return implementation_->dofs; }
const std::vector<double>& BeamField::velocity() const { return implementation_->velocity; }
const std::vector<double>& BeamField::acceleration() const { return implementation_->acceleration; }
const std::vector<double>& BeamField::accepted_dofs() const { return implementation_->dofs_n; }
const std::vector<double>& BeamField::accepted_velocity() const { return implementation_->velocity_n; }
const std::vector<double>& BeamField::accepted_acceleration() const { return implementation_->acceleration_n; }

std::vector<double> BeamField::reactions(const std::vector<double>& force) const {
  Implementation& b = *implementation_;
  if (!b.evaluated) b.evaluate_with_joints();
  std::vector<double> reaction(b.full.size(), 0.0);
  for (const Fiber& fiber : b.fibers) {
    if (fiber.formulation == nullptr) continue;
    const Index f = static_cast<Index>(&fiber - b.fibers.data());
    if (b.is_rigid(f)) {
      b.rigid_reaction(f, force.empty() ? nullptr : &force[fiber.first_dof()], &reaction[fiber.first_dof()]);
      continue;
    }
    for (const NodeSupport& support : fiber.supports) {
      const std::size_t dof = fiber.first_dof() + 6 * static_cast<std::size_t>(support.node);
      double all[6], free[6];
      for (int k = 0; k < 6; ++k) all[k] = free[k] = b.full[dof + k] - (force.empty() ? 0.0 : force[dof + k]);
      support.constraint.project(free);
      for (int k = 0; k < 6; ++k) reaction[dof + k] = all[k] - free[k];
      if (!b.has_triads(f) || !b.triads->is_held(fiber.first_node + support.node)) continue;
      const Vec3 moment = b.triads->support_moment(fiber.first_node + support.node);
      for (int k = 0; k < 3; ++k) reaction[dof + 3 + k] += moment[k];
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
  for (Index f = 0; f < b.mesh.fibers(); ++f) {
    const Fiber& fiber = b.fibers[f];
    if (fiber.formulation == nullptr) continue;
    if (b.is_rigid(f)) energy.kinetic += b.rigid[f].kinetic_energy(b.rigid_state(f));
    if (b.has_triads(f)) {
      energy.internal += b.triads->internal_energy(b, f);
      energy.kinetic += b.triads->rotary_energy(b, f);
      energy.external_work += b.triads->moment_work(b, f);
    }
    ElementProperties element = fiber.section;
    for (Index e = 0; e + 1 < fiber.nodes && !b.is_rigid(f); ++e) {
      element.length = b.element_length(fiber)[e];
      const std::size_t dof = fiber.first_dof() + 6 * static_cast<std::size_t>(e);
      if (!b.has_triads(f)) energy.internal += fiber.formulation->energy(element, &b.dofs_n[dof]);
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
    if (fiber.formulation == nullptr || b.is_rigid(f)) continue;
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
  std::vector<std::pair<std::string, std::vector<double>*>> list = {{"dofs", &b.dofs_n},
                                                                    {"velocity", &b.velocity_n},
                                                                    {"acceleration", &b.acceleration_n},
                                                                    {"internal_force", &b.internal_n},
                                                                    {"external_force", &b.external_n},
                                                                    {"external_work", &b.work_n}};
  // By what there is in the case, not on this rank: the ranks write together.
  if (b.any_rigid) list.insert(list.end(), {{"rigid_pose", &b.pose_n}, {"rigid_motion", &b.motion_n}});
  if (b.loads.has_followers()) list.push_back({"load_frame", &b.frames.last});
  if (b.triads != nullptr) {
    list.insert(list.end(), {{"rotation", &b.triads->rotation_n},
                             {"spin", &b.triads->spin_n},
                             {"spin_rate", &b.triads->spin_rate_n},
                             {"moment", &b.triads->moment_n},
                             {"external_moment", &b.triads->external_n},
                             {"moment_work", &b.triads->work_n}});
  }
  return list;
}

}  // namespace fbi::beam
