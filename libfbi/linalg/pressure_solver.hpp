/// One cycle of algebraic multigrid on the pressure operator, for preconditioning.
#pragma once

#include "base/comm.hpp"
#include "linalg/petsc.hpp"

namespace fbi::linalg {

/// hypre BoomerAMG on a scalar, symmetric positive (semi-)definite matrix; one V-cycle an application.
class PressureSolver {
 public:
  /// `singular`: the constant is in the kernel; it is projected out of right-hand side and solution. Collective.
  PressureSolver(const Comm& comm, MatHandle matrix, bool singular);

  /// x = approximate A^-1 b. Collective.
  void apply(Vec b, Vec x);
  Mat matrix() const { return matrix_; }

 private:
  MatHandle matrix_;
  KspHandle ksp_;
};

}  // namespace fbi::linalg
