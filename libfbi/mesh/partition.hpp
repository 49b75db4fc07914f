/// Which rank gets which cell: recursive bisection of a box of cells, or of the cell centers of any mesh.
#pragma once

#include <array>
#include <vector>

#include "base/comm.hpp"
#include "base/types.hpp"

namespace fbi::mesh {

/// Blocks of whole cell layers: a block of cells is halved along its longest direction in cells (x before y before z on
/// ties) at the layer nearest to the share of the ranks on each side.
class BoxPartition {
 public:
  BoxPartition(const std::array<Index, 3>& cells, int ranks);
  /// Rank of the cell with file number `cell` (x fastest).
  int rank(GlobalIndex cell) const;

 private:
  struct Cut {
    int axis = -1;  // -1: a single rank
    Index layer = 0;
    int rank = 0;
    int low = -1, high = -1;
  };
  int cut(std::array<Index, 3> begin, std::array<Index, 3> end, int first_rank, int ranks);
  std::array<Index, 3> cells_;
  std::vector<Cut> cuts_;
};

/// Recursive coordinate bisection: a set of cells is cut across the longest side of the box around its centers, in
/// exact proportion to the ranks on each side, equal coordinates in the order of the cell ids. The same centers and ids
/// give the same ranks however the cells are spread. Cost: some hundred small reductions per level (log2 of the ranks).
/// Collective.
///
/// `centers` has shape=(cells,3) [length], `ids` shape=(cells). Returns the rank of each of this rank's cells.
std::vector<int> bisect_centers(const Comm& comm, const std::vector<double>& centers,
                                const std::vector<GlobalIndex>& ids);

}  // namespace fbi::mesh
