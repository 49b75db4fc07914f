// Curved slip walls and forces on the boundary against exact solutions: rigid rotation and a flow between slip walls in
// a bent channel, the torque between cylinders, the forces on the walls of a duct.
#include <gtest/gtest.h>

#include "convergence/fluid_solver.hpp"
#include "fluid/boundary_forces.hpp"
#include "record.hpp"
#include "unit/fluid/curved_meshes.hpp"

namespace fbi::fluid::test {
namespace {

const FluidTimeParameters steady = {TimeScheme::steady, 1.0};

void solve_steady(FluidField& field, int repeats) {
  field.initialize();
  StepSolver solver(field);
  for (int n = 0; n < repeats; ++n) {  // tau follows the velocity
    field.begin_step(0, 0);
    solver.solve();
    field.accept_step();
  }
}

std::vector<BoundaryForce> forces_on(FluidField& field, const std::vector<ForceSet>& sets) {
  const linalg::VecHandle balance = field.create_vector();
  field.internal_forces(balance);
  return BoundaryForces(field, sets).evaluate(field.iterate(), balance);
}

/// A quarter of a ring 1 < r < 2, one cell along z, given velocities at its ends and slip elsewhere.
Errors bent_channel(int cells, const std::string& profile, const std::string& body_x, const std::string& body_y,
                    ConvectiveForm form, const std::function<double(double)>& exact) {
  const mesh::HexMesh mesh = mapped_mesh(
      Comm(MPI_COMM_SELF),
      {uniform(0.2, 1.8, cells), graded(1, 2, cells, std::pow(1.5, 1.0 / cells)), uniform(0, 1.0 / cells, 1)}, bend);
  FluidParameters fluid;
  fluid.viscosity = 0.3;
  fluid.convective_form = form;
  fluid.body_force = expressions(body_x, body_y, "0");
  BoundaryConditions all;
  for (const char* end : {"xmin", "xmax"}) all[end] = velocity(expressions(profile + "*y", "-" + profile + "*x", "0"));
  for (const char* wall : {"ymin", "ymax", "zmin", "zmax"}) all[wall] = of_type(BoundaryType::slip);
  FluidField field(mesh, fluid, all, steady);
  solve_steady(field, form == ConvectiveForm::none ? 1 : 4);
  return errors(field, [&](const Vec3& x, double* value) {
    const double f = exact(std::hypot(x[0], x[1]));
    value[0] = f * x[1];
    value[1] = -f * x[0];
    value[2] = value[3] = 0;
  });
}

TEST(CurvedSlip, RigidRotationIsExact) {
  linalg::initialize_petsc();
  const Errors e = bent_channel(6, "1", "0", "0", ConvectiveForm::none, [](double) { return 1.0; });
  std::printf("rigid rotation between curved slip walls: velocity error %.1e, pressure error %.1e\n", e.velocity,
              e.pressure);
  EXPECT_LT(e.velocity, 1e-10);
  EXPECT_LT(e.pressure, 1e-9);  // the linear solver of the test stops at 1e-8
  ::fbi::test::record({.section = "General meshes",
                       .id = "",
                       .check = "rigid rotation between curved slip walls (Stokes), velocity error",
                       .source = "exact solution",
                       .error = e.velocity,
                       .bar = "1e-10"});
}

/// Rigid rotation (Stokes) in a bent channel with these angles of its sections; the far end is open or has its
/// velocity.
double rotation_error(const std::vector<double>& angles, bool open) {
  const int cells = static_cast<int>(angles.size()) - 1;
  const mesh::HexMesh mesh =
      mapped_mesh(Comm(MPI_COMM_SELF), {angles, uniform(1, 2, cells), uniform(0, 1.0 / cells, 1)}, bend);
  FluidParameters fluid;
  fluid.viscosity = 0.3;
  fluid.convective_form = ConvectiveForm::none;
  BoundaryConditions all;
  all["xmin"] = all["xmax"] = velocity(expressions("y", "-x", "0"));
  if (open) all["xmax"] = of_type(BoundaryType::outflow);
  for (const char* wall : {"ymin", "ymax", "zmin", "zmax"}) all[wall] = of_type(BoundaryType::slip);
  FluidField field(mesh, fluid, all, steady);
  solve_steady(field, 1);
  return errors(field,
                [](const Vec3& x, double* value) {
                  value[0] = x[1];
                  value[1] = -x[0];
                  value[2] = value[3] = 0;
                })
      .velocity;
}

// Where the faces at a node are not equally long the normal that lets no fluid pass is not that of the circle: it is
// off by half the difference of the angles they span. That is geometry, not the solver - with equal faces the same flow
// is exact - and the velocity converges with order 2 whether the spacing changes smoothly or alternates. With
// velocities given at both ends the flat faces leave a small net flow, which the solvers take out.
TEST(CurvedSlip, UnevenSpacingAlongTheWall) {
  linalg::initialize_petsc();
  for (const bool open : {true, false}) {
    double smooth[3], alternating[3];
    for (int level = 0; level < 3; ++level) {
      const int cells = 8 << level;
      smooth[level] = rotation_error(graded(0.2, 1.8, cells, std::pow(4.0, 1.0 / cells)), open);
      std::vector<double> angles = uniform(0.2, 1.8, cells);
      for (int i = 1; i < cells; i += 2) angles[i] += 0.2 * 1.6 / cells;
      alternating[level] = rotation_error(angles, open);
    }
    const double order = std::log2(smooth[1] / smooth[2]), low = std::log2(alternating[1] / alternating[2]);
    std::printf(
        "rigid rotation, far end %s: graded angles %.2e %.2e %.2e order %.2f, alternating %.2e %.2e %.2e order "
        "%.2f\n",
        open ? "open" : "given", smooth[0], smooth[1], smooth[2], order, alternating[0], alternating[1], alternating[2],
        low);
    EXPECT_GE(order, 1.8);
    EXPECT_GE(low, 1.8);
    ::fbi::test::record({.section = "General meshes",
                         .id = "",
                         .check = std::string("rigid rotation between slip walls, smoothly graded angles, far end ") +
                                  (open ? "open" : "given"),
                         .source = "exact solution",
                         .error = smooth[2],
                         .order = order,
                         .bar = "order 1.8"});
  }
}

// v = f(r) r along the channel with f = 1 + cos(pi (r-1))/2: no shear at the walls; forces keep it, the pressure is
// zero.
TEST(CurvedSlip, OrderTwo) {
  linalg::initialize_petsc();
  const std::string r = "sqrt(x^2+y^2)", s = "(pi*(" + r + "-1))", f = "(1+0.5*cos" + s + ")";
  // the angular force is -nu (3 f' + r f''), the radial one -f^2 r
  const std::string across = "(0.3*(1.5*pi*sin" + s + "+0.5*pi^2*" + r + "*cos" + s + ")/" + r + ")";
  const std::string x = across + "*y-" + f + "^2*x", y = "-" + across + "*x-" + f + "^2*y";
  const auto exact = [](double radius) { return 1 + 0.5 * std::cos(M_PI * (radius - 1)); };
  const Errors coarse = bent_channel(8, f, x, y, ConvectiveForm::advective, exact),
               middle = bent_channel(16, f, x, y, ConvectiveForm::advective, exact),
               fine = bent_channel(32, f, x, y, ConvectiveForm::advective, exact);
  const double order = std::log2(middle.velocity / fine.velocity),
               pressure = std::log2(middle.pressure / fine.pressure);
  std::printf("curved slip walls: velocity errors %.3e %.3e %.3e, order %.2f; pressure %.3e %.3e %.3e, order %.2f\n",
              coarse.velocity, middle.velocity, fine.velocity, order, coarse.pressure, middle.pressure, fine.pressure,
              pressure);
  EXPECT_GE(order, 1.8);
  EXPECT_GE(pressure, 1.3);
  ::fbi::test::record({.section = "General meshes",
                       .id = "",
                       .check = "flow between curved slip walls (Navier-Stokes), velocity error, 32 x 32 cells",
                       .source = "exact solution",
                       .error = fine.velocity,
                       .order = order,
                       .bar = "order 1.8"});
}

/// Torque about the axis of stresses integrated over the faces of a set, from the gradients of their cells.
double stress_torque(FluidField& field, const std::string& set) {
  const mesh::HexMesh& mesh = field.mesh();
  LocalArray u(field.iterate());
  double torque = 0;
  for (const mesh::HexMesh::LocalFace& face : mesh.faces.at(set)) {
    Eigen::Matrix<double, 3, 8> x;
    Eigen::Matrix<double, 4, 8> values;
    for (int a = 0; a < 8; ++a) {
      const std::size_t n = mesh.cells[8 * static_cast<std::size_t>(face.cell) + a];
      x.col(a) = Eigen::Map<const Vec3>(mesh.node(static_cast<Index>(n)));
      for (int c = 0; c < 4; ++c) values(c, a) = u[4 * n + c];
    }
    const FacePoints at = face_points(mesh, face);
    for (int q = 0; q < 4; ++q) {
      Vec3 xi = Vec3::Zero();  // of the point: the mean of the face's corners, by their shape functions
      for (int a = 0; a < 4; ++a) {
        const int corner = fem::hex8_faces[face.face][a];
        const double sign[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                   {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
        xi += at.shape[q][a] * Eigen::Map<const Vec3>(sign[corner]);
      }
      const Eigen::Matrix<double, 8, 3> slope = fem::hex8_gradient(xi);
      const std::array<double, 8> n = fem::hex8_shape(xi);
      const Mat3 gradient = values.topRows<3>() * slope * (x * slope).inverse();
      const double p = values.row(3) * Eigen::Map<const Eigen::Matrix<double, 8, 1>>(n.data());
      const Mat3 stress = field.parameters().viscosity * (gradient + gradient.transpose()) - p * Mat3::Identity();
      const Vec3 force = -at.weight[q] * (stress * at.normal[q]);  // of the fluid on what is outside
      torque += at.position[q][0] * force[1] - at.position[q][1] * force[0];
    }
  }
  return torque;
}

// The inner cylinder turns, the outer one stands: torque 4 pi mu w R1^2 R2^2/(R2^2 - R1^2) per length.
TEST(BoundaryForces, TorqueBetweenCylinders) {
  linalg::initialize_petsc();
  const double mu = 0.7, w = 1.3, length = 0.25, a = 1, b = 2;
  const double exact = 4 * M_PI * mu * w * a * a * b * b / (b * b - a * a) * length;
  double consistent[3], stress[3];
  for (int level = 0; level < 3; ++level) {
    const int cells = 4 << level;
    const Comm comm(MPI_COMM_SELF);
    const mesh::HexMesh mesh =
        mesh::distribute(comm, mesh::chunk_of(comm, ring(uniform(a, b, cells), 6 * cells, length)));
    FluidParameters fluid;
    fluid.viscosity = mu;
    fluid.convective_form = ConvectiveForm::none;
    BoundaryConditions all;
    all["inner"] = velocity(expressions("-1.3*y", "1.3*x", "0"));
    all["outer"] = of_type(BoundaryType::no_slip);
    all["zmin"] = all["zmax"] = of_type(BoundaryType::slip);
    FluidField field(mesh, fluid, all, steady);
    solve_steady(field, 1);
    const std::vector<BoundaryForce> forces = forces_on(field, {{{"inner"}}, {{"outer"}}, {{"zmin", "zmax"}}});
    consistent[level] = std::abs(-forces[0].moment[2] / exact - 1);
    stress[level] = std::abs(-stress_torque(field, "inner") / exact - 1);
    // what the inner cylinder gives the outer one takes
    EXPECT_NEAR(forces[1].moment[2], -forces[0].moment[2], 1e-9 * exact);
    EXPECT_LT(std::abs(forces[2].moment[2]), 1e-10 * exact);
    EXPECT_LT(forces[0].force.norm(), 1e-9 * exact);
  }
  const double order = std::log2(consistent[1] / consistent[2]), stress_order = std::log2(stress[1] / stress[2]);
  std::printf("torque between cylinders: errors %.2e %.2e %.2e order %.2f; by stresses %.2e %.2e %.2e order %.2f\n",
              consistent[0], consistent[1], consistent[2], order, stress[0], stress[1], stress[2], stress_order);
  EXPECT_GE(order, 1.8);
  EXPECT_LT(consistent[2], 0.2 * stress[2]);
  ::fbi::test::record({.section = "General meshes",
                       .id = "",
                       .check = "torque between cylinders (Stokes, 16 x 96 cells) by the consistent force",
                       .source = "exact solution",
                       .reference = exact,
                       .ours = exact * (1 + consistent[2]),
                       .order = order,
                       .bar = "order 1.8"});
  ::fbi::test::record({.section = "General meshes",
                       .id = "",
                       .check = "the same by stresses integrated over the wall",
                       .source = "exact solution",
                       .error = stress[2],
                       .order = stress_order,
                       .bar = "reported"});
}

// Pressure faces drive the flow: walls and ends balance to round-off, whatever the mesh is.
TEST(BoundaryForces, WallsOfADuctCarryThePressureDrop) {
  linalg::initialize_petsc();
  for (const double warp : {0.0, 0.1}) {
    const mesh::HexMesh mesh =
        box_mesh(Comm(MPI_COMM_SELF), {uniform(0, 2, 6), uniform(0, 1, 5), uniform(0, 0.5, 4)}, false, warp);
    FluidParameters fluid;
    fluid.viscosity = 0.05;
    fluid.convective_form = ConvectiveForm::none;
    BoundaryConditions all;
    for (const char* wall : {"ymin", "ymax", "zmin", "zmax"}) all[wall] = of_type(BoundaryType::no_slip);
    all["xmin"] = all["xmax"] = of_type(BoundaryType::pressure);
    all["xmin"].pressure = input::Expression(3.0);
    all["xmax"].pressure = input::Expression("1+y");
    FluidField field(mesh, fluid, all, steady);
    solve_steady(field, 1);
    const Vec3 about(0.3, 0.4, 0.5);
    const std::vector<BoundaryForce> forces =
        forces_on(field, {{{"ymin", "ymax", "zmin", "zmax"}, about},
                          {{"xmin"}, about},
                          {{"xmax"}, about},
                          {{"xmin", "xmax", "ymin", "ymax", "zmin", "zmax"}, about}});
    const double drop = (3 - 1.5) * 0.5;
    EXPECT_NEAR(forces[0].force[0], drop, 1e-10);
    EXPECT_NEAR(forces[1].force[0], -3 * 0.5, 1e-12);
    EXPECT_NEAR(forces[2].force[0], 1.5 * 0.5, 1e-12);
    EXPECT_LT(forces[3].force.norm(), 1e-10);
    EXPECT_LT(forces[3].moment.norm(), 1e-10);
    ::fbi::test::record({.section = warp == 0 ? "Fluid" : "General meshes",
                         .id = "",
                         .check = "force on the walls of a duct = pressure drop times area",
                         .source = "identity",
                         .reference = drop,
                         .ours = forces[0].force[0],
                         .bar = "1e-10"});
  }
}

}  // namespace
}  // namespace fbi::fluid::test
