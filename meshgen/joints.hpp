/// Joints: from names and places of a case to node numbers.
#pragma once

#include <vector>

#include "mesh/mesh_data.hpp"
#include "mesh/parameters.hpp"

namespace fbi::meshgen {

/// Fills joints, first_joint, body and anchor of `fibers`; nothing without joints. Throws Error(usage) for unknown
/// names and Error(geometry) for places without a node, nodes that lie apart and "touching" that joins nothing, all at
/// once.
void add_joints(const std::vector<mesh::JointParameters>& joints, mesh::FiberMeshData& fibers);

}  // namespace fbi::meshgen
