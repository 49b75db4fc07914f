/// Flexible GMRES on function objects, by PETSc.
#pragma once

#include <functional>

#include "base/comm.hpp"
#include "linalg/petsc.hpp"

namespace fbi::linalg {

/// What a linear solve reports.
struct KrylovResult {
  int iterations = 0;
  double relative_residual = 0.0;  ///< last residual norm over the norm of the right-hand side
  bool converged = false;
  bool stalled = false;  ///< given up before the iterations were used up
};

/// y = A x, or x = P^-1 r: both arguments are distributed vectors of the layout given at construction.
using VectorMap = std::function<void(Vec in, Vec out)>;

/// Solves with a prepared solver from x = 0 and reports; b = 0 gives x = 0, a b that is not finite does not converge.
/// Collective.
KrylovResult solve_from_zero(KSP solver, Vec b, Vec x);

/// Right-preconditioned flexible GMRES.
class Krylov {
 public:
  /// `layout` fixes the distribution of vectors. Collective.
  Krylov(const Comm& comm, Vec layout, VectorMap matrix, VectorMap preconditioner);
  ~Krylov();
  Krylov(const Krylov&) = delete;
  Krylov& operator=(const Krylov&) = delete;

  /// Solves A x = b from x = 0 until |b - A x| <= tolerance |b|, in at most `maximum` iterations. The same on every
  /// rank. Collective.
  KrylovResult solve(Vec b, Vec x, double tolerance, int maximum);

 private:
  VectorMap matrix_, preconditioner_;
  MatHandle shell_;
  KspHandle ksp_;
};

}  // namespace fbi::linalg
