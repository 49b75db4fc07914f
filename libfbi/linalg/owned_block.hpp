/// Which nodes of a tensor-product box this rank owns.
#pragma once

#include <array>

#include "linalg/block_exchange.hpp"
#include "mesh/hex_mesh.hpp"

namespace fbi::linalg {

/// Nodes of the box along each direction.
std::array<Index, 3> box_nodes(const mesh::HexMesh& mesh);

/// Smallest range of node indices along each direction that holds this rank's owned nodes. They fill it where its size
/// is mesh.owned_nodes; local numbers run along x first then, and along z last.
IndexBlock owned_range(const mesh::HexMesh& mesh);

}  // namespace fbi::linalg
