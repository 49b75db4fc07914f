/// The cells of this rank near a box, and the local number of a cell: the search within a rank.
#pragma once

#include <array>
#include <vector>

#include "mesh/hex_mesh.hpp"
#include "search/aabb.hpp"
#include "search/tree.hpp"

namespace fbi::search {

/// Local number of a cell from its file id: by arithmetic when this rank holds a block of a tensor-product box, else by
/// bisection.
class CellNumbers {
 public:
  explicit CellNumbers(const mesh::HexMesh& mesh);
  /// Local number, or -1 when the cell is on another rank.
  Index local(GlobalIndex id) const;

 private:
  const std::vector<GlobalIndex>* ids_;
  bool block_ = false;
  std::array<GlobalIndex, 3> begin_{}, size_{}, global_{};
};

/// Pairs (box of a fiber element, cell) within a rank by a bounding-volume tree over the cells.
class PairSearch {
 public:
  /// Cells are enlarged by `tolerance` times their own size.
  PairSearch(const mesh::HexMesh& mesh, double tolerance);
  /// Local numbers of the cells whose boxes overlap `box`, ascending, in `cells` (overwritten).
  void cells_near(const Aabb& box, std::vector<Index>& cells) const;

 private:
  Tree tree_;
};

}  // namespace fbi::search
