#include "search/bins.hpp"

#include <algorithm>
#include <array>

namespace fbi::search {

namespace {

constexpr int bins_each_way = 4;
constexpr double filled = 0.9;  ///< a rank is one box when its bins fill at least this part of it

std::vector<Aabb> own_boxes(const mesh::HexMesh& mesh, double tolerance) {
  Aabb all;
  for (Index c = 0; c < mesh.local_cells(); ++c) all.include(cell_box(mesh, c));
  if (all.empty()) return {};
  std::vector<Aabb> bins(bins_each_way * bins_each_way * bins_each_way);
  double volume = 0.0;
  Aabb enlarged;
  for (Index c = 0; c < mesh.local_cells(); ++c) {
    Aabb box = cell_box(mesh, c);
    volume += box.volume();
    std::array<int, 3> bin;
    for (int i = 0; i < 3; ++i) {
      const double edge = all.high[i] - all.low[i], center = 0.5 * (box.low[i] + box.high[i]);
      bin[i] =
          edge > 0.0 ? std::min(static_cast<int>(bins_each_way * (center - all.low[i]) / edge), bins_each_way - 1) : 0;
    }
    box.inflate(tolerance * box.size());
    enlarged.include(box);
    bins[bin[0] + bins_each_way * (bin[1] + bins_each_way * bin[2])].include(box);
  }
  if (volume >= filled * all.volume()) return {enlarged};
  bins.erase(std::remove_if(bins.begin(), bins.end(), [](const Aabb& box) { return box.empty(); }), bins.end());
  return bins;
}

}  // namespace

Aabb cell_box(const mesh::HexMesh& mesh, Index cell) {
  Aabb box;
  for (int a = 0; a < 8; ++a) box.include(mesh.node(mesh.cells[8 * static_cast<std::size_t>(cell) + a]));
  return box;
}

RankBins::RankBins(const Comm& comm, const mesh::HexMesh& mesh, double tolerance) {
  const std::vector<Aabb> own = own_boxes(mesh, tolerance);
  const int own_count = static_cast<int>(own.size());
  std::vector<int> counts(comm.size()), bytes(comm.size()), offsets(comm.size());
  MPI_Allgather(&own_count, 1, MPI_INT, counts.data(), 1, MPI_INT, comm.get());
  int total = 0;
  for (int r = 0; r < comm.size(); ++r) {
    offsets[r] = total * static_cast<int>(sizeof(Aabb));
    bytes[r] = counts[r] * static_cast<int>(sizeof(Aabb));
    total += counts[r];
    rank_of_box_.insert(rank_of_box_.end(), counts[r], r);
  }
  std::vector<Aabb> boxes(total);
  MPI_Allgatherv(own.data(), own_count * static_cast<int>(sizeof(Aabb)), MPI_BYTE, boxes.data(), bytes.data(),
                 offsets.data(), MPI_BYTE, comm.get());
  tree_ = Tree(boxes);
}

void RankBins::ranks_near(const Aabb& box, std::vector<int>& ranks) const {
  found_.clear();
  tree_.overlapping(box, found_);
  ranks.clear();
  for (const Index number : found_) ranks.push_back(rank_of_box_[number]);
  std::sort(ranks.begin(), ranks.end());
  ranks.erase(std::unique(ranks.begin(), ranks.end()), ranks.end());
}

}  // namespace fbi::search
