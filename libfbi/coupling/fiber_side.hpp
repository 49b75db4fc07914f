/// D, kappa and the covered lengths of this rank's fibers.
#pragma once

#include <vector>

#include "coupling/coupling.hpp"
#include "coupling/cutting.hpp"

namespace fbi::coupling {

/// The part of the coupling operators that needs no fluid: sums over the integration points of every fiber.
class FiberSide {
 public:
  FiberSide(const mesh::FiberMesh& fibers, Multiplier multiplier, Index gauss_points);

  /// Numbers the integration points inside the fluid along every element and the rows that follow from them. Returns
  /// the number of rows of this rank.
  Index number_rows(ElementSegments& cuts);
  /// Integrates D, kappa and lengths. `elements` and `cuts` belong to the fibers' elements.
  void integrate(const std::vector<ElementGeometry>& elements, const ElementSegments& cuts);

  const Basis& basis() const { return basis_; }
  const fem::QuadratureRule& rule() const { return rule_; }
  /// First row of a fiber, valid for the number of fibers too; local.
  Index first_row(Index fiber) const { return first_row_[fiber]; }
  /// First row of an element; local.
  Index first_row_of_element(Index element) const { return element_row_[element]; }
  const std::vector<double>& kappa() const { return kappa_; }
  const std::vector<double>& d_block(Index fiber) const { return d_blocks_[fiber]; }
  /// Arc length of each fiber inside and outside the fluid, shape=(fibers,2) [length].
  const std::vector<double>& lengths() const { return lengths_; }
  Index segments() const { return segments_; }
  /// Values of the multiplier field at the nodes of the fibers, shape=(fiber nodes,3), from lambda, shape=(rows,3):
  /// those of the node for Lagrange bases, else means weighted by the node's linear function.
  std::vector<double> at_nodes(const std::vector<double>& lambda) const;

 private:
  const mesh::FiberMesh& fibers_;
  Basis basis_;
  fem::QuadratureRule rule_;
  std::vector<Index> first_row_, element_row_;
  std::vector<double> kappa_;
  std::vector<std::vector<double>> d_blocks_;
  std::vector<double> lengths_;
  std::vector<IntegrationPoint> row_points_;  ///< gauss_point: of each row
  Index segments_ = 0;
};

}  // namespace fbi::coupling
