/// S_p = int Phi_p E^-1 ds of the interface law lambda = E (M v - v_b) with a symmetric 3 x 3 matrix E.
#pragma once

#include <memory>
#include <vector>

#include "coupling/coupling.hpp"
#include "coupling/cutting.hpp"
#include "coupling/ring.hpp"
#include "coupling/row_exchange.hpp"

namespace fbi::coupling {

/// The law that keeps a fiber's own radius (ring.hpp), integrated where the center line's cells are.
class OwnRadiusLaw {
 public:
  OwnRadiusLaw(const mesh::HexMesh& mesh, search::SparseExchange& exchange, double viscosity)
      : mesh_(mesh), exchange_(exchange), viscosity_(viscosity) {}

  /// Takes over the integration points of `pieces`; `offsets` as in RowExchange. Collective.
  void set_points(const Pieces& pieces, const fem::QuadratureRule& rule, const Basis& basis,
                  const std::vector<GlobalIndex>& offsets);

  /// S_p of this rank's rows for the stabilisation in every local cell, shape=(rows) [length^3/(force time)].
  /// Collective.
  void evaluate(const std::vector<CellViscosity>& cells, std::vector<Symmetric>& rows) const;

 private:
  struct Point {
    Index first;  ///< of the touched rows
    int rows;
    Index cell;               ///< local
    double value[most_rows];  ///< Phi_p ds
    double radius, ring_radius, cell_size;
    Vec3 tangent;
  };
  const mesh::HexMesh& mesh_;
  search::SparseExchange& exchange_;
  double viscosity_;
  std::vector<Point> points_;
  std::vector<GlobalIndex> touched_;  ///< global rows, ascending
  std::unique_ptr<RowExchange> exchange_rows_;
};

}  // namespace fbi::coupling
