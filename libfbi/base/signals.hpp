/// Stopping a run from outside: SIGTERM, SIGINT and SIGUSR1 are remembered, the time loop asks.
#pragma once

namespace fbi {

/// From now on SIGTERM, SIGINT and SIGUSR1 set a flag instead of ending the process (a second SIGINT ends it), and
/// exceeding the file-size limit is an error of the write instead of a signal. SIGUSR1 is for runs under mpirun, which
/// passes it on at once, but kills its processes a moment after it got one of the others.
void catch_signals();
/// The signal that arrived on this rank, or 0.
int caught_signal();
/// "SIGTERM" etc.
const char* signal_name(int signal);

}  // namespace fbi
