/// Stopping a run from outside: SIGTERM and SIGINT are remembered, the time loop asks.
#pragma once

namespace fbi {

/// From now on SIGTERM and SIGINT set a flag instead of ending the process (a second SIGINT ends it), and exceeding the
/// file-size limit is an error of the write instead of a signal.
void catch_signals();
/// The signal that arrived on this rank, or 0.
int caught_signal();

}  // namespace fbi
