/// GMRES with incomplete factors of an assembled matrix, by PETSc.
#pragma once

#include "base/comm.hpp"
#include "linalg/krylov.hpp"
#include "linalg/petsc.hpp"

namespace fbi::linalg {

/// Right-preconditioned GMRES(m) with ILU(k) of the rows and columns of every rank (block Jacobi over ranks), in the
/// order of the unknowns. The general-purpose solver that special ones are compared with.
class IluGmres {
 public:
  /// `level` of fill k >= 0; `restart` m, directions kept; `maximum` bounds the iterations of one solve. Collective.
  IluGmres(const Comm& comm, int level, int restart, int maximum);

  /// Computes the incomplete factors of a distributed AIJ matrix, which must live until the next call; false on all
  /// ranks when a pivot is zero or not finite. Collective.
  bool factorize(Mat matrix);
  /// Solves A x = b from x = 0 until |b - A x| <= tolerance |b|. The same on every rank. Collective.
  KrylovResult solve(Vec b, Vec x, double tolerance);

 private:
  Comm comm_;
  KspHandle ksp_;
  int level_, maximum_;
  bool has_blocks_ = false;
};

}  // namespace fbi::linalg
