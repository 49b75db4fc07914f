// Boundary conditions, start, steps, restart and the preconditioner's ingredients of the fluid field.
#include <gtest/gtest.h>

#include "base/error.hpp"
#include "fluid_fixture.hpp"

namespace fbi::fluid::test {
namespace {

const FluidTimeParameters steady = {TimeScheme::steady, 1.0};

Index local_node(const mesh::HexMesh& mesh, const Vec3& x) {
  for (Index n = 0; n < mesh.local_nodes(); ++n)
    if ((Eigen::Map<const Vec3>(mesh.node(n)) - x).norm() < 1e-12) return n;
  return -1;
}

BoundaryConditions channel() {
  BoundaryConditions all;
  all["xmin"] = velocity(expressions("1+y", "2", "3"));
  all["xmax"] = of_type(BoundaryType::outflow);
  all["ymin"] = of_type(BoundaryType::no_slip);
  all["ymax"] = of_type(BoundaryType::slip);
  all["zmin"] = of_type(BoundaryType::slip);
  all["zmax"] = of_type(BoundaryType::mixed);
  all["zmax"].velocity[0] = input::Expression("x*t");
  return all;
}

struct Place {
  Vec3 x;
  std::array<int, 3> given;
  Vec3 value;
};

TEST(FluidBoundaries, SharedEdgesFollowTheRanking) {
  linalg::initialize_petsc();
  const mesh::HexMesh mesh = box_mesh(Comm(MPI_COMM_WORLD), {uniform(0, 4, 8), uniform(0, 1, 2), uniform(0, 1, 2)});
  FluidField field(mesh, {}, channel(), {TimeScheme::one_step_theta, 1.0});
  field.initialize();
  field.begin_step(2.0, 2.0);
  const Place places[] = {
      {{2, 0.5, 0.5}, {0, 0, 0}, {0, 0, 0}},    // inside
      {{0, 0.5, 0.5}, {1, 1, 1}, {1.5, 2, 3}},  // inflow
      {{0, 0, 0.5}, {1, 1, 1}, {0, 0, 0}},      // no_slip beats inflow
      {{0, 1, 0.5}, {1, 1, 1}, {2, 2, 3}},      // inflow beats slip
      {{0, 0.5, 1}, {1, 1, 1}, {1.5, 2, 3}},    // inflow beats mixed
      {{4, 0.5, 0.5}, {0, 0, 0}, {0, 0, 0}},    // outflow
      {{4, 0, 0.5}, {1, 1, 1}, {0, 0, 0}},      // no_slip at the outflow
      {{2, 1, 0.5}, {0, 1, 0}, {0, 0, 0}},      // slip
      {{2, 1, 0}, {0, 1, 1}, {0, 0, 0}},        // two slip faces: both normals
      {{2, 0.5, 1}, {1, 0, 0}, {4, 0, 0}},      // mixed, at t = 2
      {{2, 1, 1}, {1, 1, 0}, {4, 0, 0}},        // mixed and slip
      {{2, 0, 1}, {1, 1, 1}, {0, 0, 0}},        // no_slip beats mixed
  };
  LocalArray u(field.iterate());
  GlobalIndex found = 0;
  for (const Place& place : places) {
    const Index n = local_node(mesh, place.x);
    if (n < 0) continue;  // on another rank
    if (n < mesh.owned_nodes) ++found;
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(field.is_dirichlet()[4 * n + i], place.given[i]) << place.x.transpose() << " component " << i;
      EXPECT_EQ(u[4 * n + i], place.value[i]) << place.x.transpose() << " component " << i;
    }
    EXPECT_EQ(field.is_dirichlet()[4 * n + 3], 0);
  }
  EXPECT_EQ(mesh.comm.sum(found), 12);
}

TEST(FluidBoundaries, PressureIsFreeOnlyInAClosedBox) {
  linalg::initialize_petsc();
  const mesh::HexMesh mesh = box_mesh(Comm(MPI_COMM_WORLD), {uniform(0, 4, 6), uniform(0, 1, 3), uniform(0, 1, 3)});
  EXPECT_FALSE(FluidField(mesh, {}, channel(), steady).pressure_is_free());
  BoundaryConditions closed = channel();
  closed["xmax"] = of_type(BoundaryType::slip);
  EXPECT_FALSE(FluidField(mesh, {}, closed, steady).pressure_is_free());  // zmax leaves its normal open
  closed["zmax"].velocity[0].reset();
  closed["zmax"].velocity[2] = input::Expression(0.5);
  EXPECT_TRUE(FluidField(mesh, {}, closed, steady).pressure_is_free());
  closed.erase("zmax");
  EXPECT_FALSE(FluidField(mesh, {}, closed, steady).pressure_is_free());  // no condition is zero traction
  for (const std::string& face : box_faces) closed[face] = of_type(BoundaryType::slip);
  EXPECT_TRUE(FluidField(mesh, {}, closed, steady).pressure_is_free());
}

void expect_error(const mesh::HexMesh& mesh, const BoundaryConditions& conditions, ExitCode code,
                  const std::string& words) {
  try {
    FluidField field(mesh, {}, conditions, steady);
    field.initialize();
    FAIL() << "no error: " << words;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code);
    EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
  }
}

