/// The Krylov wrapper and the direct solver on a distributed one-dimensional convection-diffusion matrix.
#include "linalg/krylov.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "linalg/direct.hpp"

namespace fbi::linalg {
namespace {

constexpr PetscInt size = 40;

MatHandle make_matrix(const Comm& comm) {
  MatHandle matrix;
  FBI_PETSC(MatCreateAIJ(comm.get(), PETSC_DECIDE, PETSC_DECIDE, size, size, 3, nullptr, 2, nullptr, matrix.out()));
  PetscInt begin = 0, end = 0;
  FBI_PETSC(MatGetOwnershipRange(matrix, &begin, &end));
  for (PetscInt i = begin; i < end; ++i) {
    FBI_PETSC(MatSetValue(matrix, i, i, 2.5, INSERT_VALUES));
    if (i > 0) FBI_PETSC(MatSetValue(matrix, i, i - 1, -1.3, INSERT_VALUES));
    if (i + 1 < size) FBI_PETSC(MatSetValue(matrix, i, i + 1, -0.7, INSERT_VALUES));
  }
  FBI_PETSC(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  FBI_PETSC(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  return matrix;
}

double true_residual(Mat matrix, Vec b, Vec x) {
  VecHandle r;
  FBI_PETSC(VecDuplicate(b, r.out()));
  FBI_PETSC(MatMult(matrix, x, r));
  FBI_PETSC(VecAXPY(r, -1.0, b));
  PetscReal residual = 0.0, norm = 0.0;
  FBI_PETSC(VecNorm(r, NORM_2, &residual));
  FBI_PETSC(VecNorm(b, NORM_2, &norm));
  return residual / norm;
}

TEST(Krylov, reaches_the_true_residual_it_reports) {
  initialize_petsc();
  const Comm comm;
  const MatHandle matrix = make_matrix(comm);
  VecHandle b, x;
  FBI_PETSC(MatCreateVecs(matrix, x.out(), b.out()));
  FBI_PETSC(VecSet(b, 1.0));
  int applications = 0;
  Krylov krylov(
      comm, b,
      [&](Vec in, Vec out) {
        ++applications;
        FBI_PETSC(MatMult(matrix, in, out));
      },
      [](Vec in, Vec out) { FBI_PETSC(VecCopy(in, out)); });
  for (const double tolerance : {1e-3, 1e-10}) {
    const KrylovResult result = krylov.solve(b, x, tolerance, 100);
    EXPECT_TRUE(result.converged);
    EXPECT_LE(true_residual(matrix, b, x), 1.01 * tolerance);
    EXPECT_NEAR(true_residual(matrix, b, x), result.relative_residual, 1e-12);
  }
  EXPECT_GT(applications, 10);
}

TEST(Krylov, says_so_when_it_does_not_converge) {
  initialize_petsc();
  const Comm comm;
  const MatHandle matrix = make_matrix(comm);
  VecHandle b, x;
  FBI_PETSC(MatCreateVecs(matrix, x.out(), b.out()));
  FBI_PETSC(VecSet(b, 1.0));
  Krylov krylov(
      comm, b, [&](Vec in, Vec out) { FBI_PETSC(MatMult(matrix, in, out)); },
      [](Vec in, Vec out) { FBI_PETSC(VecCopy(in, out)); });
  const KrylovResult result = krylov.solve(b, x, 1e-10, 3);
  EXPECT_FALSE(result.converged);
  EXPECT_EQ(result.iterations, 3);
}

TEST(DirectSolver, solves_to_round_off) {
  initialize_petsc();
  const Comm comm;
  const MatHandle matrix = make_matrix(comm);
  VecHandle b, x;
  FBI_PETSC(MatCreateVecs(matrix, x.out(), b.out()));
  FBI_PETSC(VecSet(b, 1.0));
  DirectSolver solver(comm);
  ASSERT_TRUE(solver.factorize(matrix));
  solver.solve(b, x);
  EXPECT_LT(true_residual(matrix, b, x), 1e-13);
}

}  // namespace
}  // namespace fbi::linalg
