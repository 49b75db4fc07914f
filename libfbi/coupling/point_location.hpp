/// Which cells hold given points, across ranks.
#pragma once

#include <vector>

#include "mesh/hex_mesh.hpp"
#include "search/bins.hpp"
#include "search/pair_search.hpp"
#include "search/sparse_exchange.hpp"

namespace fbi::coupling {

/// A point and where it lies.
struct Place {
  Vec3 point;             ///< moved by periods of the flow if it lay outside [length]
  GlobalIndex cell = -1;  ///< file id; -1: outside the fluid
  int rank = -1;          ///< that holds the cell; -1: not known (box meshes: one of the ranks near the point)
};

/// Finds cells by the rule of the segmentation: the lowest file id among those that hold a point to inside_tolerance.
/// Box meshes need no messages.
class PointLocation {
 public:
  /// All arguments must outlive this object; `pairs` may be null for boxes.
  /// @param periods  translations by which the flow repeats [length]
  PointLocation(const mesh::HexMesh& mesh, search::SparseExchange& exchange, const search::RankBins& bins,
                const search::PairSearch* pairs, const std::vector<Vec3>& periods);

  /// Fills in cell and rank of every place; points outside the fluid are moved by sums of periods until they lie
  /// inside. Collective.
  void locate(std::vector<Place>& places);

 private:
  void locate_once(std::vector<Place>& places);
  GlobalIndex local_cell(const Vec3& point);

  const mesh::HexMesh& mesh_;
  search::SparseExchange& exchange_;
  const search::RankBins& bins_;
  const search::PairSearch* pairs_;
  std::vector<Vec3> shifts_;  ///< sums of periods, nearest first
  std::vector<Index> near_;
};

}  // namespace fbi::coupling
