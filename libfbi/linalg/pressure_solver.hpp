/// Approximate inverses of the pressure operator, for preconditioning.
#pragma once

#include "base/comm.hpp"
#include "linalg/petsc.hpp"

namespace fbi::linalg {

/// x = P^-1 b for a scalar, symmetric positive (semi-)definite operator on the owned nodes.
class PressureSolver {
 public:
  virtual ~PressureSolver() = default;
  /// Collective.
  virtual void apply(Vec b, Vec x) = 0;
  /// The same in single precision, shape=(owned nodes). Collective.
  virtual void apply(const float* b, float* x) = 0;
};

/// hypre BoomerAMG on any matrix; one V-cycle an application.
class MultigridPressure : public PressureSolver {
 public:
  /// `singular`: the constant is in the kernel; it is projected out of right-hand side and solution. Collective.
  MultigridPressure(const Comm& comm, MatHandle matrix, bool singular);
  void apply(Vec b, Vec x) override;
  /// By conversion: PETSc has one number type.
  void apply(const float* b, float* x) override;

 private:
  MatHandle matrix_;
  KspHandle ksp_;
  VecHandle right_, solution_;
};

}  // namespace fbi::linalg
