// Slip walls that do not lie along the axes: normals, precedence, tangent, and a rotated channel against a straight
// one.
#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "curved_meshes.hpp"
#include "fluid/boundary_forces.hpp"
#include "fsi/monolithic.hpp"
#include "record.hpp"

namespace fbi::fluid::test {
namespace {

const FluidTimeParameters steady = {TimeScheme::steady, 1.0};
const FluidTimeParameters implicit_euler = {TimeScheme::one_step_theta, 1.0};

Mat3 rotation() { return Eigen::AngleAxisd(0.7, Vec3(1, 2, -0.5).normalized()).toRotationMatrix(); }

/// A bent channel with slip walls, flat ones in z too, one condition of each kind at its ends.
struct Bend {
  mesh::HexMesh mesh;
  FluidField field;
  explicit Bend(const Comm& comm, const BoundaryConditions& conditions = bend_conditions())
      : mesh(mapped_mesh(comm, {graded(0.1, 1.9, 5, 1.2), graded(1, 2, 4, 1.1), uniform(0, 1, 2)}, bend)),
        field(mesh, fluid(), conditions, implicit_euler) {
    field.initialize();
    field.begin_step(0.1, 0.1);
  }
  static FluidParameters fluid() {
    FluidParameters p;
    p.density = 1.3;
    p.viscosity = 0.07;
    p.initial_velocity = expressions("y", "x*z", "0.3");
    return p;
  }
  static BoundaryConditions bend_conditions() {
    BoundaryConditions all;
    all["xmin"] = velocity(expressions("0.2", "1+z", "0"));
    all["xmax"] = of_type(BoundaryType::pressure);
    all["xmax"].pressure = input::Expression("3+y");
    all["xmax"].backflow = true;
    for (const char* wall : {"ymin", "ymax", "zmin"}) all[wall] = of_type(BoundaryType::slip);
    all["zmax"] = of_type(BoundaryType::mixed);
    all["zmax"].velocity[2] = input::Expression(0.25);
    return all;
  }
  void rough(Vec v, int seed) const {
    fill(mesh, v, [&](GlobalIndex node, int c) { return 0.3 * noise(node, c, seed); });
    PetscScalar* array = nullptr;
    FBI_PETSC(VecGetArray(v, &array));
    for (Index k = 0; k < 4 * mesh.owned_nodes; ++k)
      if (field.is_dirichlet()[k]) array[k] = 0;
    field.remove_normal(array, mesh.owned_nodes);
    FBI_PETSC(VecRestoreArray(v, &array));
  }
};

TEST(Slip, TangentMatchesDifferencesAndTheAssembledMatrix) {
  linalg::initialize_petsc();
  Bend scene{Comm(MPI_COMM_WORLD)};
  FluidField& field = scene.field;
  linalg::VecHandle x = field.create_vector(), y = field.create_vector(), plus = field.create_vector(),
                    minus = field.create_vector();
  scene.rough(x, 1);
  field.increment(x);
  field.linearize();
  // every entry of the direction is rough here: identity along the normals
  fill(scene.mesh, x, [](GlobalIndex node, int c) { return noise(node, c, 2); });
  const linalg::MatHandle matrix = field.assemble_jacobian();
  field.apply_jacobian(x, y);
  FBI_PETSC(MatMult(matrix, x, plus));
  FBI_PETSC(VecAXPY(plus, -1, y));
  EXPECT_LT(largest(plus), 1e-13 * largest(y));
  {
    LocalArray in(x), out(y);
    for (Index n = 0; n < scene.mesh.owned_nodes; ++n) {
      const Mat3 fixed = Mat3::Identity() - field.free_directions(n);
      const Eigen::Map<const Vec3> a(in.data() + 4 * n), b(out.data() + 4 * n);
      EXPECT_LT((fixed * (a - b)).norm(), 1e-13 * b.norm() + 1e-14);
    }
  }
  scene.rough(x, 3);
  field.apply_jacobian(x, y);
  const double step = 1e-5;
  FBI_PETSC(VecScale(x, step));
  field.increment(x);
  field.residual(plus);
  FBI_PETSC(VecScale(x, -2));
  field.increment(x);
  field.residual(minus);
  FBI_PETSC(VecAXPY(plus, -1, minus));
  FBI_PETSC(VecScale(plus, 1 / (2 * step)));
  FBI_PETSC(VecAXPY(plus, -1, y));
  const double error = largest(plus) / largest(y);
  std::printf("tangent against differences, curved slip walls: %.1e\n", error);
  EXPECT_LT(error, 1e-6);
}

// No fluid passes the curved walls whatever the free velocities are; on their edges with flat walls both normals hold.
TEST(Slip, NormalsAreConsistentWithMass) {
  linalg::initialize_petsc();
  Bend scene{Comm(MPI_COMM_WORLD)};
  linalg::VecHandle x = scene.field.create_vector();
  scene.rough(x, 4);
  scene.field.increment(x);
  LocalArray u(scene.field.iterate());
  for (const char* wall : {"ymin", "ymax"}) {
    double flux = 0, size = 0;
    for (const mesh::HexMesh::LocalFace& face : scene.mesh.faces.at(wall)) {
      const FacePoints at = face_points(scene.mesh, face);
      for (int a = 0; a < 4; ++a) {
        const Index n = face_node(scene.mesh, face, a);
        const Eigen::Map<const Vec3> v(u.data() + 4 * static_cast<std::size_t>(n));
        // the inflow end keeps its own velocity, which may pass
        if (scene.field.is_dirichlet()[4 * n] == 0) flux += v.dot(at.area_vector(a));
        size += v.norm() * at.area_vector(a).norm();
      }
    }
    flux = scene.mesh.comm.sum(flux);
    size = scene.mesh.comm.sum(size);
    EXPECT_LT(std::abs(flux), 1e-14 * size) << wall;
  }
  for (Index n = 0; n < scene.mesh.local_nodes(); ++n) {
    const double* p = scene.mesh.node(n);
    const Mat3 free = scene.field.free_directions(n);
    const double radius = std::hypot(p[0], p[1]), trace = free.trace();
    const bool wall = std::abs(radius - 1) < 1e-12 || std::abs(radius - 2) < 1e-12;
    const bool inflow = scene.field.is_dirichlet()[4 * n] != 0;
    EXPECT_NEAR(trace, wall && !inflow ? 2 : 3, 1e-12);
    if (std::abs(p[2]) < 1e-12 && !inflow) {  // slip in z as well: the axis
      EXPECT_EQ(scene.field.is_dirichlet()[4 * n + 2], 1);
      EXPECT_EQ(u[4 * n + 2], 0.0);
    }
    if (std::abs(p[2] - 1) < 1e-12 && !inflow) {
      EXPECT_EQ(u[4 * n + 2], 0.25);
    }
  }
}

TEST(Slip, ClosedLeaningBoxLeavesThePressureFree) {
  linalg::initialize_petsc();
  const Mat3 turn = rotation();
  const auto lean = [&](const Vec3& x) -> Vec3 { return turn * Vec3(x[0] + 0.3 * x[1], x[1], x[2]); };
  const mesh::HexMesh mesh =
      mapped_mesh(Comm(MPI_COMM_WORLD), {uniform(0, 1, 3), uniform(0, 1, 3), uniform(0, 1, 3)}, lean);
  BoundaryConditions all;
  for (const std::string& face : box_faces) all[face] = of_type(BoundaryType::slip);
  FluidField closed(mesh, {}, all, steady);
  EXPECT_TRUE(closed.pressure_is_free());
  // one normal inside a face, two on an edge, all three in a corner
  std::array<GlobalIndex, 4> count{};
  for (Index n = 0; n < mesh.owned_nodes; ++n) ++count[std::lround(closed.free_directions(n).trace())];
  for (GlobalIndex& c : count) c = mesh.comm.sum(c);
  EXPECT_EQ(count[3], 8);
  EXPECT_EQ(count[2], 24);
  EXPECT_EQ(count[1], 24);
  EXPECT_EQ(count[0], 8);
  all["xmax"] = of_type(BoundaryType::outflow);
  EXPECT_FALSE(FluidField(mesh, {}, all, steady).pressure_is_free());
  // no_slip beats slip: nothing is left to constrain at its nodes
  all["xmax"] = of_type(BoundaryType::no_slip);
  FluidField held(mesh, {}, all, steady);
  for (const mesh::HexMesh::LocalFace& face : mesh.faces.at("xmax"))
    for (int a = 0; a < 4; ++a) {
      const Index n = face_node(mesh, face, a);
      for (int i = 0; i < 3; ++i) EXPECT_EQ(held.is_dirichlet()[4 * n + i], 1);
      EXPECT_EQ(held.free_directions(n), Mat3::Identity());
    }
}

struct Channel {
  mesh::HexMesh mesh;
  FluidField field;
  Channel(const Comm& comm, const Mat3& turn, bool axes)
      : mesh(mapped_mesh(comm, {uniform(0, 2, 8), graded(0, 1, 5, 1.1), uniform(0, 0.7, 3)},
                         [&](const Vec3& x) -> Vec3 { return turn * x; })),
        field(mesh, fluid(turn), conditions(turn), implicit_euler) {
    EXPECT_EQ(comm.any(field.has_normal_constraints()), !axes);
    field.initialize();
  }
  static FluidParameters fluid(const Mat3& turn) {
    FluidParameters p;
    p.viscosity = 0.02;
    // a flow from the start: where there is none, the cell length in tau is that along the x axis
    p.initial_velocity = {input::Expression(turn(0, 0)), input::Expression(turn(1, 0)), input::Expression(turn(2, 0))};
    return p;
  }
  static BoundaryConditions conditions(const Mat3& turn) {
    BoundaryConditions all;
    // the coordinate across the channel, from those of the turned one
    const std::string y = log_format("(%.17g*x+%.17g*y+%.17g*z)", turn(0, 1), turn(1, 1), turn(2, 1));
    const std::string speed = "*" + y + "*(2-" + y + ")*(1+0.5*sin(9*t))";
    all["xmin"] = velocity(expressions(log_format("%.17g", turn(0, 0)) + speed, log_format("%.17g", turn(1, 0)) + speed,
                                       log_format("%.17g", turn(2, 0)) + speed));
    all["xmax"] = of_type(BoundaryType::outflow);
    all["xmax"].backflow = true;
    all["ymin"] = of_type(BoundaryType::no_slip);
    for (const char* wall : {"ymax", "zmin", "zmax"}) all[wall] = of_type(BoundaryType::slip);
    return all;
  }
  static std::string log_format(const char* format, double a, double b = 0, double c = 0) {
    char text[160];
    std::snprintf(text, sizeof text, format, a, b, c);
    return text;
  }
};

struct Outcome {
  std::vector<double> values;         // by file number: velocity in the frame of the channel, pressure
  std::vector<BoundaryForce> forces;  // on floor, lid and sides, in the frame of the channel
  int krylov = 0;
};

Outcome run(const Comm& comm, const Mat3& turn, bool axes, fsi::LinearSolver linear) {
  Channel channel(comm, turn, axes);
  fsi::SolverParameters solver;
  solver.newton_tolerance = 1e-11;
  solver.newton_absolute_tolerance = 1e-15;
  solver.krylov_tolerance = 1e-9;
  solver.linear = linear;
  fsi::System system(&channel.field, nullptr, nullptr, {}, {}, solver);
  Outcome outcome;
  for (int n = 1; n <= 4; ++n) {
    system.begin_step(0.05 * n, 0.05);
    const fsi::StepReport report = fsi::solve_monolithic(system);
    EXPECT_TRUE(report.converged) << report.residual;
    outcome.krylov += report.krylov;
    system.accept_step();
  }
  outcome.values.assign(4 * static_cast<std::size_t>(channel.mesh.global_nodes), 0.0);
  {
    LocalArray u(channel.field.iterate());
    for (Index n = 0; n < channel.mesh.owned_nodes; ++n) {
      const Vec3 v = turn.transpose() * Eigen::Map<const Vec3>(u.data() + 4 * n);
      for (int i = 0; i < 4; ++i) outcome.values[4 * channel.mesh.node_id[n] + i] = i < 3 ? v[i] : u[4 * n + 3];
    }
  }
  comm.sum(outcome.values.data(), static_cast<int>(outcome.values.size()));
  const linalg::VecHandle balance = channel.field.create_vector();
  channel.field.internal_forces(balance);
  const Vec3 about = turn * Vec3(0.1, 0.2, 0.3);
  const BoundaryForces forces(channel.field, {{{"ymin"}, about},
                                              {{"ymax"}, about},
                                              {{"zmin", "zmax"}, about},
                                              {{"xmin", "xmax", "ymin", "ymax", "zmin", "zmax"}, about}});
  outcome.forces = forces.evaluate(channel.field.iterate(), balance);
  Vec3 total = Vec3::Zero();
  {
    LocalArray r(balance);
    for (Index n = 0; n < channel.mesh.owned_nodes; ++n) total -= Eigen::Map<const Vec3>(r.data() + 4 * n);
  }
  comm.sum(total.data(), 3);
  EXPECT_LT((outcome.forces[3].force - total).norm(), 1e-9 * outcome.forces[0].force.norm());
  for (BoundaryForce& force : outcome.forces) force = {turn.transpose() * force.force, turn.transpose() * force.moment};
  return outcome;
}

double difference(const Outcome& a, const Outcome& b) {
  double largest = 0, size = 0;
  for (std::size_t k = 0; k < a.values.size(); ++k) {
    largest = std::max(largest, std::abs(a.values[k] - b.values[k]));
    size = std::max(size, std::abs(a.values[k]));
  }
  return largest / size;
}

TEST(Slip, TurnedChannelFlowsLikeTheStraightOne) {
  linalg::initialize_petsc();
  const Comm comm(MPI_COMM_WORLD);
  for (const fsi::LinearSolver linear : {fsi::LinearSolver::direct, fsi::LinearSolver::iterative}) {
    const Outcome straight = run(comm, Mat3::Identity(), true, linear), turned = run(comm, rotation(), false, linear);
    const double error = difference(straight, turned);
    std::printf("turned channel against straight: %.1e, Krylov iterations %d against %d\n", error, turned.krylov,
                straight.krylov);
    EXPECT_LT(error, 1e-8);
    EXPECT_LE(turned.krylov, straight.krylov + straight.krylov / 5);
    double force = 0;
    const double scale = straight.forces[0].force.norm() + straight.forces[2].force.norm();
    for (std::size_t k = 0; k < straight.forces.size(); ++k) {
      force = std::max(force, (straight.forces[k].force - turned.forces[k].force).norm() / scale);
      force = std::max(force, (straight.forces[k].moment - turned.forces[k].moment).norm() / scale);
    }
    EXPECT_LT(force, 1e-7);
    // no friction on slip walls
    EXPECT_LT(std::abs(turned.forces[1].force[0]), 1e-12 * scale);
    if (linear == fsi::LinearSolver::direct)
      ::fbi::test::record({.section = "General meshes",
                           .id = "",
                           .check = "channel with slip walls, turned by 0.7 rad: velocity, pressure",
                           .source = "identity",
                           .error = error,
                           .bar = "1e-8"});
  }
}

// A fluid without an open face: given velocities that do not balance are an error, not a hidden source.
TEST(Slip, ClosedFluidNeedsBalancedVelocities) {
  linalg::initialize_petsc();
  const mesh::HexMesh mesh =
      box_mesh(Comm(MPI_COMM_WORLD), {uniform(0, 2, 4), uniform(0, 1, 3), uniform(0, 1, 3)}, true);
  for (const char* out : {"0.5", "1"}) {
    BoundaryConditions all;
    for (const std::string& face : box_faces) all[face] = of_type(BoundaryType::slip);
    all["xmin"] = velocity(expressions("1", "0", "0"));
    all["xmax"] = velocity(expressions(out, "0", "0"));
    FluidField field(mesh, {}, all, implicit_euler);
    field.initialize();
    fsi::System system(&field, nullptr, nullptr, {}, {}, {});
    if (std::string(out) == "1") {
      system.begin_step(0.1, 0.1);
      EXPECT_TRUE(fsi::solve_monolithic(system).converged);
      continue;
    }
    try {
      system.begin_step(0.1, 0.1);
      ADD_FAILURE() << "no error";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::usage);
      EXPECT_NE(std::string(error.what()).find("net flow of -0.5 out of a fluid"), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace fbi::fluid::test
