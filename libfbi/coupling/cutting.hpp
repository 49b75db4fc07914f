/// From the curves of a rank's fiber elements to pieces in the cells of all ranks.
#pragma once

#include <memory>
#include <vector>

#include "coupling/coupling_matrices.hpp"
#include "coupling/point_location.hpp"
#include "coupling/segmentation.hpp"
#include "mesh/hex_mesh.hpp"
#include "search/bins.hpp"
#include "search/pair_search.hpp"
#include "search/sparse_exchange.hpp"

namespace fbi::coupling {

/// What a cell's rank needs to know of a fiber element. Trivially copyable.
struct ElementGeometry {
  GlobalIndex row = 0;  ///< global number of its first multiplier row
  Curve curve;          ///< current
  Measure measure;      ///< reference
  double radius = 0.0;  ///< a of the fiber [length]
};

/// Segments of the elements of this rank: element e has [first[e], first[e+1]), from -1 to 1.
struct ElementSegments {
  std::vector<Index> first;
  std::vector<Segment> segments;
};

/// Puts the segments of moved elements, in their order, in the places of the elements that are not `kept`.
void merge_segments(const std::vector<char>& kept, const ElementSegments& moved, ElementSegments& all);

/// A segment in a cell of this rank.
struct Piece {
  Index geometry = 0;  ///< index into Pieces::geometries
  Index cell = 0;      ///< local
  Segment segment;
};

/// Segments in the cells of this rank by (row, begin), whichever rank their fibers are on.
struct Pieces {
  std::vector<ElementGeometry> geometries;
  std::vector<Piece> pieces;
};

/// Calls visit(piece, geometry, cell, point) for every integration point of the pieces, in their order.
template <class Visit>
void visit_points(const mesh::HexMesh& mesh, const Pieces& pieces, const fem::QuadratureRule& rule, Visit&& visit) {
  std::vector<IntegrationPoint> points;
  for (const Piece& piece : pieces.pieces) {
    const ElementGeometry& geometry = pieces.geometries[piece.geometry];
    const Cell cell = make_cell(mesh, piece.cell);
    points.clear();
    integration_points(geometry.measure, rule, piece.segment, points);
    for (const IntegrationPoint& point : points) visit(piece, geometry, cell, point);
  }
}

/// Cuts fiber elements at the faces of a distributed mesh. Box meshes need no search: every rank knows all grid planes.
/// In other meshes the curves go to the ranks whose bins they touch, these return claims, the fiber's rank resolves
/// them.
class Cutting {
 public:
  /// Mesh and exchange must outlive this object.
  /// @param periods  translations by which the flow repeats [length]
  /// Collective.
  Cutting(const mesh::HexMesh& mesh, search::SparseExchange& exchange, const std::vector<Vec3>& periods);

  /// Cuts the elements of this rank. Collective.
  void cut(const std::vector<ElementGeometry>& elements, ElementSegments& result);

  /// Instead of pieces the points of `rule` on every element, each in its cell. Collective.
  void place_points(const std::vector<ElementGeometry>& elements, const fem::QuadratureRule& rule,
                    ElementSegments& result);

  /// Brings every segment inside the fluid to the rank of its cell. Collective.
  void deliver(const std::vector<ElementGeometry>& elements, const ElementSegments& segments, Pieces& result);

  PointLocation& location() { return location_; }
  /// Local number of a cell, or -1.
  Index local_cell(GlobalIndex id) const { return numbers_.local(id); }
  const search::RankBins& bins() const { return bins_; }

 private:
  void cut_general(const std::vector<ElementGeometry>& elements, ElementSegments& result);
  void claim(const Curve& curve, std::vector<Claim>& claims);

  const mesh::HexMesh& mesh_;
  search::SparseExchange& exchange_;
  search::CellNumbers numbers_;
  search::RankBins bins_;
  std::unique_ptr<search::PairSearch> pairs_;  ///< null for box meshes
  std::vector<Index> near_cells_;
  PointLocation location_;
};

}  // namespace fbi::coupling
