#include <algorithm>
#include <cmath>

#include "beam/joints.hpp"
#include "beam/newton_loop.hpp"

namespace fbi::beam {
namespace {

// A group of joined fibers and the forces on them.
struct GroupStep {
  FiberEquations& equations;
  Joints& joints;
  Index g;
  const std::vector<Index>& fibers;
  const std::vector<Index>& first;  // unknown of each fiber
  std::vector<double> force;        // on all unknowns, or empty
  double length = 0.0;              // shortest element
  double applied = 0.0;             // largest entry of the force

  struct Iterate {
    std::vector<double> dofs;
    std::vector<Quaternion> triads;  // two a node, of fibers that have them
    std::shared_ptr<const Joints::State> joints;
  };

  GroupStep(FiberEquations& e, Joints& j, Index group, const std::vector<double>& all_forces)
      : equations(e), joints(j), g(group), fibers(e.mesh.joined[group]), first(j.first_unknowns(group)) {
    for (const Index f : fibers) {
      const double shortest = equations.shortest_element(equations.fibers[f]);
      length = length == 0.0 ? shortest : std::min(length, shortest);
    }
    if (all_forces.empty()) return;
    force.assign(first.back(), 0.0);
    for (std::size_t i = 0; i < fibers.size(); ++i)
      std::copy_n(&all_forces[equations.fibers[fibers[i]].first_dof()], equations.fibers[fibers[i]].dofs(),
                  &force[first[i]]);
    applied = sizes_of(force).forces;
  }
  bool moves(Index f) const { return equations.fibers[f].formulation != nullptr; }

