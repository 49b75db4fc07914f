/// Which ranks have cells near a box: the search across ranks.
#pragma once

#include <vector>

#include "base/comm.hpp"
#include "mesh/hex_mesh.hpp"
#include "search/aabb.hpp"
#include "search/tree.hpp"

namespace fbi::search {

/// Boxes around the cells of every rank. A rank whose cells fill their common box (a block) is one box; any other is
/// cut into a grid of 4 x 4 x 4 bins, each shrunk to the cells whose centers lie in it. Only these O(ranks) boxes
/// travel.
class RankBins {
 public:
  /// Cells are enlarged by `tolerance` times their own size. Collective.
  RankBins(const Comm& comm, const mesh::HexMesh& mesh, double tolerance);

  /// Ranks with a box that overlaps `box`, ascending, in `ranks` (overwritten).
  void ranks_near(const Aabb& box, std::vector<int>& ranks) const;

 private:
  std::vector<int> rank_of_box_;
  Tree tree_;
  mutable std::vector<Index> found_;
};

/// Box of local cell `cell`: a trilinear cell lies in the hull of its nodes.
Aabb cell_box(const mesh::HexMesh& mesh, Index cell);

}  // namespace fbi::search
