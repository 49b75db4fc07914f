/// Newton steps of the fluid alone for the convergence tests: GMRES on the matrix-free tangent, preconditioned by a
/// sparse factorisation of the assembled one that is kept while it helps; and error norms.
#pragma once

#include <Eigen/LU>
#include <functional>

#include "fem/hex8.hpp"
#include "fem/quadrature.hpp"
#include "unit/fluid/fluid_fixture.hpp"

namespace fbi::fluid::test {

/// Serial solver of one step.
class StepSolver {
 public:
  explicit StepSolver(FluidField& field) : field_(field), r_(field.create_vector()), delta_(field.create_vector()) {
    const PetscInt n = 4 * field.mesh().owned_nodes;
    FBI_PETSC(MatCreateShell(PETSC_COMM_SELF, n, n, n, n, &field_, shell_.out()));
    FBI_PETSC(MatShellSetOperation(shell_, MATOP_MULT, reinterpret_cast<void (*)(void)>(&StepSolver::multiply)));
    FBI_PETSC(KSPCreate(PETSC_COMM_SELF, solver_.out()));
    FBI_PETSC(KSPSetType(solver_, KSPFGMRES));
    FBI_PETSC(KSPSetTolerances(solver_, 1e-8, 1e-300, 1e10, 60));
    PC pc = nullptr;
    FBI_PETSC(KSPGetPC(solver_, &pc));
    FBI_PETSC(PCSetType(pc, PCLU));
    FBI_PETSC(PCFactorSetMatSolverType(pc, MATSOLVERMUMPS));
  }

  /// Solves the step that the field has begun; returns the number of Newton iterations.
  int solve(double tolerance = 1e-10) {
    double start = 0;
    for (int iteration = 0; iteration < 20; ++iteration) {
      field_.residual(r_);
      if (field_.pressure_is_free()) balance();
      PetscReal norm = 0;
      FBI_PETSC(VecNorm(r_, NORM_2, &norm));
      if (iteration == 0) start = norm;
      if (norm <= tolerance * start || norm < 1e-14) return iteration;
      field_.linearize();
      if (!matrix_ || sigma_ != field_.sigma() || slow_) factor();
      FBI_PETSC(KSPSolve(solver_, r_, delta_));
      PetscInt count = 0;
      KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
      FBI_PETSC(KSPGetIterationNumber(solver_, &count));
      FBI_PETSC(KSPGetConvergedReason(solver_, &reason));
      if (reason < 0) throw Error(ExitCode::diverged, "linear solver of the test");
      slow_ = count > 15;
      FBI_PETSC(VecScale(delta_, -1));
      field_.increment(delta_);
      PetscReal change = 0, size = 0;
      FBI_PETSC(VecNorm(delta_, NORM_2, &change));
      FBI_PETSC(VecNorm(field_.iterate(), NORM_2, &size));
      if (change <= 1e-11 * size) return iteration + 1;  // round-off of a residual that was small from the start
    }
    throw Error(ExitCode::diverged, "Newton iteration of the test");
  }

 private:
  static PetscErrorCode multiply(Mat matrix, Vec x, Vec y) {
    FluidField* field = nullptr;
    MatShellGetContext(matrix, &field);
    field->apply_jacobian(x, y);
    return 0;
  }
  // The continuity rows sum to zero for a tangent with all boundary velocities given: so must the right-hand side.
  void balance() {
    PetscScalar* a = nullptr;
    FBI_PETSC(VecGetArray(r_, &a));
    const std::vector<double>& volume = field_.lumped_volume();
    double sum = 0, total = 0;
    for (std::size_t n = 0; n < volume.size(); ++n) {
      sum += a[4 * n + 3];
      total += volume[n];
    }
    for (std::size_t n = 0; n < volume.size(); ++n) a[4 * n + 3] -= sum * volume[n] / total;
    FBI_PETSC(VecRestoreArray(r_, &a));
  }
  void factor() {
    const linalg::MatHandle assembled = field_.assemble_jacobian();
    FBI_PETSC(MatDuplicate(assembled, MAT_COPY_VALUES, matrix_.out()));
    if (field_.pressure_is_free()) {
      const PetscInt row = 3;  // any pressure level: one pressure unknown is held
      FBI_PETSC(MatZeroRowsColumns(matrix_, 1, &row, 1.0, nullptr, nullptr));
    }
    FBI_PETSC(KSPSetOperators(solver_, shell_, matrix_));
    FBI_PETSC(KSPSetUp(solver_));
    sigma_ = field_.sigma();
    slow_ = false;
  }

  FluidField& field_;
  linalg::VecHandle r_, delta_;
  linalg::MatHandle shell_, matrix_;
  linalg::KspHandle solver_;
  double sigma_ = -1;
  bool slow_ = false;
};

struct Errors {
  double velocity = 0;  ///< L2 norm
  double pressure = 0;  ///< L2 norm, mean of the difference removed
};

/// L2 norms of the difference between the iterate and exact(x, value[4]); 3 x 3 x 3 Gauss points a cell.
inline Errors errors(FluidField& field, const std::function<void(const Vec3&, double*)>& exact) {
  const mesh::HexMesh& mesh = field.mesh();
  LocalArray u(field.iterate());
  const fem::QuadratureRule rule = fem::gauss_legendre(3);
  double velocity = 0, pressure = 0, mean = 0, volume = 0;
  for (Index cell = 0; cell < mesh.local_cells(); ++cell) {
    Eigen::Matrix<double, 3, 8> x;
    Eigen::Matrix<double, 4, 8> values;
    for (int a = 0; a < 8; ++a) {
      const Index n = mesh.cells[8 * static_cast<std::size_t>(cell) + a];
      for (int i = 0; i < 3; ++i) x(i, a) = mesh.node(n)[i];
      for (int c = 0; c < 4; ++c) values(c, a) = u[4 * static_cast<std::size_t>(n) + c];
    }
    for (int q = 0; q < 27; ++q) {
      const Vec3 xi(rule.points[q % 3], rule.points[q / 3 % 3], rule.points[q / 9]);
      const double weight = rule.weights[q % 3] * rule.weights[q / 3 % 3] * rule.weights[q / 9];
      const std::array<double, 8> n = fem::hex8_shape(xi);
      const Eigen::Map<const Eigen::Matrix<double, 8, 1>> shape(n.data());
      const Mat3 jacobian = x * fem::hex8_gradient(xi);
      const double w = weight * jacobian.determinant();
      const Vec3 at = x * shape;
      const Eigen::Vector4d computed = values * shape;
      double value[4];
      exact(at, value);
      for (int i = 0; i < 3; ++i) velocity += w * (computed[i] - value[i]) * (computed[i] - value[i]);
      const double difference = computed[3] - value[3];
      pressure += w * difference * difference;
      mean += w * difference;
      volume += w;
    }
  }
  return {std::sqrt(velocity), std::sqrt(std::max(0.0, pressure - mean * mean / volume))};
}

}  // namespace fbi::fluid::test
