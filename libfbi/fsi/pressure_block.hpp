/// The pressure's part of the preconditioner.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "fluid/fluid_field.hpp"
#include "fsi/velocity_weight.hpp"
#include "linalg/pressure_solver.hpp"

namespace fbi::fsi {

/// p = scale P^-1 r + mass r/V_a: P the Laplacian, exact on boxes and one multigrid cycle elsewhere, with a Robin
/// condition at open faces; docs/theory.md, "Why these parts of the pressure". With a pressure projection P has it, and
/// inertia, as coefficients.
class PressureBlock {
 public:
  explicit PressureBlock(fluid::FluidField& fluid) : fluid_(fluid) {}

  /// For the present time step and, with a projection, iterate. Collective.
  void renew();
  /// mass = 2 mu, and 0.85 tau_C where the solve is `demanding`; 1/projection where there is one. After renew().
  /// Collective.
  void renew_mass(VelocityWeight& weight, bool demanding);

  linalg::PressureSolver& solver() const { return *solver_; }
  double scale() const { return scale_; }
  /// shape=(owned nodes) [viscosity]
  const std::vector<double>& mass() const { return mass_; }

 private:
  void renew_projected();
  std::array<std::array<double, 2>, 3> robin_ends(double coefficient) const;

  fluid::FluidField& fluid_;
  std::unique_ptr<linalg::PressureSolver> solver_;
  double scale_ = 1.0;       // rho sigma; 1 where P has it
  double projection_ = 0.0;  // coefficient of the pressure projection in P, 0 with PSPG
  double inertia_ = 0.0;     // 1/(rho sigma) there
  std::vector<double> mass_;
};

}  // namespace fbi::fsi
