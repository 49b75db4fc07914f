// Small time steps on a fixed mesh, the short version of the map of docs/pressure-stabilization.md; and what the
// pressure projection costs the Krylov solver.
#include <gtest/gtest.h>

#include "convergence/pressure_study.hpp"
#include "fsi/monolithic.hpp"
#include "record.hpp"

namespace fbi::fluid::test {
namespace {

// A start that is not divergence-free for the discrete equations. With PSPG and the time step in tau the pressure error
// of the first steps grows as 1/dt and is rough; with tau of the steady limit it stays bounded and rough; with the
// projection it is bounded and smooth.
TEST(PressureSmallSteps, StartFromNodalValues) {
  linalg::initialize_petsc();
  const char* names[] = {"PSPG", "PSPG, tau_time off", "projection"};
  PressureErrors at[3][2];
  for (int m = 0; m < 3; ++m) {
    const PressureStudy study(4, 1.0, methods[m]);
    for (int k = 0; k < 2; ++k) {
      const double number = k == 0 ? 1e-3 : 1e-4;
      at[m][k] = study.run(number / study.number(1.0), {10})[0];
      std::printf("%s, mu dt/(rho h^2) = %g, step 10: velocity %.3e pressure %.3e roughness %.3g\n", names[m], number,
                  at[m][k].velocity, at[m][k].pressure, at[m][k].roughness);
    }
    fbi::test::record({.section = "Fluid",
                       .id = "S-F1",
                       .check = std::string("growth of the pressure error when the time step falls by 10, mu dt/(rho "
                                            "h^2) = 1e-4, tenth step after a start from nodal values: ") +
                                names[m],
                       .source = "John, Novo 2015",
                       .ours = at[m][1].pressure / at[m][0].pressure,
                       .reference_text = m == 0 ? "10 (error as 1/dt)" : "1 (bounded)",
                       .bar = m == 0 ? "5 to 20" : "< 2.5"});
  }
  EXPECT_GT(at[0][1].pressure / at[0][0].pressure, 5);
  EXPECT_LT(at[0][1].pressure / at[0][0].pressure, 20);
  EXPECT_GT(at[0][1].roughness, 10);
  for (const int m : {1, 2}) EXPECT_LT(at[m][1].pressure / at[m][0].pressure, 2.5);
  EXPECT_LT(at[2][1].roughness, 2.5);
  EXPECT_LT(at[2][1].pressure, 0.2 * at[1][1].pressure);
}

double krylov_iterations(const FluidParameters& p, double warp, double dt) {
  const std::vector<double> x = uniform(-1, 1, 12);
  const mesh::HexMesh mesh = box_mesh(Comm(MPI_COMM_SELF), {x, x, x}, false, warp);
  FluidField field(mesh, p, Flow::boundaries(), {TimeScheme::one_step_theta, 0.5});
  field.initialize();
  fsi::SolverParameters solver;
  solver.linear = fsi::LinearSolver::iterative;
  solver.newton_tolerance = 2.2e-2;  // loose: solves in single precision, with PSPG, have no sweeps then either
  solver.krylov_tolerance = 1.1e-2;
  fsi::System system(&field, nullptr, nullptr, {}, {}, solver);
  int krylov = 0, newton = 0;
  for (int n = 1; n <= 4; ++n) {
    system.begin_step(dt * n, dt);
    const fsi::StepReport report = fsi::solve_monolithic(system);
    EXPECT_TRUE(report.converged);
    krylov += report.krylov;
    newton += report.newton;
    system.accept_step();
  }
  return static_cast<double>(krylov) / newton;
}

// On a box the pressure operator is solved exactly, on general cells by one multigrid cycle. Without its part for the
// projection the solver takes five times the iterations in small steps.
TEST(PressureSmallSteps, KrylovIterationsWithTheProjection) {
  linalg::initialize_petsc();
  for (const double warp : {0.0, 0.1})
    for (const double dt : {1e-2, 1e-3, 1e-4}) {
      FluidParameters p = Flow::fluid(true);
      const double pspg = krylov_iterations(p, warp, dt);
      p.pressure_stabilization = PressureStabilization::projection;
      const double projection = krylov_iterations(p, warp, dt);
      std::printf("%s, dt %g: %.1f Krylov iterations a linear solve with PSPG, %.1f with the projection\n",
                  warp > 0 ? "general cells" : "box", dt, pspg, projection);
      EXPECT_LE(projection, 1.5 * pspg + 2);
    }
}

}  // namespace
}  // namespace fbi::fluid::test
