/// Sparse direct solution: right on any number of ranks, repeatable, and a status instead of an error where it cannot
/// work.
#include "linalg/direct.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace {

using namespace fbi;
using linalg::MatHandle;
using linalg::VecHandle;

constexpr PetscInt rows = 60;

/// Tridiagonal matrix with 2 + d on the diagonal.
MatHandle tridiagonal(const Comm& comm, double d) {
  MatHandle matrix;
  FBI_PETSC(MatCreateAIJ(comm.get(), PETSC_DECIDE, PETSC_DECIDE, rows, rows, 3, nullptr, 3, nullptr, matrix.out()));
  PetscInt begin = 0, end = 0;
  FBI_PETSC(MatGetOwnershipRange(matrix, &begin, &end));
  for (PetscInt i = begin; i < end; ++i)
    for (PetscInt j = std::max<PetscInt>(i - 1, 0); j < std::min(i + 2, rows); ++j)
      FBI_PETSC(MatSetValue(matrix, i, j, i == j ? 2.0 + d : -1.0, INSERT_VALUES));
  FBI_PETSC(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  FBI_PETSC(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  return matrix;
}

/// Largest |A x - b| for b = 1 after solving.
double residual_of(linalg::DirectSolver& solver, Mat matrix) {
  VecHandle x, b;
  FBI_PETSC(MatCreateVecs(matrix, x.out(), b.out()));
  FBI_PETSC(VecSet(b, 1.0));
  solver.solve(b, x);
  VecHandle r;
  FBI_PETSC(VecDuplicate(b, r.out()));
  FBI_PETSC(MatMult(matrix, x, r));
  FBI_PETSC(VecAXPY(r, -1.0, b));
  PetscReal largest = 0.0;
  FBI_PETSC(VecNorm(r, NORM_INFINITY, &largest));
  return largest;
}

}  // namespace

TEST(DirectSolver, SolvesAgainAfterTheMatrixChanged) {
  linalg::initialize_petsc();
  const Comm comm;
  linalg::DirectSolver solver(comm);
  for (const double d : {0.0, 3.0, 0.1}) {
    const MatHandle matrix = tridiagonal(comm, d);
    ASSERT_TRUE(solver.factorize(matrix));
    EXPECT_LT(residual_of(solver, matrix), 1e-11) << d;
  }
}

TEST(DirectSolver, SaysThatAMatrixCannotBeFactorised) {
  linalg::initialize_petsc();
  const Comm comm;
  // The row of one rank is empty, so is the column.
  MatHandle matrix = tridiagonal(comm, 1.0);
  const PetscInt row = 7;
  FBI_PETSC(MatZeroRowsColumns(matrix, 1, &row, 0.0, nullptr, nullptr));
  linalg::DirectSolver singular(comm);
  EXPECT_FALSE(singular.factorize(matrix));
  // It works again with a matrix that is regular.
  const MatHandle regular = tridiagonal(comm, 1.0);
  linalg::DirectSolver solver(comm);
  ASSERT_TRUE(solver.factorize(regular));
  EXPECT_LT(residual_of(solver, regular), 1e-12);
}
