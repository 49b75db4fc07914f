/// Arrays of fibers: where they stand and what they are called.
#pragma once

#include "case/schema.hpp"
#include "mesh/mesh_data.hpp"

namespace fbi::meshgen {

/// Appends the fibers of one group to `fibers`: the curve, moved by (i, j, k)*spacing, i slowest. They are named
/// name/I/J..., zero-based, one index for each direction with more than one fiber; a single fiber has its bare name.
/// Throws Error(geometry) for a curve of zero length.
void add_group(const cases::FiberGroup& group, Index group_number, mesh::FiberMeshData& fibers);

}  // namespace fbi::meshgen
