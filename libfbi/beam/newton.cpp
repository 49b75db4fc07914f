#include "beam/newton.hpp"

#include "beam/newton_loop.hpp"

namespace fbi::beam {
namespace {

// One fiber and the force on it.
struct Step {
  FiberEquations& equations;
  Index f;
  const Fiber& fiber;
  std::size_t first, size;
  std::size_t unknowns;  // size, twice that with triads: their turns come after the center line
  double length;         // shortest element
  const double* force;   // shape=(size), or null
  double applied = 0.0;  // its largest entry

  struct Iterate {
    std::vector<double> dofs;
    std::vector<Quaternion> triads;
  };

  Step(FiberEquations& e, Index index, const std::vector<double>& all_forces)
      : equations(e),
        f(index),
        fiber(e.fibers[index]),
        first(fiber.first_dof()),
        size(static_cast<std::size_t>(fiber.dofs())),
        unknowns(static_cast<std::size_t>(e.unknowns(index))),
        length(e.shortest_element(fiber)),
        force(all_forces.empty() ? nullptr : &all_forces[first]) {
    EntrySizes sizes;
    if (force != nullptr) sizes.add(force, size, 0, length);
    applied = sizes.forces;
  }

  // force - G_b at the iterate, supports projected out.
  std::vector<double> unbalanced(bool with_tangent) const {
    equations.evaluate(f, with_tangent);
    std::vector<double> b(unknowns);
    for (std::size_t i = 0; i < size; ++i) b[i] = (force == nullptr ? 0.0 : force[i]) - equations.full[first + i];
    for (std::size_t i = size; i < unknowns; ++i) b[i] = -equations.triads->residual[first + i - size];
    if (is_finite(b)) equations.project(f, b.data());
    return b;
  }
  EntrySizes sizes_of(const std::vector<double>& x) const {
    EntrySizes sizes;
    sizes.add(x.data(), size, unknowns - size, length);
    return sizes;
  }
  double gap() const { return 0.0; }
  double scale() const { return std::max(equations.scale[f], applied); }
  double round_off() const { return equations.round_off[f]; }
  bool factorize() const { return equations.factorize(f); }
  void solve(std::vector<double>& b) const { equations.solve_all(f, b.data(), 1); }
  void add(const std::vector<double>& delta, double factor) const {
    if (unknowns > size) equations.triads->add_turns(equations, f, &delta[size], factor);
    equations.add_increment(fiber, delta.data(), factor);
  }
  std::vector<double> change() const {
    std::vector<double> x(unknowns);
    for (std::size_t i = 0; i < size; ++i) x[i] = equations.dofs[first + i] - equations.dofs_n[first + i];
    for (std::size_t i = size; i < unknowns; ++i) x[i] = equations.triads->turn[first + i - size];
    return x;
  }
  Iterate iterate() const {
    return {{&equations.dofs[first], &equations.dofs[first] + size}, triads_of(&TriadField::triad)};
  }
  void go_to(const Iterate& iterate) const {
    std::copy_n(iterate.dofs.begin(), size, &equations.dofs[first]);
    equations.update_rates(fiber);
    if (unknowns == size) return;
    std::copy(iterate.triads.begin(), iterate.triads.end(),
              equations.triads->triad.begin() + static_cast<std::ptrdiff_t>(first / 3));
    equations.triads->update_rates(equations, f);
  }
  void go_to_start() const {
    go_to({{&equations.dofs_n[first], &equations.dofs_n[first] + size}, triads_of(&TriadField::triad_n)});
  }
  std::vector<Quaternion> triads_of(const std::vector<Quaternion> TriadField::*field) const {
    if (unknowns == size) return {};
    const auto begin = ((*equations.triads).*field).begin() + static_cast<std::ptrdiff_t>(first / 3);
    return {begin, begin + static_cast<std::ptrdiff_t>(size / 3)};
  }
};

}  // namespace

void predict(FiberEquations& equations, Index f) {
  if (equations.is_rigid(f)) return;  // has its own
  const Step step(equations, f, {});
  const auto largest_residual = [&] {
    equations.update_rates(step.fiber);
    if (step.unknowns > step.size) equations.triads->update_rates(equations, f);
    return step.sizes_of(step.unbalanced(false)).forces;
  };
  const double standing = largest_residual();
  for (std::size_t i = step.first; i < step.first + step.size; ++i)
    equations.dofs[i] += equations.level.dt * equations.velocity_n[i];
  if (step.unknowns > step.size) equations.triads->predict(equations, f);
  if (std::isless(largest_residual(), standing)) return;
  step.go_to_start();
}

void predict_batches(FiberEquations& equations) {
  std::vector<Index> fibers;
  for (Index f = 0; f < equations.mesh.fibers(); ++f)
    if (equations.batches->has(f)) fibers.push_back(f);
  const auto largest_residuals = [&] {
    for (const Index f : fibers) equations.update_rates(equations.fibers[f]);
    equations.batches->evaluate(equations, false);
    std::vector<double> largest(fibers.size());
    for (std::size_t i = 0; i < fibers.size(); ++i) {
      const Fiber& fiber = equations.fibers[fibers[i]];
      EntrySizes sizes;
      sizes.add(&equations.residual[fiber.first_dof()], static_cast<std::size_t>(fiber.dofs()), 0,
                equations.shortest_element(fiber));
      largest[i] = sizes.forces;
    }
    return largest;
  };
  const std::vector<double> standing = largest_residuals();
  for (const Index f : fibers) {
    const Fiber& fiber = equations.fibers[f];
    for (std::size_t i = fiber.first_dof(); i < fiber.first_dof() + static_cast<std::size_t>(fiber.dofs()); ++i)
      equations.dofs[i] += equations.level.dt * equations.velocity_n[i];
  }
  const std::vector<double> moving = largest_residuals();
  for (std::size_t i = 0; i < fibers.size(); ++i)
    if (!std::isless(moving[i], standing[i])) Step(equations, fibers[i], {}).go_to_start();
}

int solve_fiber(FiberEquations& equations, Index fiber, const std::vector<double>& force) {
  const Step step(equations, fiber, force);
  const int iterations = newton(step, equations.parameters, {}, 0.0);
  return iterations >= 0 || equations.is_rigid(fiber) ? iterations : in_portions(step, equations.parameters);
}

}  // namespace fbi::beam
