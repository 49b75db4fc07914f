/// Diagonal approximations in the preconditioner: the inverse W of the fluid's velocity block, tau_C at nodes.
#pragma once

#include <vector>

#include "fluid/fluid_field.hpp"

namespace fbi::fsi {

/// Edge vectors in the middle of a cell, one a column [length].
Mat3 middle_edges(const mesh::HexMesh& mesh, Index cell);

/// The flow in a cell.
struct CellFlow {
  Vec3 velocity = Vec3::Zero();  ///< mean of the corners
  double difference = 0.0;       ///< of velocities across the cell: twice the corners' standard deviation
  double grad_div = 0.0;         ///< tau_C [dynamic viscosity]
};

/// W = (rho (sigma + |v|/h + |dv|/h) V_a + sum_K (mu + (rho^2 tau |v|^2 + tau_C)/3) int_K |grad N_a|^2)^-1 for every
/// velocity that is not given, with V_a the lumped volume, |v| the mean speed in a cell and |dv| its variation across
/// the cell: a bound of the block's rows, so that an iteration with W does not grow for any CFL number.
class VelocityWeight {
 public:
  explicit VelocityWeight(fluid::FluidField& fluid);

  /// Renews W for the present iterate, tau and time step; false where nothing it depends on has changed. Collective.
  bool renew();
  /// At the last renewal, shape=(local cells); at rest without convection.
  const std::vector<CellFlow>& flow() const { return flow_; }
  /// W, zero where the velocity is given, shape=(local nodes,3); computed where it is asked for. Collective.
  const std::vector<double>& values();
  /// tau_C of the grad-div term, the mean of a node's cells weighted by volume [dynamic viscosity], shape=(local
  /// nodes). Collective.
  std::vector<double> grad_div();
  /// Largest share of a cell in W^-1 that is not inertia, over inertia: some CFL + 4 mu dt/(rho h^2); the same on all
  /// ranks.
  double strength() const { return strength_; }

 private:
  /// Sums of all ranks. Collective.
  void complete_ghosts(std::vector<double>& nodal);

  fluid::FluidField& fluid_;
  linalg::VecHandle work_;
  std::vector<double> cell_size_;       // V^(1/3) [length], shape=(local cells)
  std::vector<double> cell_diffusion_;  // int |grad N_a|^2 [length], shape=(local cells)
  std::vector<CellFlow> flow_;
  std::vector<double> share_;   // of a node in a cell in W^-1, without inertia, shape=(local cells)
  std::vector<double> values_;  // empty: not computed since the last renewal
  double strength_ = 0.0;
  double sigma_ = -1.0;  // that W was computed for
};

}  // namespace fbi::fsi
