/// A channel with a circular cylinder across it.
#pragma once

#include "mesh/mesh_data.hpp"
#include "mesh/parameters.hpp"

namespace fbi::meshgen {

/// Half width of the square block of rings: what is given, or three radii but no more than 3/4 of the way to the
/// nearest wall [length].
double block_half_width(const mesh::BoxParameters& box, const mesh::CylinderParameters& cylinder);

/// Mesh of the channel box.origin, box.size without the cylinder; face sets xmin ... zmax and cylinder.
///
/// The section is a lattice with a square hole of half width b, filled by rings: node j of ring k lies on the straight
/// line from the circle (equal angles) to the side of the square (equal lengths), at a share that grows geometrically
/// from cells of thickness first * (length along the circle) to square cells at the block. The nodes at the cylinder
/// lie on the circle to round-off. The lattice has cells as near to those at the sides of the block as whole numbers
/// allow. The section is repeated along the axis. Throws Error(geometry) when the cells would be too many.
mesh::HexMeshData make_cylinder_channel(const mesh::BoxParameters& box, const mesh::CylinderParameters& cylinder);

}  // namespace fbi::meshgen
