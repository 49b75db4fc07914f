#include <algorithm>
#include <cmath>

#include "beam/joints.hpp"

namespace fbi::beam {
namespace {

constexpr double largest_tangent_change = 1.0;  // as for single fibers
constexpr double smallest_portion = 1.0 / 256;

bool is_finite(const std::vector<double>& x) {
  return std::all_of(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
}

struct GroupStep {
  FiberEquations& equations;
  Joints& joints;
  Index g;
  const std::vector<Index>& fibers;
  std::vector<double> force;  // shape=(dofs of the group), or empty
  double length;              // shortest element

  GroupStep(FiberEquations& e, Joints& j, Index group, const std::vector<double>& all_forces)
      : equations(e), joints(j), g(group), fibers(e.mesh.joined[group]), length(0.0) {
    if (!all_forces.empty()) force = joints.gather(g, all_forces);
    for (const Index f : fibers) {
      const double shortest = equations.shortest_element(equations.fibers[f]);
      length = length == 0.0 ? shortest : std::min(length, shortest);
    }
  }
  bool moves(Index f) const { return equations.fibers[f].formulation != nullptr; }

  // force - G_b at the iterate with the forces of the joints, supports projected out.
  std::vector<double> unbalanced(bool with_tangent) const {
    for (const Index f : fibers)
      if (moves(f)) equations.evaluate(f, with_tangent);
    joints.add_forces(equations, g);
    std::vector<double> b = joints.gather(g, equations.full);
    for (std::size_t i = 0; i < b.size(); ++i) b[i] = (force.empty() ? 0.0 : force[i]) - b[i];
    if (!is_finite(b)) return b;
    std::size_t offset = 0;
    for (const Index f : fibers) {
      const Fiber& fiber = equations.fibers[f];
      if (moves(f))
        fiber.project(&b[offset]);
      else
        std::fill_n(&b[offset], fiber.dofs(), 0.0);
      offset += static_cast<std::size_t>(fiber.dofs());
    }
    return b;
  }
  double largest_force(const std::vector<double>& b) const {
    double norm = 0.0;
    for (std::size_t i = 0; i < b.size(); ++i) norm = std::fmax(norm, std::abs(b[i]) / (i % 6 < 3 ? 1.0 : length));
    return norm;
  }
  double largest_length(const std::vector<double>& x) const {
    double norm = 0.0;
    for (std::size_t i = 0; i < x.size(); ++i) norm = std::fmax(norm, std::abs(x[i]) * (i % 6 < 3 ? 1.0 : length));
    return norm;
  }
  double sum_over(const std::vector<double>& of_fibers) const {
    double largest = 0.0;
    for (const Index f : fibers)
      if (moves(f)) largest = std::fmax(largest, of_fibers[f]);
    return largest;
  }
  void set(const std::vector<double>& dofs) const {
    std::size_t offset = 0;
    for (const Index f : fibers) {
      const Fiber& fiber = equations.fibers[f];
      if (moves(f)) {
        std::copy_n(&dofs[offset], fiber.dofs(), &equations.dofs[fiber.first_dof()]);
        equations.update_rates(fiber);
      }
      offset += static_cast<std::size_t>(fiber.dofs());
    }
  }
  bool factorize() const {
    joints.add_springs(equations, g);
    for (const Index f : fibers)
      if (moves(f) && !equations.factorize(f)) return false;
    return joints.factorize(equations, g);
  }
  void add(const std::vector<double>& delta, double factor) const {
    std::size_t offset = 0;
    for (const Index f : fibers) {
      if (moves(f)) equations.add_increment(equations.fibers[f], &delta[offset], factor);
      offset += static_cast<std::size_t>(equations.fibers[f].dofs());
    }
    joints.advance(g, factor);
  }
};

// Newton on force - G_b = share * held; `held` of shape=(dofs) or empty.
int newton(const GroupStep& step, const std::vector<double>& held, double share) {
  FiberEquations& equations = step.equations;
  const BeamTimeParameters& parameters = equations.parameters;
  const double applied = step.largest_force(step.force);
  for (int iteration = 0; iteration < parameters.max_iterations; ++iteration) {
    std::vector<double> delta = step.unbalanced(true);
    if (!is_finite(delta)) return -1;
    if (!held.empty())
      for (std::size_t i = 0; i < delta.size(); ++i) delta[i] -= share * held[i];
    const double scale = std::max(step.sum_over(equations.scale), applied);
    const double gap = step.joints.gap_force(equations, step.g);
    const double unbalanced = std::max(step.largest_force(delta), gap);
    if (unbalanced <= parameters.tolerance * scale) return iteration;
    const bool last = unbalanced <= step.sum_over(equations.round_off);
    if (!step.factorize()) return -1;
    step.joints.solve(equations, step.g, delta);
    if (!is_finite(delta)) return -1;
    double turn = 0.0;
    for (std::size_t i = 0; i < delta.size(); ++i)
      if (i % 6 >= 3) turn = std::fmax(turn, std::abs(delta[i]));
    const double factor = turn > largest_tangent_change ? largest_tangent_change / turn : 1.0;
    step.add(delta, factor);
    std::vector<double> change = step.joints.gather(step.g, equations.dofs);
    const std::vector<double> before = step.joints.gather(step.g, equations.dofs_n);
    for (std::size_t i = 0; i < change.size(); ++i) change[i] -= before[i];
    if (last || (factor == 1.0 && step.largest_length(delta) <= parameters.tolerance * step.largest_length(change)))
      return iteration + 1;
  }
  return -1;
}

// The residual at d_n removed in portions.
int in_portions(const GroupStep& step) {
  std::vector<double> last = step.joints.gather(step.g, step.equations.dofs_n);
  step.set(last);
  step.joints.begin_step(step.equations, step.g);
  std::shared_ptr<const Joints::State> last_joints = step.joints.state(step.g);
  const std::vector<double> held = step.unbalanced(false);
  if (!is_finite(held)) return -1;
  int all = 0;
  double removed = 0.0, portion = 0.5;
  while (removed < 1.0) {
    const double next = std::min(1.0, removed + portion);
    const int iterations = newton(step, held, 1.0 - next);
    if (iterations >= 0) {
      all += iterations;
      removed = next;
      last = step.joints.gather(step.g, step.equations.dofs);
      last_joints = step.joints.state(step.g);
      continue;
    }
    portion *= 0.5;
    if (portion < smallest_portion) return -1;
    step.set(last);
    step.joints.restore(step.g, *last_joints);
  }
  return all;
}

}  // namespace

void predict_group(FiberEquations& equations, Joints& joints, Index g) {
  const GroupStep step(equations, joints, g, {});
  std::vector<double> dofs = joints.gather(g, equations.dofs_n);
  step.set(dofs);
  const double standing = step.largest_force(step.unbalanced(false));
  const std::vector<double> velocity = joints.gather(g, equations.velocity_n), before = dofs;
  for (std::size_t i = 0; i < dofs.size(); ++i) dofs[i] += equations.level.dt * velocity[i];
  step.set(dofs);
  joints.fit(equations, g);
  if (std::isless(step.largest_force(step.unbalanced(false)), standing)) return;
  step.set(before);
  joints.fit(equations, g);
}

int solve_group(FiberEquations& equations, Joints& joints, Index g, const std::vector<double>& force) {
  const GroupStep step(equations, joints, g, force);
  const int iterations = newton(step, {}, 0.0);
  return iterations >= 0 ? iterations : in_portions(step);
}

}  // namespace fbi::beam
