/// Approximate inverse of the fluid's velocity block on tensor-product boxes: lines of nodes the way the flow goes.
#pragma once

#include <array>
#include <vector>

#include "fluid/fluid_field.hpp"
#include "fluid/halo.hpp"
#include "fsi/velocity_weight.hpp"

namespace fbi::fsi {

/// V = L^-1 (1 + b D_1 + b D_2): L has, along every line of nodes in the direction d of most streamline diffusion, the
/// tridiagonal matrices of linear elements of
///   rho (sigma + v_d d/dx) u + rho tau v_d dw/dx (rho sigma u + rho v_d du/dx) + mu du/dx dw/dx,
/// lumped across, plus a diagonal for what acts across: viscosity, a third of grad-div, streamline diffusion, half of
/// the reaction rho |dv|/h. D_1 and D_2 are second differences across (-1/2, 1, -1/2) of forces over areas, which undo
/// half of what lumping does to the mass of rough fields.
///
/// A diagonal is too small, by up to 20, for fields that are rough across the flow and smooth along it; fibers make
/// such fields. Lines end where the nodes of a rank do.
class VelocityLines {
 public:
  /// True when the mesh is a box and the nodes that each rank owns fill a block of it. Collective.
  static bool supports(const mesh::HexMesh& mesh);

  /// The mesh of the fluid must be supported. Collective.
  explicit VelocityLines(const fluid::FluidField& fluid);

  /// Renews L for the present time step and tau, with the flow that W was renewed for. Collective.
  void renew(const VelocityWeight& weight);
  /// The first three numbers of every node of x = V r; the fourth ones of x stay. r is zero where the velocity is
  /// given, x is then not: that is left to the caller. Shapes=(owned nodes,4); r and x differ.
  /// @param only  lines of x to compute, shape=(lines); null: all
  void apply(const float* r, float* x, const std::vector<char>* only = nullptr) const;
  /// 1 for lines where x is not zero when r is zero but at the given owned nodes, shape=(lines).
  std::vector<char> reached(const std::vector<Index>& nodes) const;
  /// Diagonal of V for fields that are rough in one direction across, zero where the velocity is given, shape=(local
  /// nodes,3). Collective.
  std::vector<double> diagonal();
  /// The direction d.
  int axis() const { return axis_; }

 private:
  struct Bundle;
  struct CellShape {
    Eigen::Array3f inverse_edge;
    float volume, inverse_size;  // inverse_size: V^(-1/3)
  };
  template <class Act>
  void for_bundles(const Act& act) const;
  template <std::size_t Lanes>
  void factorize(const Bundle& bundle);
  template <std::size_t Lanes>
  void solve(const Bundle& bundle, const float* r, float* x) const;

  const fluid::FluidField& fluid_;
  fluid::Halo halo_;
  std::vector<CellShape> shape_;  ///< shape=(local cells)
  /// After renew(): couplings of each node to those before and after, diagonal, the same without convection,
  /// shape=(local nodes,4).
  std::vector<float> rows_;
  std::array<std::size_t, 3> n_{}, stride_{};  // owned nodes along each direction, steps between them
  int axis_ = 0;
  std::vector<float> low_;      // coupling to the node before, shape=(owned nodes)
  std::vector<float> inverse_;  // 1/pivot
  std::vector<float> high_;     // coupling to the node after, over the pivot
};

}  // namespace fbi::fsi