TEST(FluidBoundaries, ErrorsSayWhatIsWrongOnEveryRank) {
  linalg::initialize_petsc();
  const Comm comm(MPI_COMM_WORLD);
  mesh::HexMeshData data = mesh::make_box({uniform(0, 1, 3), uniform(0, 1, 3), uniform(0, 1, 3)}, true);
  for (std::size_t n = 0; n < data.nodes.size(); n += 3) data.nodes[n] += 0.1 * data.nodes[n + 1];
  const mesh::HexMesh mesh = mesh::distribute(comm, mesh::chunk_of(comm, data));
  expect_error(mesh, {{"inlet", of_type(BoundaryType::no_slip)}}, ExitCode::usage, "no face set of this name");
  BoundaryCondition half = of_type(BoundaryType::inflow);
  half.velocity[0] = input::Expression(1.0);
  expect_error(mesh, {{"xmin", half}}, ExitCode::usage, "all three velocity components");
}

TEST(FluidField, LumpedVolumeAndPressureLaplacian) {
  linalg::initialize_petsc();
  for (const double warp : {0.0, 0.2}) {
    const mesh::HexMesh mesh =
        box_mesh(Comm(MPI_COMM_WORLD), {graded(0, 2, 4, 1.3), uniform(0, 1, 4), uniform(0, 1.5, 3)}, false, warp);
    FluidField field(mesh, {}, {{"xmax", of_type(BoundaryType::outflow)}, {"xmin", of_type(BoundaryType::no_slip)}},
                     steady);
    double volume = 0;
    for (Index n = 0; n < mesh.owned_nodes; ++n) volume += field.lumped_volume()[n];
    EXPECT_NEAR(mesh.comm.sum(volume), 3.0, 1e-13);
    // ghosts hold what their owner holds
    linalg::VecHandle check = field.create_vector();
    {
      LocalArray a(check);
      for (Index n = 0; n < mesh.owned_nodes; ++n) a[4 * n] = field.lumped_volume()[n];
    }
    update_ghosts(check);
    {
      LocalArray a(check);
      for (Index n = 0; n < mesh.local_nodes(); ++n) EXPECT_EQ(a[4 * n], field.lumped_volume()[n]);
    }
    // p^T L p = c |grad p|^2 V for linear p; plus robin times c times the mean square on the open face over h
    const std::vector<double> two(mesh.local_cells(), 2.0);
    for (const double robin : {0.0, 3.0}) {
      const linalg::MatHandle matrix = field.pressure_laplacian(two, robin);
      linalg::VecHandle p, q;
      FBI_PETSC(MatCreateVecs(matrix, p.out(), q.out()));
      PetscScalar* a = nullptr;
      FBI_PETSC(VecGetArray(p, &a));
      for (Index n = 0; n < mesh.owned_nodes; ++n) a[n] = 3 * mesh.node(n)[1] - mesh.node(n)[2] + 1;
      FBI_PETSC(VecRestoreArray(p, &a));
      FBI_PETSC(MatMult(matrix, p, q));
      PetscScalar energy = 0;
      FBI_PETSC(VecDot(p, q, &energy));
      double expected = 2 * 10 * 3.0;
      if (robin > 0) {
        if (warp != 0) continue;
        // int over y in (0,1), z in (0,1.5) of (3y - z + 1)^2; h of the last cells from the grading
        const double h = graded(0, 2, 4, 1.3)[4] - graded(0, 2, 4, 1.3)[3];
        double square = 0;
        for (int i = 0; i < 2000; ++i) {  // midpoint in z of the exact integral in y
          const double z = 1.5 * (i + 0.5) / 2000, c = 1 - z;
          square += 1.5 / 2000 * (3 + 3 * c + c * c);
        }
        expected += robin * 2 * square / h;
        EXPECT_NEAR(energy, expected, 1e-6 * expected);
      } else {
        EXPECT_NEAR(energy, expected, 1e-11);
      }
    }
  }
}

