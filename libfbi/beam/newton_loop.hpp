/// Newton's method for one fiber or for a group of joined fibers, and the way around where it fails.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "beam/parameters.hpp"

namespace fbi::beam {

/// Corrections that turn a tangent by more than this (radians, or stretch) are shortened: far from the solution the
/// linearised rotation of a slender fiber is a stretch, and stiff.
inline constexpr double largest_tangent_change = 1.0;
/// Where portions of the residual become smaller than this, the step has failed.
inline constexpr double smallest_portion = 1.0 / 256;

/// What largest entries of a vector count for: nodal forces or displacements with tangent parts on an arm, and turns.
struct EntrySizes {
  double forces = 0.0, lengths = 0.0, turn = 0.0;
  /// Adds the center line of a fiber, shape=(dofs), and its triads, shape=(turns), with element length `length`.
  void add(const double* x, std::size_t dofs, std::size_t turns, double length) {
    for (std::size_t i = 0; i < dofs + turns; ++i) {
      const double entry = std::abs(x[i]);
      const bool is_position = i < dofs && i % 6 < 3;
      forces = std::fmax(forces, is_position ? entry : entry / length);
      lengths = std::fmax(lengths, is_position ? entry : entry * length);
      if (!is_position) turn = std::fmax(turn, entry);
    }
  }
};

inline bool is_finite(const std::vector<double>& x) {
  return std::all_of(x.begin(), x.end(), [](double value) { return std::isfinite(value); });
}

/// Newton on force - G = share * held; `held` is a vector of unknowns or empty. Returns the number of iterations, or
/// -1.
///
/// `step` gives: unbalanced(with_tangent) = force - G at the iterate, gap() of constraints as a force, scale() of
/// forces, round_off() in them, factorize(), solve(b), add(delta, factor), change() since t_n, sizes_of(x).
template <class Step>
int newton(Step& step, const BeamTimeParameters& parameters, const std::vector<double>& held, double share) {
  for (int iteration = 0; iteration < parameters.max_iterations; ++iteration) {
    std::vector<double> delta = step.unbalanced(true);
    if (!is_finite(delta)) return -1;
    if (!held.empty())
      for (std::size_t i = 0; i < delta.size(); ++i) delta[i] -= share * held[i];
    const double unbalanced = std::max(step.sizes_of(delta).forces, step.gap());
    if (unbalanced <= parameters.tolerance * step.scale()) return iteration;
    // round-off of the large axial forces hides what is left of the small bending forces: one more correction
    const bool last = unbalanced <= step.round_off();
    if (!step.factorize()) return -1;
    step.solve(delta);
    if (!is_finite(delta)) return -1;
    const EntrySizes correction = step.sizes_of(delta);
    const double factor = correction.turn > largest_tangent_change ? largest_tangent_change / correction.turn : 1.0;
    step.add(delta, factor);
    if (last || (factor == 1.0 && correction.lengths <= parameters.tolerance * step.sizes_of(step.change()).lengths))
      return iteration + 1;
  }
  return -1;
}

/// The residual at d_n removed in portions. `step` also gives: go_to_start(), iterate() and go_to(iterate).
template <class Step>
int in_portions(Step& step, const BeamTimeParameters& parameters) {
  step.go_to_start();
  auto last = step.iterate();
  const std::vector<double> held = step.unbalanced(false);
  if (!is_finite(held)) return -1;
  int all = 0;
  double removed = 0.0, portion = 0.5;
  while (removed < 1.0) {
    const double next = std::min(1.0, removed + portion);
    const int iterations = newton(step, parameters, held, 1.0 - next);
    if (iterations >= 0) {
      all += iterations;
      removed = next;
      last = step.iterate();
      continue;
    }
    portion *= 0.5;
    if (portion < smallest_portion) return -1;
    step.go_to(last);
  }
  return all;
}

}  // namespace fbi::beam
