#include "beam/newton.hpp"

#include <algorithm>
#include <cmath>

namespace fbi::beam {
namespace {

// Corrections that turn a tangent by more than this (radians, or stretch) are shortened: far from the solution the
// linearised rotation of a slender fiber is a stretch, and stiff.
constexpr double largest_tangent_change = 1.0;
constexpr double smallest_portion = 1.0 / 256;

// Largest entry of nodal forces, shape=(nodes,6); the generalised forces of the tangents count as forces on the arm
// `length`.
double largest_force(const double* x, std::size_t size, double length) {
  double norm = 0.0;
  for (std::size_t i = 0; i < size; ++i) norm = std::fmax(norm, std::abs(x[i]) / (i % 6 < 3 ? 1.0 : length));
  return norm;
}

// Largest entry of turns or moments of triads.
double largest_entry(const double* x, std::size_t size) {
  double norm = 0.0;
  for (std::size_t i = 0; i < size; ++i) norm = std::fmax(norm, std::abs(x[i]));
  return norm;
}

// Largest entry of nodal displacements; changes of tangents count as displacements at the distance `length`.
double largest_length(const double* x, std::size_t size, double length) {
  double norm = 0.0;
  for (std::size_t i = 0; i < size; ++i) norm = std::fmax(norm, std::abs(x[i]) * (i % 6 < 3 ? 1.0 : length));
  return norm;
}

bool is_finite(const std::vector<double>& x) {
  return std::all_of(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
}

// One fiber and the force on it.
struct Step {
  FiberEquations& equations;
  Index f;
  const Fiber& fiber;
  std::size_t first, size;
  std::size_t unknowns;  // size, twice that with triads: their turns come after the center line
  double length;         // shortest element
  const double* force;   // shape=(size), or null

  Step(FiberEquations& e, Index index, const std::vector<double>& all_forces)
      : equations(e),
        f(index),
        fiber(e.fibers[index]),
        first(fiber.first_dof()),
        size(static_cast<std::size_t>(fiber.dofs())),
        unknowns(e.has_triads(index) ? 2 * size : size),
        length(e.shortest_element(fiber)),
        force(all_forces.empty() ? nullptr : &all_forces[first]) {}

  // force - G_b at the iterate, supports projected out.
  std::vector<double> unbalanced(bool with_tangent) const {
    equations.evaluate(f, with_tangent);
    std::vector<double> b(unknowns);
    for (std::size_t i = 0; i < size; ++i) b[i] = (force == nullptr ? 0.0 : force[i]) - equations.full[first + i];
    for (std::size_t i = size; i < unknowns; ++i) b[i] = -equations.triads->residual[first + i - size];
    if (is_finite(b)) equations.project(f, b.data());
    return b;
  }
  double largest(const std::vector<double>& b) const {
    return std::fmax(largest_force(b.data(), size, length), largest_entry(&b[0] + size, unknowns - size) / length);
  }
  void solve(double* b) const {
    if (unknowns > size)
      equations.triads->solve_all(equations, f, b);
    else
      equations.solve(f, b, 1);
  }
  void add(const std::vector<double>& delta, double factor) const {
    if (unknowns > size) equations.triads->add_turns(equations, f, &delta[size], factor);
    equations.add_increment(fiber, delta.data(), factor);
  }
  void set(const std::vector<double>& dofs, const std::vector<Quaternion>& triads) const {
    std::copy_n(dofs.begin(), size, &equations.dofs[first]);
    equations.update_rates(fiber);
    if (unknowns == size) return;
    std::copy(triads.begin(), triads.end(), equations.triads->triad.begin() + static_cast<std::ptrdiff_t>(first / 3));
    equations.triads->update_rates(equations, f);
  }
  std::vector<double> iterate() const { return {&equations.dofs[first], &equations.dofs[first] + size}; }
  std::vector<Quaternion> triads_of(const std::vector<Quaternion> TriadField::*field) const {
    if (unknowns == size) return {};
    const auto begin = ((*equations.triads).*field).begin() + static_cast<std::ptrdiff_t>(first / 3);
    return {begin, begin + static_cast<std::ptrdiff_t>(size / 3)};
  }
};

// Newton on force - G_b = share * held; `held` of shape=(size) or empty.
int newton(const Step& step, const std::vector<double>& held, double share) {
  FiberEquations& equations = step.equations;
  const BeamTimeParameters& parameters = equations.parameters;
  const std::size_t size = step.size, unknowns = step.unknowns;
  const double applied = step.force == nullptr ? 0.0 : largest_force(step.force, size, step.length);
  std::vector<double> change(unknowns);
  for (int iteration = 0; iteration < parameters.max_iterations; ++iteration) {
    std::vector<double> delta = step.unbalanced(true);
    if (!is_finite(delta)) return -1;
    if (!held.empty())
      for (std::size_t i = 0; i < unknowns; ++i) delta[i] -= share * held[i];
    const double scale = std::max(equations.scale[step.f], applied);
    const double unbalanced = step.largest(delta);
    if (unbalanced <= parameters.tolerance * scale) return iteration;
    // round-off of the large axial forces hides what is left of the small bending forces: one more correction
    const bool last = unbalanced <= equations.round_off[step.f];
    if (!equations.factorize(step.f)) return -1;
    step.solve(delta.data());
    if (!is_finite(delta)) return -1;
    double turn = 0.0;
    for (std::size_t i = 0; i < unknowns; ++i)
      if (i % 6 >= 3 || i >= size) turn = std::fmax(turn, std::abs(delta[i]));
    const double factor = turn > largest_tangent_change ? largest_tangent_change / turn : 1.0;
    step.add(delta, factor);
    for (std::size_t i = 0; i < size; ++i)
      change[i] = equations.dofs[step.first + i] - equations.dofs_n[step.first + i];
    for (std::size_t i = size; i < unknowns; ++i) change[i] = equations.triads->turn[step.first + i - size];
    const auto length_of = [&](const std::vector<double>& x) {
      return std::fmax(largest_length(x.data(), size, step.length),
                       largest_entry(x.data() + size, unknowns - size) * step.length);
    };
    if (last || (factor == 1.0 && length_of(delta) <= parameters.tolerance * length_of(change))) return iteration + 1;
  }
  return -1;
}

// The residual at d_n removed in portions.
int in_portions(const Step& step) {
  std::vector<double> last(&step.equations.dofs_n[step.first], &step.equations.dofs_n[step.first] + step.size);
  std::vector<Quaternion> last_triads = step.triads_of(&TriadField::triad_n);
  step.set(last, last_triads);
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
      last = step.iterate();
      last_triads = step.triads_of(&TriadField::triad);
      continue;
    }
    portion *= 0.5;
    if (portion < smallest_portion) return -1;
    step.set(last, last_triads);
  }
  return all;
}

}  // namespace

void predict(FiberEquations& equations, Index f) {
  if (equations.is_rigid(f)) return;  // has its own
  const Step step(equations, f, {});
  const auto largest_residual = [&] {
    equations.update_rates(step.fiber);
    if (step.unknowns > step.size) equations.triads->update_rates(equations, f);
    return step.largest(step.unbalanced(false));
  };
  const double standing = largest_residual();
  for (std::size_t i = step.first; i < step.first + step.size; ++i)
    equations.dofs[i] += equations.level.dt * equations.velocity_n[i];
  if (step.unknowns > step.size) equations.triads->predict(equations, f);
  if (std::isless(largest_residual(), standing)) return;
  step.set({&equations.dofs_n[step.first], &equations.dofs_n[step.first] + step.size},
           step.triads_of(&TriadField::triad_n));
}

int solve_fiber(FiberEquations& equations, Index fiber, const std::vector<double>& force) {
  const Step step(equations, fiber, force);
  const int iterations = newton(step, {}, 0.0);
  return iterations >= 0 || equations.is_rigid(fiber) ? iterations : in_portions(step);
}

}  // namespace fbi::beam
