/// Checks of hexahedral meshes of any shape.
#pragma once

#include <string>
#include <vector>

#include "mesh/mesh_data.hpp"

namespace fbi::meshgen {

/// How good the cells of a mesh are.
struct Quality {
  double scaled_jacobian = 1.0;       ///< smallest over cells and corners of det(edges)/(product of their lengths)
  double smallest_edge = 0.0;         ///< [length]
  double largest_edge = 0.0;          ///< [length]
  double volume = 0.0;                ///< of all cells [length^3]
  std::vector<GlobalIndex> inverted;  ///< cells with a Jacobian that is not positive at some corner or Gauss point
};
Quality quality_of(const mesh::HexMeshData& mesh);

/// Mean of the corners of a cell, as text "(x, y, z)".
std::string place_of(const mesh::HexMeshData& mesh, GlobalIndex cell);

/// Turns cells that are left-handed as a whole (all Jacobians negative) over, xi-eta planes exchanged; returns how
/// many. Call it before faces are numbered.
GlobalIndex flip_left_handed(mesh::HexMeshData& mesh);

/// Nodes at the same place (nearer than 1e-7 of the smallest edge): pairs (lower, higher), ascending.
std::vector<std::array<GlobalIndex, 2>> coincident_nodes(const mesh::HexMeshData& mesh, double smallest_edge);

/// Number of parts that share no node, and a cell of each.
std::vector<GlobalIndex> connected_parts(const mesh::HexMeshData& mesh);

/// Faces that belong to one cell only, in the order of cells and faces; throws Error(geometry) when a face belongs to
/// more than two.
std::vector<mesh::Face> boundary_faces(const mesh::HexMeshData& mesh);

/// Renumbers nodes and cells (and faces) of a mesh that is an axis-aligned tensor-product box to the numbering of
/// mesh::Box and sets `box`; coordinates that differ by less than 1e-9 of the extent are taken as one. Returns false
/// and changes nothing when the mesh is not such a box.
bool recognise_box(mesh::HexMeshData& mesh);

}  // namespace fbi::meshgen
