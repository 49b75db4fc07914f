// Kovasznay (1948): steady plane flow behind a grid at Re = 40, extruded by one cell; exact velocities on the sides.
#include <gtest/gtest.h>

#include "convergence/fluid_solver.hpp"
#include "record.hpp"

namespace fbi::fluid::test {
namespace {

const double lambda = 20 - std::sqrt(400 + 4 * M_PI * M_PI);  // Re/2 - sqrt(Re^2/4 + 4 pi^2) = -0.9637405442

void exact(const Vec3& x, double* value) {
  const double decay = std::exp(lambda * x[0]);
  value[0] = 1 - decay * std::cos(2 * M_PI * x[1]);
  value[1] = lambda / (2 * M_PI) * decay * std::sin(2 * M_PI * x[1]);
  value[2] = 0;
  value[3] = 0.5 * (1 - decay * decay);
}

struct Kovasznay {
  mesh::HexMesh mesh;
  FluidField field;
  Kovasznay(int cells, const FluidParameters& p, bool general)
      : mesh(box_mesh(Comm(MPI_COMM_SELF),
                      {uniform(-0.5, 1, 3 * cells / 2), uniform(-0.5, 0.5, cells), uniform(0, 1.0 / cells, 1)},
                      general)),
        field(mesh, p, boundaries(), {TimeScheme::steady, 1.0}) {
    field.initialize();
    StepSolver solver(field);
    // with tau of the step, tau follows the velocity by repeated solves
    for (int n = 0; n < (p.tau_update == TauUpdate::iteration ? 1 : 8); ++n) {
      field.begin_step(0, 0);
      iterations += solver.solve();
      field.accept_step();
    }
  }
  int iterations = 0;
  static input::VectorExpression formulas() {
    const std::string l = "(20-sqrt(400+4*pi^2))";
    return expressions("1-exp(" + l + "*x)*cos(2*pi*y)", l + "/(2*pi)*exp(" + l + "*x)*sin(2*pi*y)", "0");
  }
  static BoundaryConditions boundaries() {
    BoundaryConditions all;
    for (const char* face : {"xmin", "xmax", "ymin", "ymax"}) all[face] = velocity(formulas());
    for (const char* face : {"zmin", "zmax"}) all[face] = of_type(BoundaryType::slip);
    return all;
  }
  Errors error() { return errors(field, exact); }
};

FluidParameters fluid() {
  FluidParameters p;
  p.density = 1;
  p.viscosity = 1.0 / 40;
  p.initial_velocity = Kovasznay::formulas();
  return p;
}

struct Variant {
  const char* name;
  void (*set)(FluidParameters&);
  bool general = false;
};

const Variant variants[] = {
    {"advective", [](FluidParameters&) {}},
    {"advective, general cells", [](FluidParameters&) {}, true},
    {"conservative", [](FluidParameters& p) { p.convective_form = ConvectiveForm::conservative; }},
    {"skew", [](FluidParameters& p) { p.convective_form = ConvectiveForm::skew; }},
    {"whiting_jansen", [](FluidParameters& p) { p.tau = Tau::whiting_jansen; }},
    {"taylor_hughes_zarins at the points",
     [](FluidParameters& p) {
       p.tau = Tau::taylor_hughes_zarins;
       p.tau_at = TauAt::quadrature_points;
     }},
    {"projection", [](FluidParameters& p) { p.pressure_stabilization = PressureStabilization::projection; }},
};

TEST(Kovasznay, OrderTwo) {
  linalg::initialize_petsc();
  EXPECT_NEAR(lambda, -0.9637405442, 1e-10);
  for (const Variant& variant : variants) {
    FluidParameters p = fluid();
    variant.set(p);
    const Errors coarse = Kovasznay(24, p, variant.general).error(), fine = Kovasznay(48, p, variant.general).error();
    const double velocity = std::log2(coarse.velocity / fine.velocity),
                 pressure = std::log2(coarse.pressure / fine.pressure);
    const double depth = std::sqrt(48.0);  // errors per unit depth
    std::printf("%s: velocity %.3e order %.3f, pressure %.3e order %.3f\n", variant.name, fine.velocity * depth,
                velocity - 0.5, fine.pressure * depth, pressure - 0.5);
    EXPECT_GE(velocity - 0.5, 1.9) << variant.name;
    EXPECT_GE(pressure - 0.5, 1.4) << variant.name;
    fbi::test::record({.section = "Fluid",
                       .id = "S-F2",
                       .check = std::string("Kovasznay Re 40, velocity, L2 error, 72 x 48 cells: ") + variant.name,
                       .source = "Kovasznay 1948",
                       .ours = fine.velocity * depth,
                       .error = fine.velocity * depth,
                       .order = velocity - 0.5,
                       .bar = "order >= 1.9"});
  }
}

// tau of the iteration finds in one solve what repeated solves with tau of the step tend to.
TEST(Kovasznay, TauOfTheIterationIsTheLimitOfRepeatedSolves) {
  linalg::initialize_petsc();
  FluidParameters p = fluid();
  Kovasznay repeated(16, p, false);
  p.tau_update = TauUpdate::iteration;
  Kovasznay once(16, p, false);
  LocalArray u(repeated.field.iterate()), v(once.field.iterate());
  double difference = 0;
  for (std::size_t k = 0; k < 4 * static_cast<std::size_t>(once.mesh.local_nodes()); ++k)
    if (k % 4 != 3) difference = std::max(difference, std::abs(u[k] - v[k]));
  std::printf("tau of the iteration: %d iterations, of the step: %d in 8 solves, difference %.1e\n", once.iterations,
              repeated.iterations, difference);
  EXPECT_LT(difference, 1e-6);
}

}  // namespace
}  // namespace fbi::fluid::test
