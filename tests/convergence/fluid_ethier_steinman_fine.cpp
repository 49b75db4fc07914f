// The finest pair of meshes, 16 and 32 cells a side, with the Krylov solver of the program: orders in space of velocity and
// pressure, and agreement with the sparse factorisation on the coarse mesh.
#include "convergence/ethier_steinman.hpp"
#include "fsi/monolithic.hpp"

namespace fbi::fluid::test {
namespace {

/// Errors at t = 0.1 after `steps` steps with theta = 1/2, solved by the program's own nonlinear and linear solvers.
Errors program_errors(int cells, int steps) {
  const std::vector<double> x = uniform(-1, 1, cells);
  const mesh::HexMesh mesh = box_mesh(Comm(MPI_COMM_SELF), {x, x, x}, false, 0);
  FluidField field(mesh, Flow::fluid(true), Flow::boundaries(), {TimeScheme::one_step_theta, 0.5});
  field.initialize();
  fsi::SolverParameters solver;
  solver.newton_tolerance = 1e-8;
  solver.linear = fsi::LinearSolver::iterative;
  fsi::System system(&field, nullptr, nullptr, {}, {}, solver);
  int krylov = 0, newton = 0;
  for (int n = 1; n <= steps; ++n) {
    system.begin_step(0.1 * n / steps, 0.1 / steps);
    const fsi::StepReport report = fsi::solve_monolithic(system);
    EXPECT_TRUE(report.converged) << "step " << n << " residual " << report.residual;
    if (!report.converged) break;
    krylov += report.krylov;
    newton += report.newton;
    system.accept_step();
  }
  const Errors e = errors(field, [](const Vec3& p, double* value) { exact(p, 0.1, value); });
  std::printf("%d cells a side: velocity %.4e pressure %.4e, %.1f Krylov iterations a linear solve\n", cells, e.velocity,
              e.pressure, static_cast<double>(krylov) / newton);
  return e;
}

TEST(EthierSteinmanFine, OrderInSpace) {
  linalg::initialize_petsc();
  const Errors coarse = program_errors(16, 40);
  const Errors fine = program_errors(32, 40), order = orders(coarse, fine, 2);
  record_orders("16 to 32 cells a side, tau_time on, the program's solvers", fine, order, "order 1.9", "order 1.4");
  EXPECT_GE(order.velocity, 1.9);
  EXPECT_GE(order.pressure, 1.4);
}

}  // namespace
}  // namespace fbi::fluid::test
