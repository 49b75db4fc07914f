/// How much memory the machine of this process has left.
#pragma once

#include <string>

#include "base/comm.hpp"

namespace fbi {

/// Memory that this process can still take [bytes]: MemAvailable of the system, or what the control groups of the
/// process leave of their limits (v2 and v1, with the file cache that would be given back) where that is less. Infinite
/// where the system does not tell. `root` stands before the paths of /proc and /sys, for tests.
double available_memory(const std::string& root = "");

/// Resident memory of this process now [bytes].
double resident_memory();

/// What a run that will need `need` bytes on each rank takes of the memory that the ranks on one machine have together,
/// those they hold already included: the largest ratio of all machines. `available`, when not negative, stands in for
/// what each machine has left. Collective.
struct MemoryShare {
  double need = 0.0;       ///< of the ranks on the fullest machine [bytes]
  double available = 0.0;  ///< there, with what they hold [bytes]
  bool fits() const { return need <= available; }
};
MemoryShare memory_share(const Comm& comm, double need, double available = -1.0);

}  // namespace fbi
