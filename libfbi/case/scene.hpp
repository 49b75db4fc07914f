/// What a case is before it runs: sizes, dimensionless numbers, cost, and what will be skipped.
#pragma once

#include <string>

#include "case/memory_need.hpp"
#include "case/setup.hpp"

namespace fbi::cases {

/// Numbers that --dry-run prints.
struct Scene {
  GlobalIndex fluid_nodes = 0, fluid_dofs = 0, fibers = 0, fiber_dofs = 0, multiplier_dofs = 0;
  double smallest_cell = 0.0;        ///< [length]
  double largest_radius = 0.0;       ///< of the fibers [length]
  double speed = 0.0;                ///< largest prescribed or initial fluid speed over the run [length/time]
  double start_speed = 0.0;          ///< largest prescribed speed on the boundary at t = 0 [length/time]
  double speed_change = 0.0;         ///< largest change of a prescribed velocity in one step [length/time]
  double height = 0.0;               ///< smallest extent of the channel [length]
  double fiber_length = 0.0;         ///< of the longest fiber [length]
  double stiffness = 0.0;            ///< smallest EI of a moving fiber [force length^2]
  double highest_frequency = 0.0;    ///< of a fiber element [1/time]
  bool direct = false;               ///< linear systems are factorised
  MemoryNeed memory;                 ///< for all ranks together
  double disk_per_output = 0.0;      ///< [bytes]
  double disk_per_checkpoint = 0.0;  ///< [bytes]
  GlobalIndex outputs = 0;           ///< field outputs of the whole run, with the first
};

/// Collective.
Scene inspect(const Setup& setup);

/// Prints the scene: sizes, h against fiber diameter, CFL, beam mode against dt, Cauchy and Reynolds numbers, memory,
/// disk.
void print_scene(const Scene& scene, const Setup& setup);

/// One line for each thing this scene does not need.
void print_skipped(const CaseParameters& parameters, const fsi::System& system, bool box, bool direct);

}  // namespace fbi::cases
