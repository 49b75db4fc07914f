/// VelocityLines on tensor-product boxes.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "fluid/halo.hpp"
#include "fsi/velocity_lines.hpp"

namespace fbi::fsi {

/// Lines in the one direction of the box that has most streamline diffusion.
class BoxLines : public VelocityLines {
 public:
  /// True when the mesh is a box and the nodes that each rank owns fill a block of it. Collective.
  static bool supports(const mesh::HexMesh& mesh);

  /// The mesh of the fluid must be supported. Collective.
  explicit BoxLines(const fluid::FluidField& fluid);

  void renew(const VelocityWeight& weight) override;
  void apply(const float* r, float* x, const std::vector<char>* only = nullptr) const override;
  std::vector<char> reached(const std::vector<Index>& nodes) const override;
  std::vector<char> nodes_of(const std::vector<char>& lines) const override;
  std::vector<double> diagonal() override;
  int version() const override { return axis_; }
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
  void factorize(const Bundle& bundle, const LineTerms& terms);
  void set_sides(const LineTerms& terms);
  template <std::size_t Lanes>
  void solve(const Bundle& bundle, const float* r, float* x) const;

  const fluid::FluidField& fluid_;
  fluid::Halo halo_;
  std::vector<CellShape> shape_;  ///< shape=(local cells)
  std::vector<float> tau_;        ///< tau_streamline, shape=(local cells)
  /// After renew(): couplings of each node to those before and after, diagonal, the same without convection,
  /// shape=(local nodes,4).
  std::vector<float> rows_;
  /// Diffusion by grad-div of the velocity along the line, to the nodes before and after, and tau_C times the volume of
  /// the node, shape=(local nodes,4).
  std::vector<float> grad_div_;
  std::array<std::size_t, 3> n_{}, stride_{};  // owned nodes along each direction, steps between them
  int axis_ = 0;
  /// Of lines next to each other: 1/h^2 of the edges to its neighbors, and B of velocities along those, shape=(2,...).
  std::array<std::vector<float>, 2> side_square_, side_across_;
  std::vector<LinePivot> pivots_;  // shape=(owned nodes)
};

}  // namespace fbi::fsi
