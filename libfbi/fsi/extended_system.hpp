/// Sparse direct solution of the fluid with the multipliers as extra unknowns.
#pragma once

#include "coupling/coupling.hpp"
#include "coupling/interface_operator.hpp"
#include "fluid/fluid_field.hpp"
#include "linalg/direct.hpp"

namespace fbi::fsi {

/// (A + M^T S^-1 M) x = b as [A M^T; M -S] [x; lambda] = [b; 0], which stays sparse, factorised as a whole. Where no
/// face fixes the pressure level the pressure of the first node is held; right-hand sides must be compatible.
class ExtendedSystem {
 public:
  /// `coupling` and `interface` are null without fibers.
  ExtendedSystem(fluid::FluidField& fluid, const coupling::Coupling* coupling,
                 const coupling::InterfaceOperator* interface);

  /// Assembles and factorises at the present linearisation; false on all ranks when singular or not finite. Collective.
  bool factorize();
  /// x of the system above; false on all ranks when it is not finite. Collective.
  bool solve(Vec b, Vec x);

 private:
  fluid::FluidField& fluid_;
  const coupling::Coupling* coupling_;
  const coupling::InterfaceOperator* interface_;
  Comm comm_;
  linalg::DirectSolver factors_;
  linalg::MatHandle jacobian_, extended_;
  linalg::VecHandle right_, solution_;
};

}  // namespace fbi::fsi
