#include "linalg/direct.hpp"

namespace fbi::linalg {

DirectSolver::DirectSolver(const Comm& comm) {
  FBI_PETSC(KSPCreate(comm.get(), ksp_.out()));
  FBI_PETSC(KSPSetType(ksp_, KSPPREONLY));
  PC pc = nullptr;
  FBI_PETSC(KSPGetPC(ksp_, &pc));
  FBI_PETSC(PCSetType(pc, PCLU));
  FBI_PETSC(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
}

bool DirectSolver::factorize(Mat matrix) {
  FBI_PETSC(KSPSetOperators(ksp_, matrix, matrix));
  PC pc = nullptr;
  FBI_PETSC(KSPGetPC(ksp_, &pc));
  if (PCSetUp(pc) != 0) return false;
  PCFailedReason reason = PC_NOERROR;
  FBI_PETSC(PCGetFailedReason(pc, &reason));
  return reason == PC_NOERROR;
}

void DirectSolver::solve(Vec b, Vec x) { FBI_PETSC(KSPSolve(ksp_, b, x)); }

}  // namespace fbi::linalg
