/// Brings the complete rows of M to the ranks of their fibers, for the factors of the preconditioner.
#pragma once

#include <vector>

#include "coupling/coupling.hpp"
#include "linalg/multiplier_rows.hpp"
#include "mesh/hex_mesh.hpp"

namespace fbi::coupling {

/// Complete rows of M of this rank's fibers together with the weight W of every velocity they touch; `weight` has
/// shape=(local fluid nodes,3) with ghosts up to date. Contributions are added in rank order. Collective.
/// @param sums  M^T 1 of all ranks, shape=(local fluid nodes) with ghosts up to date, for `others`; empty on one rank
linalg::MultiplierRows complete_rows(const mesh::HexMesh& fluid, const Coupling& coupling,
                                     const std::vector<double>& weight, const std::vector<double>& sums = {});

}  // namespace fbi::coupling
