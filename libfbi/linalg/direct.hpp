/// Sparse direct solution by MUMPS, through PETSc.
#pragma once

#include "base/comm.hpp"
#include "linalg/petsc.hpp"

namespace fbi::linalg {

/// LU factors of a distributed AIJ matrix.
class DirectSolver {
 public:
  explicit DirectSolver(const Comm& comm);

  /// Factorises `matrix`; returns false (on every rank) when it is singular or not finite. Collective.
  bool factorize(Mat matrix);
  /// Solves with the last factors. Collective.
  void solve(Vec b, Vec x);

 private:
  KspHandle ksp_;
};

}  // namespace fbi::linalg
