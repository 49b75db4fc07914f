/// The tensor solve against an assembled hex8 Laplacian on a graded box, with natural and Robin ends.
#include "linalg/tensor_poisson.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "fem/hex8.hpp"
#include "fem/quadrature.hpp"

namespace fbi::linalg {
namespace {

mesh::HexMesh make_mesh(const Comm& comm, std::array<int, 3> cells, bool general = false) {
  std::array<std::vector<double>, 3> x;
  for (int d = 0; d < 3; ++d)
    for (int i = 0; i <= cells[d]; ++i) x[d].push_back(std::pow(static_cast<double>(i) / cells[d], 1.0 + 0.2 * d));
  return mesh::distribute(comm, mesh::chunk_of(comm, mesh::make_box(x, general)));
}

/// int grad N_a . grad N_b plus robin times int N_a N_b on the faces x = 0 and x = 1.
MatHandle assemble(const mesh::HexMesh& mesh, double robin_low, double robin_high) {
  MatHandle matrix;
  const PetscInt n = mesh.owned_nodes, all = static_cast<PetscInt>(mesh.global_nodes);
  FBI_PETSC(MatCreateAIJ(mesh.comm.get(), n, n, all, all, 27, nullptr, 27, nullptr, matrix.out()));
  FBI_PETSC(MatSetOption(matrix, MAT_NEW_NONZERO_ALLOCATION_ERR, PETSC_FALSE));
  const fem::QuadratureRule rule = fem::gauss_legendre(2);
  for (Index c = 0; c < mesh.local_cells(); ++c) {
    Eigen::Matrix<double, 3, 8> x;
    PetscInt number[8];
    for (int a = 0; a < 8; ++a) {
      const Index node = mesh.cells[8 * static_cast<std::size_t>(c) + a];
      x.col(a) = Eigen::Map<const Vec3>(mesh.node(node));
      number[a] = static_cast<PetscInt>(mesh.node_number[node]);
    }
    Eigen::Matrix<double, 8, 8, Eigen::RowMajor> k = Eigen::Matrix<double, 8, 8>::Zero();
    for (int q = 0; q < 8; ++q) {
      const Vec3 xi(rule.points[q % 2], rule.points[q / 2 % 2], rule.points[q / 4]);
      const Eigen::Matrix<double, 8, 3> reference = fem::hex8_gradient(xi);
      const Mat3 jacobian = x * reference;
      const Eigen::Matrix<double, 8, 3> gradient = reference * jacobian.inverse();
      k += jacobian.determinant() * gradient * gradient.transpose();
    }
    for (const auto& [end, robin, face] : {std::tuple(0.0, robin_low, 0), std::tuple(1.0, robin_high, 1)}) {
      if (std::abs(x(0, fem::hex8_faces[face][0]) - end) > 1e-12) continue;
      const double area = (x(1, 2) - x(1, 0)) * (x(2, 4) - x(2, 0));
      for (const int a : fem::hex8_faces[face])
        for (const int b : fem::hex8_faces[face]) {
          double factor = robin * area;
          for (int d = 1; d < 3; ++d) factor *= fem::hex8_corners[a][d] == fem::hex8_corners[b][d] ? 1.0 / 3 : 1.0 / 6;
          k(a, b) += factor;
        }
    }
    FBI_PETSC(MatSetValues(matrix, 8, number, 8, number, k.data(), ADD_VALUES));
  }
  FBI_PETSC(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  FBI_PETSC(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  return matrix;
}

enum class Precision { full, single };

/// |L x - b| / |b| for a right-hand side that sums to zero when the operator is singular.
double residual(const mesh::HexMesh& mesh, double robin_low, double robin_high, Precision precision = Precision::full) {
  const MatHandle matrix = assemble(mesh, robin_low, robin_high);
  VecHandle b, x, r;
  FBI_PETSC(MatCreateVecs(matrix, x.out(), b.out()));
  FBI_PETSC(VecDuplicate(b, r.out()));
  double* values = nullptr;
  FBI_PETSC(VecGetArray(b, &values));
  for (Index a = 0; a < mesh.owned_nodes; ++a) values[a] = std::sin(1.7 * static_cast<double>(mesh.node_id[a]));
  FBI_PETSC(VecRestoreArray(b, &values));
  if (robin_low == 0.0 && robin_high == 0.0) {
    PetscScalar sum = 0.0;
    FBI_PETSC(VecSum(b, &sum));
    FBI_PETSC(VecShift(b, -sum / static_cast<double>(mesh.global_nodes)));
  }
  TensorPoisson solver(mesh, {{{robin_low, robin_high}, {0.0, 0.0}, {0.0, 0.0}}});
  if (precision == Precision::full) {
    solver.apply(b, x);
  } else {
    std::vector<float> right(mesh.owned_nodes), solution(mesh.owned_nodes);
    FBI_PETSC(VecGetArray(b, &values));
    for (Index a = 0; a < mesh.owned_nodes; ++a) right[a] = static_cast<float>(values[a]);
    FBI_PETSC(VecRestoreArray(b, &values));
    solver.apply(right.data(), solution.data());
    FBI_PETSC(VecGetArray(x, &values));
    for (Index a = 0; a < mesh.owned_nodes; ++a) values[a] = static_cast<double>(solution[a]);
    FBI_PETSC(VecRestoreArray(x, &values));
  }
  FBI_PETSC(MatMult(matrix, x, r));
  FBI_PETSC(VecAXPY(r, -1.0, b));
  PetscReal error = 0.0, norm = 0.0;
  FBI_PETSC(VecNorm(r, NORM_2, &error));
  FBI_PETSC(VecNorm(b, NORM_2, &norm));
  return error / norm;
}

TEST(TensorPoisson, solves_exactly_on_slabs_along_any_direction) {
  initialize_petsc();
  const Comm comm;
  for (const std::array<int, 3> cells : {std::array<int, 3>{12, 5, 4}, {5, 12, 4}, {4, 5, 12}, {70, 2, 3}}) {
    const mesh::HexMesh mesh = make_mesh(comm, cells);
    ASSERT_TRUE(TensorPoisson::supports(mesh));
    EXPECT_LT(residual(mesh, 0.0, 36.0), 1e-11);
    EXPECT_LT(residual(mesh, 2.0, 0.0), 1e-11);
    EXPECT_LT(residual(mesh, 0.0, 0.0), 1e-11) << "singular";
  }
}

TEST(TensorPoisson, solves_exactly_on_blocks) {
  initialize_petsc();
  const Comm comm;
  for (const std::array<int, 3> cells : {std::array<int, 3>{7, 8, 6}, {9, 9, 9}, {4, 4, 5}}) {
    const mesh::HexMesh mesh = make_mesh(comm, cells);
    ASSERT_TRUE(TensorPoisson::supports(mesh));
    EXPECT_LT(residual(mesh, 0.0, 36.0), 1e-11);
    EXPECT_LT(residual(mesh, 0.0, 0.0), 1e-11) << "singular";
  }
}

TEST(TensorPoisson, solves_where_ranks_own_nothing) {
  initialize_petsc();
  const Comm comm;
  const mesh::HexMesh mesh = make_mesh(comm, {2, 1, 1});
  ASSERT_TRUE(TensorPoisson::supports(mesh));
  EXPECT_LT(residual(mesh, 0.0, 36.0), 1e-11);
  EXPECT_LT(residual(mesh, 0.0, 0.0), 1e-11) << "singular";
}

TEST(TensorPoisson, solves_in_single_precision) {
  initialize_petsc();
  const Comm comm;
  for (const std::array<int, 3> cells : {std::array<int, 3>{40, 5, 4}, {9, 8, 7}}) {
    const mesh::HexMesh mesh = make_mesh(comm, cells);
    EXPECT_LT(residual(mesh, 0.0, 36.0, Precision::single), 1e-4);
    EXPECT_LT(residual(mesh, 0.0, 0.0, Precision::single), 1e-4) << "singular";
  }
}

TEST(TensorPoisson, is_offered_for_boxes_only) {
  initialize_petsc();
  const Comm comm;
  EXPECT_FALSE(TensorPoisson::supports(make_mesh(comm, {6, 5, 4}, true)));
}

}  // namespace
}  // namespace fbi::linalg
