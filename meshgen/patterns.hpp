/// Arrays of fibers: where they stand and what they are called.
#pragma once

#include <string>
#include <vector>

#include "case/schema.hpp"
#include "mesh/mesh_data.hpp"

namespace fbi::meshgen {

/// Appends the fibers of one group to `fibers`: the curve, moved by (i, j, k)*spacing, i slowest. They are named
/// name/I/J..., zero-based, one index for each direction with more than one fiber; a single fiber has its bare name.
/// Nodes stand at equal distances along the curve with its unit tangents. Throws Error(geometry) for a curve that is
/// none (of zero length, with a kink); a fiber that is coarse for its curve or closed is a line in `warnings`.
void add_group(const cases::FiberGroup& group, Index group_number, mesh::FiberMeshData& fibers,
               std::vector<std::string>& warnings);

}  // namespace fbi::meshgen
