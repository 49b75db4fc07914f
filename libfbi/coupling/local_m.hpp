/// Assembly of the part of M that belongs to the cells of this rank.
#pragma once

#include "coupling/coupling.hpp"
#include "coupling/cutting.hpp"

namespace fbi::coupling {

/// Integrates M over `pieces`, which are sorted by (row, begin): the sums run in that order, whatever the order of
/// arrival. Returns the number of pieces that could not be projected into their cells (0 unless a cell is inverted).
Index assemble_m(const mesh::HexMesh& mesh, const Pieces& pieces, const fem::QuadratureRule& rule, LocalM& m);

}  // namespace fbi::coupling
