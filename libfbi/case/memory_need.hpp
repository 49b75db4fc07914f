/// How much memory a run will take: an estimate from the sizes of the case, before anything large is allocated.
#pragma once

#include <string>

#include "case/setup.hpp"

namespace fbi::cases {

/// Estimates for all ranks together [bytes]; within a third of what was measured (docs/performance.md).
struct MemoryNeed {
  double programs = 0.0;  ///< code, libraries and MPI buffers of the ranks
  double fluid = 0.0;     ///< mesh, fields, Krylov directions, preconditioner
  double fibers = 0.0;    ///< fibers and multipliers
  double factors = 0.0;   ///< assembled matrices and their factors; 0 with the iterative solver
  double total() const { return programs + fluid + fibers + factors; }
};

/// `direct`: the fluid is solved with sparse factors. Collective.
MemoryNeed memory_need(const Setup& setup, bool direct);

/// Whether linear systems are factorised, as the solver chooses it.
bool is_solved_directly(const Setup& setup);

/// A warning where the case needs more than the machines of its ranks have, with what to do; else empty. `available`,
/// when not negative, stands in for what each machine has left [bytes]. The same on every rank. Collective.
std::string memory_warning(const Setup& setup, const MemoryNeed& need, double available = -1.0);

}  // namespace fbi::cases
