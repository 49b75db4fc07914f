/// Steps in which only one of the two fields feels the other.
#pragma once

#include "fsi/system.hpp"

namespace fbi::fsi {

/// Direction fiber_only: the fluid as if there were no fibers, then the fibers held to it by the penalty, implicitly:
/// S lambda = M v_f - D v_b with S of the interface law. For a step whose begin_step was called. Collective.
StepReport solve_fiber_only(System& system);

/// Direction fluid_only: the fibers without any force of the fluid, then the fluid with their velocities given:
/// S lambda = M v_f - D v_b. For a step whose begin_step was called. Collective.
StepReport solve_fluid_only(System& system);

}  // namespace fbi::fsi
