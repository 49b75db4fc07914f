#include "linalg/krylov.hpp"

#include <cmath>

namespace fbi::linalg {
namespace {

PetscErrorCode multiply(Mat matrix, Vec x, Vec y) {
  VectorMap* map = nullptr;
  PetscCall(MatShellGetContext(matrix, &map));
  (*map)(x, y);
  return 0;
}

PetscErrorCode precondition(PC pc, Vec x, Vec y) {
  VectorMap* map = nullptr;
  PetscCall(PCShellGetContext(pc, &map));
  (*map)(x, y);
  return 0;
}

}  // namespace

Krylov::Krylov(const Comm& comm, Vec layout, VectorMap matrix, VectorMap preconditioner)
    : matrix_(std::move(matrix)), preconditioner_(std::move(preconditioner)) {
  PetscInt local = 0, global = 0;
  FBI_PETSC(VecGetLocalSize(layout, &local));
  FBI_PETSC(VecGetSize(layout, &global));
  FBI_PETSC(MatCreateShell(comm.get(), local, local, global, global, &matrix_, shell_.out()));
  FBI_PETSC(MatShellSetOperation(shell_, MATOP_MULT, reinterpret_cast<void (*)(void)>(multiply)));
  FBI_PETSC(KSPCreate(comm.get(), ksp_.out()));
  FBI_PETSC(KSPSetOperators(ksp_, shell_, shell_));
  FBI_PETSC(KSPSetType(ksp_, KSPFGMRES));
  FBI_PETSC(KSPGMRESSetRestart(ksp_, 60));
  FBI_PETSC(KSPSetInitialGuessNonzero(ksp_, PETSC_FALSE));
  PC pc = nullptr;
  FBI_PETSC(KSPGetPC(ksp_, &pc));
  FBI_PETSC(PCSetType(pc, PCSHELL));
  FBI_PETSC(PCShellSetContext(pc, &preconditioner_));
  FBI_PETSC(PCShellSetApply(pc, precondition));
}

Krylov::~Krylov() = default;

KrylovResult Krylov::solve(Vec b, Vec x, double tolerance, int maximum) {
  FBI_PETSC(KSPSetTolerances(ksp_, tolerance, PETSC_DEFAULT, 1e10, maximum));
  return solve_from_zero(ksp_, b, x);
}

KrylovResult solve_from_zero(KSP solver, Vec b, Vec x) {
  KrylovResult result;
  PetscReal norm = 0.0;
  FBI_PETSC(VecNorm(b, NORM_2, &norm));
  FBI_PETSC(VecSet(x, 0.0));
  if (norm == 0.0) {
    result.converged = true;
    return result;
  }
  if (!std::isfinite(norm)) return result;
  FBI_PETSC(KSPSolve(solver, b, x));
  PetscInt iterations = 0;
  PetscReal residual = 0.0;
  KSPConvergedReason reason;
  FBI_PETSC(KSPGetIterationNumber(solver, &iterations));
  FBI_PETSC(KSPGetResidualNorm(solver, &residual));
  FBI_PETSC(KSPGetConvergedReason(solver, &reason));
  result.iterations = static_cast<int>(iterations);
  result.relative_residual = residual / norm;
  result.converged = reason > 0;
  return result;
}

}  // namespace fbi::linalg
