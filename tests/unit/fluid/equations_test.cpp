// Residual and tangent of the field: differences, box against general cells, ranks, patch tests, sums.
#include <gtest/gtest.h>

#include "fluid_scene.hpp"
#include "record.hpp"

namespace fbi::fluid::test {
namespace {

const Option options[] = {
    {"box", 0, ConvectiveForm::advective, ViscousResidual::full, TimeScheme::one_step_theta, 0.5},
    {"box, no viscous residual", 0, ConvectiveForm::advective, ViscousResidual::none, TimeScheme::one_step_theta, 1.0},
    {"box, Stokes", 0, ConvectiveForm::none, ViscousResidual::full, TimeScheme::one_step_theta, 0.7},
    {"box, steady Stokes, no viscous residual", 0, ConvectiveForm::none, ViscousResidual::none, TimeScheme::steady,
     1.0},
    {"general", 0.2, ConvectiveForm::advective, ViscousResidual::full, TimeScheme::one_step_theta, 0.5},
    {"general, steady, no viscous residual", 0.2, ConvectiveForm::advective, ViscousResidual::none, TimeScheme::steady,
     1.0},
    {"general, Stokes", 0.2, ConvectiveForm::none, ViscousResidual::full, TimeScheme::one_step_theta, 1.0},
    {"box, skew, projection, tau at the points", 0, ConvectiveForm::skew, ViscousResidual::full,
     TimeScheme::one_step_theta, 0.5,
     [](FluidParameters& p) {
       p.tau = Tau::whiting_jansen;
       p.tau_at = TauAt::quadrature_points;
       p.pressure_stabilization = PressureStabilization::projection;
     }},
    {"general, conservative, projection", 0.2, ConvectiveForm::conservative, ViscousResidual::full,
     TimeScheme::one_step_theta, 0.5,
     [](FluidParameters& p) { p.pressure_stabilization = PressureStabilization::projection; }},
};

TEST(FluidEquations, TangentMatchesCentralDifferences) {
  linalg::initialize_petsc();
  for (const Option& option : options) {
    Scene scene(Comm(MPI_COMM_WORLD), option);
    const double error = tangent_error(scene, 3);
    std::printf("tangent against differences, %s: %.1e\n", option.name, error);
    fbi::test::record({.section = "Fluid",
                       .check = std::string("tangent against differences of the residual: ") + option.name,
                       .source = "definition",
                       .reference = 0.0,
                       .ours = error,
                       .bar = "1e-6"});
    EXPECT_LT(error, 1e-6) << option.name;
  }
}

TEST(FluidEquations, AssembledTangentIsTheOperator) {
  linalg::initialize_petsc();
  for (const Option& option : options) {
    Scene scene(Comm(MPI_COMM_WORLD), option);
    linalg::VecHandle x = scene.field.create_vector(), y = scene.field.create_vector(), z = scene.field.create_vector();
    const linalg::MatHandle matrix = scene.field.assemble_jacobian();
    for (int seed : {4, 5}) {  // Dirichlet entries of x are not zero here
      fill(scene.mesh, x, [&](GlobalIndex node, int c) { return noise(node, c, seed); });
      scene.field.apply_jacobian(x, y);
      FBI_PETSC(MatMult(matrix, x, z));
      FBI_PETSC(VecAXPY(z, -1, y));
      EXPECT_LT(largest(z), 1e-13 * largest(y)) << option.name;
    }
    const linalg::MatHandle again = scene.field.assemble_jacobian();
    FBI_PETSC(MatMult(again, x, z));
    FBI_PETSC(VecAXPY(z, -1, y));
    EXPECT_LT(largest(z), 1e-13 * largest(y)) << option.name;
    PetscInt block = 0;
    FBI_PETSC(MatGetBlockSize(again, &block));
    EXPECT_EQ(block, 4);
  }
}

TEST(FluidEquations, BoxAndGeneralCellsAgree) {
  linalg::initialize_petsc();
  for (const int k : {0, 1, 2, 3, 7}) {
    Scene box(Comm(MPI_COMM_WORLD), options[k]), general(Comm(MPI_COMM_WORLD), options[k], true);
    ASSERT_TRUE(box.mesh.box.has_value());
    ASSERT_FALSE(general.mesh.box.has_value());
    linalg::VecHandle x = box.field.create_vector(), r = box.field.create_vector(), s = general.field.create_vector();
    fill(box.mesh, x, [](GlobalIndex node, int c) { return noise(node, c, 6); });
    // both meshes are distributed alike or not: compare norms and weighted sums
    const auto fingerprint = [&](const mesh::HexMesh& mesh, Vec v) {
      const std::vector<double> values = owned_values(v);
      double sum = 0;
      for (std::size_t n = 0; n < values.size(); ++n) sum += values[n] * noise(mesh.node_id[n / 4], n % 4, 7);
      return mesh.comm.sum(sum);
    };
    box.field.residual(r);
    general.field.residual(s);
    PetscReal norm = 0;
    FBI_PETSC(VecNorm(r, NORM_2, &norm));
    EXPECT_NEAR(fingerprint(box.mesh, r), fingerprint(general.mesh, s), 1e-12 * norm);
    linalg::VecHandle z = general.field.create_vector();
    fill(general.mesh, z, [](GlobalIndex node, int c) { return noise(node, c, 6); });
    box.field.apply_jacobian(x, r);
    general.field.apply_jacobian(z, s);
    FBI_PETSC(VecNorm(r, NORM_2, &norm));
    EXPECT_NEAR(fingerprint(box.mesh, r), fingerprint(general.mesh, s), 1e-12 * norm);
  }
}

TEST(FluidEquations, SameOnAnyNumberOfRanks) {
  linalg::initialize_petsc();
  for (int k : {0, 4, 7, 8}) {
    Scene parallel(Comm(MPI_COMM_WORLD), options[k]), serial(Comm(MPI_COMM_SELF), options[k]);
    const auto compare = [&](Vec p, Vec s, const char* what) {
      const std::vector<double> mine = owned_values(p), all = owned_values(s);
      const double scale = largest(s);
      for (Index n = 0; n < parallel.mesh.owned_nodes; ++n) {
        // serial nodes are sorted by file number, all of them owned
        const GlobalIndex other = parallel.mesh.node_id[n];
        ASSERT_EQ(serial.mesh.node_id[other], other);
        for (int c = 0; c < 4; ++c) EXPECT_NEAR(mine[4 * n + c], all[4 * other + c], 1e-13 * scale) << what;
      }
    };
    linalg::VecHandle p = parallel.field.create_vector(), s = serial.field.create_vector(),
                      x = parallel.field.create_vector(), z = serial.field.create_vector();
    parallel.field.residual(p);
    serial.field.residual(s);
    compare(p, s, "residual");
    parallel.field.reactions(p);
    serial.field.reactions(s);
    compare(p, s, "reactions");
    fill(parallel.mesh, x, [](GlobalIndex node, int c) { return noise(node, c, 8); });
    fill(serial.mesh, z, [](GlobalIndex node, int c) { return noise(node, c, 8); });
    parallel.field.apply_jacobian(x, p);
    serial.field.apply_jacobian(z, s);
    compare(p, s, "tangent");
    const linalg::MatHandle matrix = parallel.field.assemble_jacobian();
    FBI_PETSC(MatMult(matrix, x, p));
    compare(p, s, "matrix");
    EXPECT_NEAR(parallel.field.kinetic_energy(), serial.field.kinetic_energy(), 1e-13 * serial.field.kinetic_energy());
    EXPECT_NEAR(parallel.field.cfl(), serial.field.cfl(), 1e-13 * serial.field.cfl());
    EXPECT_EQ(parallel.field.max_velocity(), serial.field.max_velocity());
    EXPECT_EQ(parallel.field.smallest_cell(), serial.field.smallest_cell());
    EXPECT_EQ(parallel.field.pressure_is_free(), serial.field.pressure_is_free());
  }
}

// Linear velocity and pressure with the body force that balances them solve the discrete equations exactly, on warped
// cells as well: constant stress, residual r_M = 0 at every point (the Hessian of the map drops out), div v = 0.
TEST(FluidEquations, LinearFieldsPassThePatchTest) {
  linalg::initialize_petsc();
  for (const double warp : {0.0, 0.25}) {
    const mesh::HexMesh mesh =
        box_mesh(Comm(MPI_COMM_WORLD), {uniform(0, 1, 4), uniform(0, 2, 4), uniform(0, 1, 4)}, false, warp);
    FluidParameters p;
    p.density = 2;
    p.viscosity = 0.1;
    p.initial_velocity = expressions("1+2*x+y-z", "x-3*y+4*z", "x+y+z");
    // A = [2 1 -1; 1 -3 4; 1 1 1], v = A x + (1,0,0): (v.grad) v = A v; p = 3 x - y + 2 z - 1, b = A v + grad p/rho
    p.body_force = expressions("2*(1+2*x+y-z)+(x-3*y+4*z)-(x+y+z)+1.5", "(1+2*x+y-z)-3*(x-3*y+4*z)+4*(x+y+z)-0.5",
                               "(1+2*x+y-z)+(x-3*y+4*z)+(x+y+z)+1");
    BoundaryConditions conditions;
    for (const std::string& face : box_faces) conditions[face] = velocity(p.initial_velocity);
    FluidField field(mesh, p, conditions, {TimeScheme::steady, 1.0});
    field.initialize();
    field.begin_step(0, 0);
    linalg::VecHandle pressure = field.create_vector(), r = field.create_vector();
    fill(mesh, pressure, [](GlobalIndex, int) { return 0.0; });
    {
      LocalArray a(pressure);
      for (Index n = 0; n < mesh.owned_nodes; ++n)
        a[4 * n + 3] = 3 * mesh.node(n)[0] - mesh.node(n)[1] + 2 * mesh.node(n)[2] - 1;
    }
    field.increment(pressure);
    field.residual(r);
    EXPECT_LT(largest(r), 1e-14 * 100);
    // and the rows are not zero by accident: without the pressure they are not
    FBI_PETSC(VecScale(pressure, -1));
    field.increment(pressure);
    field.residual(r);
    EXPECT_GT(largest(r), 1e-3);
  }
}

// Test functions sum to one: the sum of the momentum rows is int rho (dv/dt + (v.grad) v - b) minus the loads, and the
// sum of the continuity rows is int div v.
TEST(FluidEquations, RowsSumToTheMomentumBalance) {
  linalg::initialize_petsc();
  for (const double warp : {0.0, 0.25}) {
    const mesh::HexMesh mesh =
        box_mesh(Comm(MPI_COMM_WORLD), {uniform(0, 1, 3), uniform(0, 2, 4), uniform(0, 1, 3)}, false, warp);
    FluidParameters p;
    p.density = 2;
    p.viscosity = 0.1;
    p.initial_velocity = expressions("x", "-y", "3*z");
    p.body_force = expressions("1", "2", "3");
    BoundaryConditions conditions;
    conditions["xmax"] = of_type(BoundaryType::traction);
    conditions["xmax"].traction = expressions("7", "y", "0");
    FluidField field(mesh, p, conditions, {TimeScheme::steady, 1.0});
    field.initialize();
    field.begin_step(0, 0);
    linalg::VecHandle r = field.create_vector();
    field.reactions(r);
    std::array<double, 4> sum{};
    const std::vector<double> rows = owned_values(r);
    for (std::size_t k = 0; k < rows.size(); ++k) sum[k % 4] += rows[k];
    mesh.comm.sum(sum.data(), 4);
    // (v.grad) v = (x, y, 9 z), centers 1/2, 1, 1/2; volume 2; face xmax has area 2 and mean y = 1
    EXPECT_NEAR(sum[0], 2 * (1 - 2) - 14, 1e-12);
    EXPECT_NEAR(sum[1], 2 * (2 - 4) - 2, 1e-12);
    EXPECT_NEAR(sum[2], 2 * (9 - 6), 1e-12);
    EXPECT_NEAR(sum[3], 3 * 2, 1e-12);
    EXPECT_NEAR(field.momentum(field.iterate())[1], -2 * 2 * 1.0, 1e-12);
    // 1/2 rho int x^2 + y^2 + 9 z^2
    EXPECT_NEAR(field.kinetic_energy(), 2.0 / 3 + 8.0 / 3 + 9 * 2.0 / 3, warp == 0 ? 1e-12 : 0.1);
  }
}

}  // namespace
}  // namespace fbi::fluid::test
