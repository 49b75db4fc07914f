#include "linalg/direct.hpp"

namespace fbi::linalg {

namespace {

constexpr PetscInt whole_below = 20000;  // rows; about 100 MiB of factors for trilinear hexahedra

}  // namespace

DirectSolver::DirectSolver(const Comm& comm) : comm_(comm) {}

void DirectSolver::start(Mat matrix) {
  FBI_PETSC(KSPCreate(comm_.get(), ksp_.out()));
  FBI_PETSC(KSPSetType(ksp_, KSPPREONLY));
  FBI_PETSC(KSPSetOperators(ksp_, matrix, matrix));
  FBI_PETSC(KSPGetPC(ksp_, &factors_));
  PetscInt rows = 0;
  FBI_PETSC(MatGetSize(matrix, &rows, nullptr));
  if (comm_.size() > 1 && rows < whole_below) {
    FBI_PETSC(PCSetType(factors_, PCREDUNDANT));
    FBI_PETSC(PCRedundantSetNumber(factors_, comm_.size()));
    KSP inner = nullptr;
    FBI_PETSC(PCRedundantGetKSP(factors_, &inner));
    FBI_PETSC(KSPSetType(inner, KSPPREONLY));
    FBI_PETSC(KSPGetPC(inner, &factors_));
  }
  FBI_PETSC(PCSetType(factors_, PCLU));
  FBI_PETSC(PCFactorSetMatSolverType(factors_, MATSOLVERMUMPS));
}

bool DirectSolver::factorize(Mat matrix) {
  PetscInt rows = 0, own = 0;
  FBI_PETSC(MatGetSize(matrix, &rows, nullptr));
  FBI_PETSC(MatGetLocalSize(matrix, &own, nullptr));
  if (comm_.any(factors_ == nullptr || rows != rows_ || own != own_rows_)) start(matrix);
  rows_ = rows;
  own_rows_ = own;
  FBI_PETSC(KSPSetOperators(ksp_, matrix, matrix));
  PC pc = nullptr;
  FBI_PETSC(KSPGetPC(ksp_, &pc));
  PCFailedReason reason = PC_NOERROR;
  const bool failed = PCSetUp(pc) != 0 || PCGetFailedReason(factors_, &reason) != 0 || reason != PC_NOERROR;
  return !comm_.any(failed);
}

void DirectSolver::solve(Vec b, Vec x) { FBI_PETSC(KSPSolve(ksp_, b, x)); }

}  // namespace fbi::linalg