// Stands in for a solver: a reproducible change of the free unknowns.
void pretend_to_solve(FluidField& field, int seed) {
  linalg::VecHandle delta = field.create_vector();
  fill(field.mesh(), delta, [&](GlobalIndex node, int c) { return 0.1 * noise(node, c, seed); });
  {
    LocalArray a(delta);
    for (Index k = 0; k < 4 * field.mesh().owned_nodes; ++k)
      if (field.is_dirichlet()[k]) a[k] = 0;
  }
  field.increment(delta);
}

struct Channel {
  mesh::HexMesh mesh;
  FluidField field;
  explicit Channel(double theta)
      : mesh(box_mesh(Comm(MPI_COMM_WORLD), {uniform(0, 2, 4), uniform(0, 1, 3), uniform(0, 1, 3)}, false, 0.1)),
        field(mesh, parameters(), conditions(), {TimeScheme::one_step_theta, theta}) {}
  static FluidParameters parameters() {
    FluidParameters p;
    p.viscosity = 0.1;
    p.initial_velocity = expressions("y", "0", "0");
    return p;
  }
  static BoundaryConditions conditions() {
    BoundaryConditions all = channel();
    all["ymax"] = of_type(BoundaryType::slip);
    all["zmax"] = of_type(BoundaryType::slip);
    return all;
  }
  void step(double time, double dt, int seed) {
    field.begin_step(time, dt);
    pretend_to_solve(field, seed);
    field.accept_step();
  }
};

TEST(FluidField, ThetaIsOneForTwoStepsAfterAnImpulsiveStart) {
  linalg::initialize_petsc();
  Channel channel(0.5);
  channel.field.initialize();
  const double thetas[] = {1, 1, 0.5, 0.5};
  for (int n = 0; n < 4; ++n) {
    channel.field.begin_step(0.1 * (n + 1), 0.1);
    EXPECT_EQ(channel.field.theta(), thetas[n]);
    EXPECT_DOUBLE_EQ(channel.field.sigma(), 1 / (thetas[n] * 0.1));
    channel.field.accept_step();
  }
  // at rest with nothing that moves it, v' = 0 is exact: no start-up steps
  FluidField rest(channel.mesh, {}, {{"ymin", of_type(BoundaryType::no_slip)}}, {TimeScheme::one_step_theta, 0.5});
  rest.initialize();
  rest.begin_step(0.1, 0.1);
  EXPECT_EQ(rest.theta(), 0.5);
}

TEST(FluidField, ExtrapolatesOnceTwoStepsAreAccepted) {
  linalg::initialize_petsc();
  Channel channel(1.0);
  FluidField& field = channel.field;
  field.initialize();
  const auto copy = [&](Vec v) { return owned_values(v); };
  channel.step(0.1, 0.1, 1);
  const std::vector<double> first = copy(field.accepted());
  field.begin_step(0.2, 0.1);
  EXPECT_EQ(copy(field.iterate()), first);  // boundary values do not move here
  pretend_to_solve(field, 2);
  field.accept_step();
  const std::vector<double> second = copy(field.accepted());
  field.begin_step(0.25, 0.05);
  const std::vector<double> guess = copy(field.iterate());
  for (std::size_t k = 0; k < guess.size(); ++k) EXPECT_NEAR(guess[k], second[k] + 0.5 * (second[k] - first[k]), 1e-14);
}

// The rate of change that the next step sees: v' = (v_{n+1} - v_n)/(theta dt) - (1/theta - 1) v'_n, read from the
// state.
TEST(FluidField, AccelerationFollowsOneStepTheta) {
  linalg::initialize_petsc();
  Channel channel(0.5);
  FluidField& field = channel.field;
  field.initialize();
  Vec rate = nullptr;
  for (const auto& [name, vector] : field.state())
    if (name == "acceleration") rate = vector;
  ASSERT_NE(rate, nullptr);
  std::vector<double> v = owned_values(field.accepted()), a(v.size(), 0.0);
  for (int n = 1; n <= 4; ++n) {
    channel.step(0.1 * n, 0.1, n);
    const double theta = n <= 2 ? 1.0 : 0.5;
    const std::vector<double> now = owned_values(field.accepted()), computed = owned_values(rate);
    for (std::size_t k = 0; k < v.size(); ++k) {
      a[k] = k % 4 == 3 ? 0 : (now[k] - v[k]) / (theta * 0.1) - (1 / theta - 1) * a[k];
      EXPECT_NEAR(computed[k], a[k], 1e-11);
    }
    v = now;
  }
}

