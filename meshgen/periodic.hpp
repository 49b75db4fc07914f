/// Pairs of nodes on periodic faces.
#pragma once

#include <map>
#include <string>

#include "mesh/mesh_data.hpp"

namespace fbi::meshgen {

/// Sets mesh.periodic from pairs of face sets: each node of a set is matched with the node of its partner that lies
/// where the translation between the boxes around both sets takes it (within 1e-4 of the smallest edge). Nodes of two
/// or three pairs (edges and corners) get one master, the lowest node they are connected to.
///
/// @param partner  the other set, by name; each pair in both directions
/// Throws Error(geometry) with the sets and nodes that do not match and what to do, all pairs at once.
void match_periodic(const std::map<std::string, std::string>& partner, mesh::HexMeshData& mesh);

}  // namespace fbi::meshgen
