/// Fibers that touch or cross each other, wherever they are: there is no contact, but the program says so.
#pragma once

#include <vector>

#include "mesh/fiber_mesh.hpp"
#include "search/sparse_exchange.hpp"

namespace fbi::search {

/// Pairs of different fibers.
struct FiberPairs {
  GlobalIndex count = 0;
  GlobalIndex first[2] = {-1, -1};  ///< file numbers of the pair with the lowest ones; -1: none
};

/// Counts pairs of fibers whose center lines come nearer to each other than the sum of their radii. Fibers that a joint
/// ties together are left out; a fiber that crosses itself is not seen.
///
/// Elements are found by the boxes of their Bezier points and halved until they are straight to a hundredth of the sum
/// of the radii. Between ranks travel one box a rank and the elements that reach into the box of another rank.
class FiberCrossings {
 public:
  /// @param radius  of each fiber of this rank, shape=(fibers) [length]; 0 counts center lines that meet
  /// `fibers` must outlive this object. Collective.
  FiberCrossings(const mesh::FiberMesh& fibers, std::vector<double> radius);

  /// The pairs at positions `dofs`, shape=(fiber nodes,6): x, y, z, tx, ty, tz; the same on any number of ranks. Cost
  /// O(n log n) for n elements a rank that cross few others. Collective.
  FiberPairs find(const std::vector<double>& dofs);

 private:
  const mesh::FiberMesh& fibers_;
  std::vector<double> radius_;
  std::vector<std::pair<GlobalIndex, GlobalIndex>> joined_;  ///< file numbers, ascending
  SparseExchange exchange_;
};

/// Smallest distance of two segments from a and b with these directions (to their ends) [length].
double segment_distance(const Vec3& a, const Vec3& along_a, const Vec3& b, const Vec3& along_b);

}  // namespace fbi::search
