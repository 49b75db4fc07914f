/// The fluid with the multiplier term as one assembled matrix, solved by a general-purpose Krylov method.
#pragma once

#include <vector>

#include "coupling/coupling.hpp"
#include "coupling/interface_operator.hpp"
#include "fluid/fluid_field.hpp"
#include "fsi/parameters.hpp"
#include "linalg/ilu_gmres.hpp"

namespace fbi::fsi {

/// (A + M^T S^-1 M) x = b with every entry of the matrix assembled, by GMRES with ILU: how finite-element codes solve
/// the fluid field of a partitioned scheme (Hagemeyer, Mayr, Popp 2024, eq. 13), kept to measure the special solver
/// against and to check its answers. Continuity rows are scaled as in the special solver, so that a tolerance means the
/// same.
class AssembledSystem {
 public:
  /// `coupling` and `interface` are null without fibers. Collective.
  AssembledSystem(fluid::FluidField& fluid, const coupling::Coupling* coupling,
                  const coupling::InterfaceOperator* interface, const SolverParameters& parameters);

  /// Assembles and factorises at the present linearisation, M and S; `geometry_changed`: M is not that of the last
  /// call; `continuity_scale` multiplies the continuity rows. False on all ranks when a pivot is zero. Cost: some 40 kB
  /// of memory a node for matrices and factors. Collective.
  bool prepare(bool geometry_changed, double continuity_scale);
  /// x of the system above; b has scaled continuity rows. Collective.
  linalg::KrylovResult solve(Vec b, Vec x, double tolerance) { return solver_.solve(b, x, tolerance); }

 private:
  void assemble_m();
  bool assemble_inverse();
  void add_multiplier_term(bool geometry_changed);

  fluid::FluidField& fluid_;
  const coupling::Coupling* coupling_;
  const coupling::InterfaceOperator* interface_;
  Comm comm_;
  linalg::IluGmres solver_;
  linalg::MatHandle jacobian_, m_, inverse_, term_, sum_;
  std::vector<PetscInt> inverse_rows_, inverse_columns_;  // pattern of S^-1
  linalg::VecHandle row_scale_;
};

}  // namespace fbi::fsi