  // force - G_b at the iterate with the forces of the joints, supports projected out.
  std::vector<double> unbalanced(bool with_tangent) const {
    for (const Index f : fibers)
      if (moves(f)) equations.evaluate(f, with_tangent);
    joints.add_forces(equations, g);
    std::vector<double> b = force;
    b.resize(first.back(), 0.0);
    for (std::size_t i = 0; i < fibers.size(); ++i) {
      const Fiber& fiber = equations.fibers[fibers[i]];
      const Index dofs = fiber.dofs();
      double* part = &b[first[i]];
      if (!moves(fibers[i])) {
        std::fill_n(part, dofs, 0.0);
        continue;
      }
      for (Index k = 0; k < dofs; ++k) part[k] -= equations.full[fiber.first_dof() + k];
      for (Index k = dofs; k < first[i + 1] - first[i]; ++k)
        part[k] -= equations.triads->residual[fiber.first_dof() + k - dofs];
    }
    if (!is_finite(b)) return b;
    for (std::size_t i = 0; i < fibers.size(); ++i)
      if (moves(fibers[i])) equations.fibers[fibers[i]].project(&b[first[i]]);
    return b;
  }
  EntrySizes sizes_of(const std::vector<double>& x) const {
    EntrySizes sizes;
    for (std::size_t i = 0; i < fibers.size(); ++i) {
      const std::size_t dofs = static_cast<std::size_t>(equations.fibers[fibers[i]].dofs());
      sizes.add(&x[first[i]], dofs, static_cast<std::size_t>(first[i + 1] - first[i]) - dofs, length);
    }
    return sizes;
  }
  double largest_of(const std::vector<double>& of_fibers) const {
    double largest = 0.0;
    for (const Index f : fibers)
      if (moves(f)) largest = std::fmax(largest, of_fibers[f]);
    return largest;
  }
  double gap() const { return joints.gap_force(equations, g); }
  double scale() const { return std::max(largest_of(equations.scale), applied); }
  double round_off() const { return largest_of(equations.round_off); }
  bool factorize() const {
    joints.add_springs(equations, g);
    for (const Index f : fibers)
      if (moves(f) && !equations.factorize(f)) return false;
    return joints.factorize(equations, g);
  }
  void solve(std::vector<double>& b) const { joints.solve_all(equations, g, b); }
  void add(const std::vector<double>& delta, double factor) const {
    for (std::size_t i = 0; i < fibers.size(); ++i) {
      const Fiber& fiber = equations.fibers[fibers[i]];
      if (!moves(fibers[i])) continue;
      if (equations.has_triads(fibers[i]))
        equations.triads->add_turns(equations, fibers[i], &delta[first[i] + fiber.dofs()], factor);
      equations.add_increment(fiber, &delta[first[i]], factor);
    }
    joints.advance(g, factor);
  }
  std::vector<double> change() const {
    std::vector<double> x(first.back(), 0.0);
    for (std::size_t i = 0; i < fibers.size(); ++i) {
      const Fiber& fiber = equations.fibers[fibers[i]];
      for (Index k = 0; k < fiber.dofs(); ++k)
        x[first[i] + k] = equations.dofs[fiber.first_dof() + k] - equations.dofs_n[fiber.first_dof() + k];
      if (equations.has_triads(fibers[i]))
        std::copy_n(&equations.triads->turn[fiber.first_dof()], fiber.dofs(), &x[first[i] + fiber.dofs()]);
    }
    return x;
  }
  std::vector<Quaternion> triads_of(const std::vector<Quaternion> TriadField::*field) const {
    std::vector<Quaternion> all;
    for (const Index f : fibers) {
      if (!equations.has_triads(f)) continue;
      const auto begin = ((*equations.triads).*field).begin() + 2 * equations.fibers[f].first_node;
      all.insert(all.end(), begin, begin + 2 * equations.fibers[f].nodes);
    }
    return all;
  }
  void place(const std::vector<double>& dofs, const std::vector<Quaternion>& triads) const {
    std::size_t offset = 0;
    auto triad = triads.begin();
    for (const Index f : fibers) {
      const Fiber& fiber = equations.fibers[f];
      if (moves(f)) {
        std::copy_n(&dofs[offset], fiber.dofs(), &equations.dofs[fiber.first_dof()]);
        equations.update_rates(fiber);
      }
      if (equations.has_triads(f)) {
        std::copy_n(triad, 2 * fiber.nodes, equations.triads->triad.begin() + 2 * fiber.first_node);
        triad += 2 * fiber.nodes;
        equations.triads->update_rates(equations, f);
      }
      offset += static_cast<std::size_t>(fiber.dofs());
    }
  }
  Iterate iterate() const { return {joints.gather(g, equations.dofs), triads_of(&TriadField::triad), joints.state(g)}; }
  void go_to(const Iterate& iterate) const {
    place(iterate.dofs, iterate.triads);
    joints.restore(g, *iterate.joints);
  }
  void go_to_start() const {
    place(joints.gather(g, equations.dofs_n), triads_of(&TriadField::triad_n));
    joints.begin_step(equations, g);
  }
};

}  // namespace

void predict_group(FiberEquations& equations, Joints& joints, Index g) {
  const GroupStep step(equations, joints, g, {});
  const std::vector<double> before = joints.gather(g, equations.dofs_n),
                            velocity = joints.gather(g, equations.velocity_n);
  const std::vector<Quaternion> triads = step.triads_of(&TriadField::triad_n);
  step.place(before, triads);
  const double standing = step.sizes_of(step.unbalanced(false)).forces;
  std::vector<double> dofs = before;
  for (std::size_t i = 0; i < dofs.size(); ++i) dofs[i] += equations.level.dt * velocity[i];
  step.place(dofs, triads);
  for (const Index f : step.fibers)
    if (equations.has_triads(f)) equations.triads->predict(equations, f);
  joints.fit(equations, g);
  if (std::isless(step.sizes_of(step.unbalanced(false)).forces, standing)) return;
  step.place(before, triads);
  joints.fit(equations, g);
}

int solve_group(FiberEquations& equations, Joints& joints, Index g, const std::vector<double>& force) {
  const GroupStep step(equations, joints, g, force);
  const int iterations = newton(step, equations.parameters, {}, 0.0);
  return iterations >= 0 ? iterations : in_portions(step, equations.parameters);
}

}  // namespace fbi::beam
