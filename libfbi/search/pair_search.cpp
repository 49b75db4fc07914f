#include "search/pair_search.hpp"

#include <algorithm>

#include "search/bins.hpp"

namespace fbi::search {

CellNumbers::CellNumbers(const mesh::HexMesh& mesh) : ids_(&mesh.cell_id) {
  if (!mesh.box || mesh.cell_id.empty()) return;
  const std::array<Index, 3> cells = mesh.box->cells();
  for (int i = 0; i < 3; ++i) global_[i] = cells[i];
  std::array<GlobalIndex, 3> low = global_, high{};
  for (const GlobalIndex id : mesh.cell_id) {
    const std::array<GlobalIndex, 3> at = {id % global_[0], id / global_[0] % global_[1],
                                           id / (global_[0] * global_[1])};
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], at[i]);
      high[i] = std::max(high[i], at[i] + 1);
    }
  }
  begin_ = low;
  for (int i = 0; i < 3; ++i) size_[i] = high[i] - low[i];
  // Ascending ids of a full block are its cells, x fastest.
  block_ = size_[0] * size_[1] * size_[2] == static_cast<GlobalIndex>(mesh.cell_id.size());
}

Index CellNumbers::local(GlobalIndex id) const {
  if (block_) {
    const std::array<GlobalIndex, 3> at = {id % global_[0] - begin_[0], id / global_[0] % global_[1] - begin_[1],
                                           id / (global_[0] * global_[1]) - begin_[2]};
    for (int i = 0; i < 3; ++i)
      if (at[i] < 0 || at[i] >= size_[i]) return -1;
    return static_cast<Index>(at[0] + size_[0] * (at[1] + size_[1] * at[2]));
  }
  const auto found = std::lower_bound(ids_->begin(), ids_->end(), id);
  return found != ids_->end() && *found == id ? static_cast<Index>(found - ids_->begin()) : -1;
}

PairSearch::PairSearch(const mesh::HexMesh& mesh, double tolerance) {
  std::vector<Aabb> boxes(static_cast<std::size_t>(mesh.local_cells()));
  for (Index c = 0; c < mesh.local_cells(); ++c) {
    boxes[c] = cell_box(mesh, c);
    boxes[c].inflate(tolerance * boxes[c].size());
  }
  tree_ = Tree(boxes);
}

void PairSearch::cells_near(const Aabb& box, std::vector<Index>& cells) const {
  cells.clear();
  tree_.overlapping(box, cells);
  std::sort(cells.begin(), cells.end());
}

}  // namespace fbi::search
