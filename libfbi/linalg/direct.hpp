/// Sparse direct solution by MUMPS, through PETSc.
#pragma once

#include "base/comm.hpp"
#include "linalg/petsc.hpp"

namespace fbi::linalg {

/// LU factors of a distributed AIJ matrix.
///
/// Parallel factors add contributions of other ranks as they arrive, so their last digits change from run to run. Small
/// matrices are therefore factorised whole by every rank, which is repeatable and hardly slower; large ones in
/// parallel.
class DirectSolver {
 public:
  explicit DirectSolver(const Comm& comm);

  /// Factorises `matrix`; returns false (on every rank) when it is singular or not finite. Collective.
  bool factorize(Mat matrix);
  /// Solves with the last factors. Collective.
  void solve(Vec b, Vec x);

 private:
  void start(Mat matrix);

  Comm comm_;
  KspHandle ksp_;
  PC factors_ = nullptr;                // owned by ksp_, perhaps through an inner solver; null before the first matrix
  PetscInt rows_ = -1, own_rows_ = -1;  // of the matrix that ksp_ was made for
};

}  // namespace fbi::linalg
