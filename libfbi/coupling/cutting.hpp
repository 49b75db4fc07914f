/// From the curves of a rank's fiber elements to pieces in the cells of all ranks.
#pragma once

#include <vector>

#include "coupling/coupling_matrices.hpp"
#include "coupling/segmentation.hpp"
#include "mesh/hex_mesh.hpp"
#include "search/bins.hpp"
#include "search/pair_search.hpp"
#include "search/sparse_exchange.hpp"

namespace fbi::coupling {

/// What a cell's rank needs to know of a fiber element. Trivially copyable.
struct ElementGeometry {
  GlobalIndex row = 0;  ///< global multiplier row of its first node
  Curve curve;          ///< current
  Measure measure;      ///< reference
};

/// Segments of the elements of this rank: element e has [first[e], first[e+1]), from -1 to 1.
struct ElementSegments {
  std::vector<Index> first;
  std::vector<Segment> segments;
};

/// A segment in a cell of this rank.
struct Piece {
  Index geometry = 0;  ///< index into Pieces::geometries
  Index cell = 0;      ///< local
  double begin = 0.0, end = 0.0;
};

/// Segments in the cells of this rank by (row, begin), whichever rank their fibers are on.
struct Pieces {
  std::vector<ElementGeometry> geometries;
  std::vector<Piece> pieces;
};

/// Cuts fiber elements at the faces of a distributed mesh. Box meshes need no search: every rank knows all grid planes.
/// In other meshes the curves go to the ranks whose bins they touch, these return claims, the fiber's rank resolves
/// them.
class Cutting {
 public:
  /// Both must outlive this object. Collective.
  Cutting(const mesh::HexMesh& mesh, search::SparseExchange& exchange);

  /// Cuts the elements of this rank. Collective.
  void cut(const std::vector<ElementGeometry>& elements, ElementSegments& result);

  /// Brings every segment inside the fluid to the rank of its cell. Collective.
  void deliver(const std::vector<ElementGeometry>& elements, const ElementSegments& segments, Pieces& result);

 private:
  void cut_general(const std::vector<ElementGeometry>& elements, ElementSegments& result);
  void claim(const Curve& curve, std::vector<Claim>& claims);

  const mesh::HexMesh& mesh_;
  search::SparseExchange& exchange_;
  search::CellNumbers numbers_;
  search::RankBins bins_;
  std::vector<search::PairSearch> pairs_;  ///< one, or none for box meshes
  std::vector<Index> near_cells_;
};

}  // namespace fbi::coupling