TEST(FluidField, BeginStepAgainRestartsTheStep) {
  linalg::initialize_petsc();
  Channel channel(0.5);
  FluidField& field = channel.field;
  field.initialize();
  for (int n = 1; n <= 3; ++n) channel.step(0.1 * n, 0.1, n);
  linalg::VecHandle r = field.create_vector();
  field.begin_step(0.4, 0.1);
  field.residual(r);
  const std::vector<double> once = owned_values(r);
  pretend_to_solve(field, 9);
  field.begin_step(0.35, 0.05);
  field.begin_step(0.4, 0.1);
  field.residual(r);
  EXPECT_EQ(owned_values(r), once);
}

TEST(FluidField, RestoredStateGoesOnBitwise) {
  linalg::initialize_petsc();
  Channel one(0.5), two(0.5);
  one.field.initialize();
  for (int n = 1; n <= 3; ++n) one.step(0.1 * n, n == 3 ? 0.08 : 0.1, n);
  two.field.initialize();
  const auto from = one.field.state(), to = two.field.state();
  ASSERT_EQ(from.size(), to.size());
  for (std::size_t k = 0; k < from.size(); ++k) {
    EXPECT_EQ(from[k].first, to[k].first);
    const std::vector<double> values = owned_values(from[k].second);  // owned part only, as a checkpoint holds it
    PetscScalar* array = nullptr;
    FBI_PETSC(VecGetArray(to[k].second, &array));
    std::copy(values.begin(), values.end(), array);
    FBI_PETSC(VecRestoreArray(to[k].second, &array));
  }
  const auto numbers = one.field.scalars();
  const auto targets = two.field.scalars();
  for (std::size_t k = 0; k < numbers.size(); ++k) *targets[k].second = *numbers[k].second;
  two.field.state_restored();
  EXPECT_EQ(owned_values(one.field.iterate()), owned_values(two.field.iterate()));
  linalg::VecHandle r = one.field.create_vector(), s = two.field.create_vector();
  for (int n = 4; n <= 5; ++n) {
    one.field.begin_step(0.1 * n, 0.1);
    two.field.begin_step(0.1 * n, 0.1);
    EXPECT_EQ(one.field.theta(), two.field.theta());
    one.field.residual(r);
    two.field.residual(s);
    EXPECT_EQ(owned_values(r), owned_values(s));
    EXPECT_EQ(one.field.tau_m(), two.field.tau_m());
    pretend_to_solve(one.field, n);
    pretend_to_solve(two.field, n);
    one.field.accept_step();
    two.field.accept_step();
    EXPECT_EQ(owned_values(one.field.accepted()), owned_values(two.field.accepted()));
  }
}

TEST(FluidField, CflAndTauOnABox) {
  linalg::initialize_petsc();
  const mesh::HexMesh mesh = box_mesh(Comm(MPI_COMM_WORLD), {uniform(0, 2, 8), uniform(0, 1, 2), uniform(0, 1, 5)});
  FluidParameters p;
  p.density = 2;
  p.viscosity = 1e-3;
  p.initial_velocity = expressions("3", "-1", "2");
  FluidField field(mesh, p, {}, {TimeScheme::one_step_theta, 1.0});
  field.initialize();
  field.begin_step(0.01, 0.01);
  EXPECT_NEAR(field.cfl(), 0.01 * (3 / 0.25 + 1 / 0.5 + 2 / 0.2), 1e-13);
  EXPECT_NEAR(field.max_velocity(), std::sqrt(14.0), 1e-14);
  EXPECT_NEAR(field.smallest_cell(), std::cbrt(0.025), 1e-14);
  const double h = std::cbrt(0.025), speed = std::sqrt(14.0);
  const double expected = h * h / (h * h * 2 * 100 + 12e-3 * (2 * speed * h / 6e-3));
  for (const double tau : field.tau_m()) EXPECT_NEAR(tau, expected, 1e-12 * expected);
}

}  // namespace
}  // namespace fbi::fluid::test
