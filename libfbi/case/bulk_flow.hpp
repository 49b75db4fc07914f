/// The mean velocity of the fluid, recorded in every row of the history.
#pragma once

#include <vector>

#include "fsi/system.hpp"
#include "io/history.hpp"

namespace fbi::cases {

/// Columns `mean:velocity_x` (_y, _z) of a case with fluid: the mean over its volume. Along a straight channel that is
/// the flow rate over the area of the section.
std::vector<io::HistoryColumn> bulk_flow_columns(const fsi::System& system);

/// Their values in the accepted state, the same on all ranks. Collective.
std::vector<double> bulk_flow_values(const fsi::System& system);

}  // namespace fbi::cases
