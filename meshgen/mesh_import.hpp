/// From the content of a mesh file to a mesh that can be computed on.
#pragma once

#include <string>
#include <vector>

#include "mesh/mesh_data.hpp"
#include "meshgen/gmsh_mesh.hpp"

namespace fbi::meshgen {

/// Checks a file's mesh and numbers it anew: nodes in the order of their tags, cells in the order of theirs; nodes of
/// no cell are dropped, left-handed cells turned over. A tensor-product box is recognised and gets its own numbering.
///
/// Throws Error(geometry) with all that is wrong, one a line: elements that are no hexahedra with 8 nodes, no face
/// sets, faces of no or of two sets, cells with a Jacobian that is not positive, coincident nodes, separate parts. What
/// was mended is appended to `warnings`.
/// @param scale   factor for the coordinates
mesh::HexMeshData import_mesh(const FileMesh& file, double scale, std::vector<std::string>& warnings);

/// Throws Error(usage) when the face sets of a mesh and the names that have a boundary condition are not the same, with
/// the nearest name.
void check_boundary_names(const mesh::HexMeshData& mesh, const std::vector<std::string>& names);

}  // namespace fbi::meshgen
