/// Checks of generated meshes: cell volumes, fibers outside the channel, fibers that cross.
#pragma once

#include <string>
#include <vector>

#include "base/types.hpp"
#include "mesh/mesh_data.hpp"
#include "mesh/parameters.hpp"

namespace fbi::meshgen {

/// Smallest over all cells of the Jacobian determinant at the eight corners, relative to the product of the three mean
/// edge lengths of the cell: 1 for a brick, <= 0 for a folded cell. 1 for an empty mesh.
double smallest_jacobian(const mesh::HexMeshData& mesh);

/// A fiber that reaches out of the channel.
struct OutsideFiber {
  GlobalIndex fiber = 0;
  double distance = 0.0;      ///< farthest it reaches beyond a face [length]
  std::string face;           ///< that face
  double share = 0.0;         ///< part of its length that lies outside, in [0, 1]
  Vec3 place = Vec3::Zero();  ///< a point outside, for meshes that are no boxes [length]
};

/// Fibers that reach out of the box by more than 1e-9 sizes of the cells at that face; their center lines are sampled
/// at 17 points an element, so that shares are exact for straight fibers to 1 %.
std::vector<OutsideFiber> fibers_outside(const mesh::FiberMeshData& fibers, const mesh::Box& box);

/// Fibers that reach out of a mesh of any shape: points of the center line, 17 an element, that lie in no cell (farther
/// than 1e-9 cell sizes from it). `distance` and `face` are not filled in.
std::vector<OutsideFiber> fibers_outside(const mesh::FiberMeshData& fibers, const mesh::HexMeshData& mesh);

/// Pairs of fibers without joints between them whose center lines, taken as chains of chords, come nearer than the sum
/// of their radii.
struct Crossings {
  GlobalIndex pairs = 0;              ///< fibers nearer to each other than the sum of their radii
  GlobalIndex coincident = 0;         ///< pairs with the same nodes, which are not counted above
  GlobalIndex example[2] = {-1, -1};  ///< one of the pairs
};

/// @param radius of each fiber, shape=(fibers) [length]; 0 counts center lines that meet
Crossings crossing_fibers(const mesh::FiberMeshData& fibers, const std::vector<double>& radius);

}  // namespace fbi::meshgen
