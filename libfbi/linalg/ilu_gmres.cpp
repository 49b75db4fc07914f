#include "linalg/ilu_gmres.hpp"

#include <cmath>

namespace fbi::linalg {

IluGmres::IluGmres(const Comm& comm, int level, int restart, int maximum)
    : comm_(comm), level_(level), maximum_(maximum) {
  FBI_PETSC(KSPCreate(comm_.get(), ksp_.out()));
  FBI_PETSC(KSPSetType(ksp_, KSPGMRES));
  FBI_PETSC(KSPGMRESSetRestart(ksp_, restart));
  FBI_PETSC(KSPSetPCSide(ksp_, PC_RIGHT));
  FBI_PETSC(KSPSetNormType(ksp_, KSP_NORM_UNPRECONDITIONED));
  PC pc = nullptr;
  FBI_PETSC(KSPGetPC(ksp_, &pc));
  FBI_PETSC(PCSetType(pc, PCBJACOBI));
}

bool IluGmres::factorize(Mat matrix) {
  FBI_PETSC(KSPSetOperators(ksp_, matrix, matrix));
  FBI_PETSC(KSPSetUp(ksp_));
  PC pc = nullptr, factors = nullptr;
  FBI_PETSC(KSPGetPC(ksp_, &pc));
  KSP* block = nullptr;
  FBI_PETSC(PCBJacobiGetSubKSP(pc, nullptr, nullptr, &block));
  FBI_PETSC(KSPGetPC(block[0], &factors));
  if (!has_blocks_) {
    FBI_PETSC(KSPSetType(block[0], KSPPREONLY));
    FBI_PETSC(PCSetType(factors, PCILU));
    FBI_PETSC(PCFactorSetLevels(factors, level_));
    has_blocks_ = true;
  }
  PCFailedReason reason = PC_NOERROR;
  const bool failed =
      KSPSetUpOnBlocks(ksp_) != 0 || PCGetFailedReasonRank(factors, &reason) != 0 || reason != PC_NOERROR;
  return !comm_.any(failed);
}

KrylovResult IluGmres::solve(Vec b, Vec x, double tolerance) {
  FBI_PETSC(KSPSetTolerances(ksp_, tolerance, PETSC_DEFAULT, 1e10, maximum_));
  return solve_from_zero(ksp_, b, x);
}

}  // namespace fbi::linalg
