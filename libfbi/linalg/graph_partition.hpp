/// Which rank gets which cell of a general mesh: the graph of neighboring cells, partitioned by PT-Scotch.
#pragma once

#include <optional>
#include <vector>

#include "mesh/hex_mesh.hpp"
#include "mesh/parameters.hpp"

namespace fbi::linalg {

/// Whether this build can partition graphs (PETSc with PT-Scotch).
bool has_graph_partition();

/// Rank of each cell of this rank's chunk, such that few faces lie between cells of different ranks (PT-Scotch,
/// Chevalier and Pellegrini 2008, through PETSc). The same chunks give the same answer in every call and every process:
/// PT-Scotch gets one thread and starts from the same random numbers. Nothing when there are fewer than eight cells a
/// rank, or when a rank would get no cell. Throws Error(usage) in a build without PT-Scotch. Collective.
std::optional<std::vector<int>> partition_by_graph(const Comm& comm, const mesh::HexMeshChunk& chunk);

/// mesh::distribute with the cells of a mesh that is no box placed as `partition` says; where a graph cannot be
/// partitioned (few cells) by bisection, with a warning. Collective.
mesh::HexMesh distribute(const Comm& comm, mesh::HexMeshChunk chunk, mesh::Partition partition);

}  // namespace fbi::linalg
