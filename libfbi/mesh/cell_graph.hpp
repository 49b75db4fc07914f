/// Which cells of a mesh have a face in common.
#pragma once

#include <vector>

#include "mesh/hex_mesh.hpp"

namespace fbi::mesh {

/// Neighbors of the cells of this rank's chunk: those of the chunk's cell c are other[begin[c]] ... other[begin[c+1]),
/// by number in the file, ascending. Symmetric over all ranks, no cell is its own neighbor and none is listed twice;
/// the two sides of a periodic pair of faces are no neighbors.
struct CellGraph {
  std::vector<GlobalIndex> begin;  ///< shape=(cells+1)
  std::vector<GlobalIndex> other;
};

/// The graph of a mesh in chunks. Every face goes to the rank whose chunk has its lowest node, which joins its cells:
/// no rank holds more than its share. Collective.
CellGraph cell_graph(const Comm& comm, const HexMeshChunk& chunk);

}  // namespace fbi::mesh
