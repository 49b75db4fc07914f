/// Energies of the fields and powers of the interface, recorded in every row of the history.
#pragma once

#include <vector>

#include "fsi/system.hpp"
#include "io/history.hpp"

namespace fbi::cases {

/// Columns of what the case has: `energy:fluid_kinetic`; `energy:fiber_kinetic` and `energy:fiber_elastic`; of a
/// coupled case `power:fiber` (of the fluid's forces on the fibers) and `power:penalty`, what the slip dissipates:
/// sum_p lambda_p . (M v - D v_b)_p. The fluid loses their sum.
std::vector<io::HistoryColumn> energy_columns(const fsi::System& system);

/// Their values in the accepted state, the same on all ranks. Collective.
std::vector<double> energy_values(const fsi::System& system);

}  // namespace fbi::cases
