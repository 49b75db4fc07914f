/// The field of all fibers: consistency of residual, tangent, solve, compliance, supports, status and state.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <random>

#include "base/error.hpp"
#include "beam/beam_field.hpp"
#include "unit/beam/straight_fiber.hpp"

namespace fbi::beam {
namespace {

const Vec3 skew = Vec3(1, 2, -0.5).normalized();

// Two skew fibers with loads, the second one clamped at both ends, and a fixed one between them.
struct Scene {
  mesh::FiberMesh mesh;
  std::vector<FiberParameters> groups;
  BeamTimeParameters time;

  Scene() {
    test::add_straight_fiber(mesh, {0, 0, 0}, skew, 1.0, 3, 0);
    test::add_straight_fiber(mesh, {0, 3, 0}, Vec3(0, 1, 0), 2.0, 2, 1);
    test::add_straight_fiber(mesh, {1, 0, 0}, skew, 1.5, 9, 2);
    FiberParameters first = test::stiffness(40.0, 0.7, 1.3);
    first.start = EndCondition::clamped;
    first.loads = {test::load(LoadType::force, {0.1, -0.2, 0.3}), test::load(LoadType::moment, {0.2, 0.1, 0.3})};
    FiberParameters fixed = test::stiffness(1.0, 1.0);
    fixed.formulation = Formulation::fixed;
    FiberParameters third = test::stiffness(30.0, 0.5, 0.9);
    third.start = EndCondition::clamped;
    third.end = EndCondition::clamped;
    third.loads = {test::load(LoadType::line, {0.3, 0.1, 0.2})};
    groups = {first, fixed, third};
    time.rho_inf = 0.7;
  }
};

// A scene in motion: three steps done, the fourth begun and its iterate disturbed.
void set_moving(BeamField& field, std::size_t size) {
  field.initialize({});
  for (int step = 1; step <= 3; ++step) {
    field.begin_step(0.05 * step, 0.05);
    ASSERT_GE(field.solve_step({}), 0);
    field.accept_step();
  }
  field.begin_step(0.2, 0.05);
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> random(-0.02, 0.02);
  std::vector<double> delta(size);
  for (double& value : delta) value = random(generator);
  field.increment(delta);
}

TEST(BeamField, SolveInvertsTheDerivativeOfTheResidual) {
  const Scene scene;
  const std::size_t size = 6 * static_cast<std::size_t>(scene.mesh.nodes());
  BeamField field(scene.mesh, scene.groups, scene.time, {0, -0.1, 0});
  set_moving(field, size);
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> random(-1.0, 1.0);
  std::vector<double> direction(size);
  for (double& value : direction) value = random(generator);
  // admissible direction: what a solve returns
  field.linearize();
  for (Index f = 0; f < scene.mesh.fibers(); ++f) field.solve(f, &direction[6 * scene.mesh.first_node[f]]);
  double norm = 0.0;
  for (double value : direction) norm = std::max(norm, std::abs(value));
  for (double& value : direction) value /= norm;

  const double h = 1e-5;
  const auto residual_at = [&](double step) {
    std::vector<double> delta(size);
    for (std::size_t i = 0; i < size; ++i) delta[i] = step * direction[i];
    field.increment(delta);
    field.linearize();
    std::vector<double> residual = field.residual();
    for (double& value : delta) value = -value;
    field.increment(delta);
    return residual;
  };
  const std::vector<double> plus = residual_at(h), minus = residual_at(-h);
  std::vector<double> image(size);
  for (std::size_t i = 0; i < size; ++i) image[i] = (plus[i] - minus[i]) / (2 * h);
  field.linearize();
  for (Index f = 0; f < scene.mesh.fibers(); ++f) field.solve(f, &image[6 * scene.mesh.first_node[f]]);
  for (std::size_t i = 0; i < size; ++i) EXPECT_NEAR(image[i], direction[i], 1e-6);
}

TEST(BeamField, ComplianceIsDInverseTangentDTransposed) {
  const Scene scene;
  const std::size_t size = 6 * static_cast<std::size_t>(scene.mesh.nodes());
  BeamField field(scene.mesh, scene.groups, scene.time, Vec3::Zero());
  set_moving(field, size);
  field.linearize();
  std::mt19937 generator(9);
  std::uniform_real_distribution<double> random(-1.0, 1.0);
  for (Index f = 0; f < scene.mesh.fibers(); ++f) {
    const Index nodes = scene.mesh.first_node[f + 1] - scene.mesh.first_node[f], rows = 3;
    std::vector<double> d(static_cast<std::size_t>(rows) * 2 * nodes);
    for (double& value : d) value = random(generator);
    RowMatrix block;
    field.compliance(f, d.data(), rows, block);
    ASSERT_EQ(block.rows(), 3 * rows);
    for (Index r = 0; r < rows; ++r)
      for (int k = 0; k < 3; ++k) {
        std::vector<double> b(6 * static_cast<std::size_t>(nodes), 0.0);
        for (Index i = 0; i < 2 * nodes; ++i) b[3 * i + k] = d[static_cast<std::size_t>(r) * 2 * nodes + i];
        field.solve(f, b.data());
        for (Index s = 0; s < rows; ++s)
          for (int l = 0; l < 3; ++l) {
            double expected = 0.0;
            for (Index i = 0; i < 2 * nodes; ++i)
              expected += d[static_cast<std::size_t>(s) * 2 * nodes + i] * b[3 * i + l];
            EXPECT_NEAR(block(3 * s + l, 3 * r + k), expected, 1e-12);
          }
      }
    if (field.is_fixed(f)) {
      EXPECT_EQ(block.norm(), 0.0);
    }
  }
}

TEST(BeamField, FixedFibersStayExactly) {
  const Scene scene;
  BeamField field(scene.mesh, scene.groups, scene.time, {0, -9.81, 0});
  EXPECT_EQ(field.moving_fibers(), 2);
  EXPECT_TRUE(field.is_fixed(1));
  set_moving(field, 6 * static_cast<std::size_t>(scene.mesh.nodes()));
  for (Index node = scene.mesh.first_node[1]; node < scene.mesh.first_node[2]; ++node)
    for (int k = 0; k < 3; ++k) {
      EXPECT_EQ(field.dofs()[6 * node + k], scene.mesh.position[3 * node + k]);
      EXPECT_EQ(field.velocity()[6 * node + k], 0.0);
      EXPECT_EQ(field.residual()[6 * node + k], 0.0);
    }
}

TEST(BeamField, ClampedEndKeepsPositionAndDirectionOfASkewTangent) {
  const Scene scene;
  BeamField field(scene.mesh, scene.groups, scene.time, {0, -2, 0});
  field.initialize({});
  for (int step = 1; step <= 20; ++step) {
    field.begin_step(0.05 * step, 0.05);
    ASSERT_GE(field.solve_step({}), 0);
    field.accept_step();
  }
  const std::vector<double>& d = field.dofs();
  EXPECT_EQ(Vec3(&d[0]).norm(), 0.0);
  const Vec3 tangent(&d[3]);
  EXPECT_LE((tangent - tangent.dot(skew) * skew).norm(), 1e-14);
  EXPECT_GT(std::abs(tangent.norm() - 1), 1e-8);  // the stretch along it is free
  const Vec3 tip(&d[6 * 3]);
  EXPECT_GT((tip - Vec3(skew)).norm(), 0.05);
}

TEST(BeamField, ReactionsBalanceTheLoads) {
  mesh::FiberMesh mesh = test::straight_fiber({0.2, 0, 0}, skew, 1.0, 4);
  FiberParameters group = test::stiffness(200.0, 0.7, 1.3);
  group.start = EndCondition::clamped;
  group.loads = {test::load(LoadType::force, {0.1, -0.2, 0.3}), test::load(LoadType::line, {0.3, 0.1, -0.2})};
  BeamTimeParameters time;
  time.scheme = TimeScheme::static_;
  BeamField field(mesh, {group}, time, {0, 0, -0.5});
  field.initialize({});
  std::vector<double> coupling(6 * static_cast<std::size_t>(mesh.nodes()), 0.0);
  for (Index node = 0; node < mesh.nodes(); ++node) coupling[6 * node + 1] = 0.05;
  field.begin_step(1.0, 1.0);
  ASSERT_GE(field.solve_step(coupling), 0);
  field.accept_step();
  const std::vector<double> reaction = field.reactions(coupling);
  const Vec3 expected = -Vec3(0.4, -0.1 + 5 * 0.05, 0.1 - 0.5 * 1.3);
  EXPECT_LE((Vec3(&reaction[0]) - expected).norm(), 1e-9);
  for (std::size_t i = 6; i < reaction.size(); ++i) EXPECT_EQ(reaction[i], 0.0);
}

TEST(BeamField, ImpulseOfAFreeFiberIsItsMomentum) {
  mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, skew, 1.0, 4);
  FiberParameters group = test::stiffness(200.0, 0.7, 1.3);
  group.loads = {test::load(LoadType::force, {0.1, -0.2, 0.3})};
  for (const double rho_inf : {1.0, 0.6}) {
    BeamTimeParameters time;
    time.rho_inf = rho_inf;
    BeamField field(mesh, {group}, time, {0, 0, -1});
    field.initialize({});
    for (int step = 1; step <= 40; ++step) {
      field.begin_step(0.01 * step, 0.01);
      ASSERT_GE(field.solve_step({}), 0);
      field.accept_step();
    }
    const Vec3 impulse = 0.4 * (Vec3(0.1, -0.2, 0.3) + 1.3 * Vec3(0, 0, -1));
    EXPECT_LE((field.linear_momentum(field.accepted_velocity()) - impulse).norm(), 1e-9);
  }
}

TEST(BeamField, BeginStepRestartsTheStepAndStateRestoresItBitwise) {
  const Scene scene;
  const std::size_t size = 6 * static_cast<std::size_t>(scene.mesh.nodes());
  BeamField field(scene.mesh, scene.groups, scene.time, {0, -2, 0}),
      other(scene.mesh, scene.groups, scene.time, {0, -2, 0});
  set_moving(field, size);
  field.begin_step(0.2, 0.05);
  ASSERT_GE(field.solve_step({}), 0);
  const std::vector<double> once = field.dofs();
  field.begin_step(0.2, 0.05);
  ASSERT_GE(field.solve_step({}), 0);
  EXPECT_EQ(once, field.dofs());
  field.accept_step();
  auto from = field.state(), to = other.state();
  ASSERT_EQ(from.size(), to.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    EXPECT_EQ(from[i].first, to[i].first);
    EXPECT_EQ(from[i].second->size(), size);
    *to[i].second = *from[i].second;
  }
  for (int step = 5; step <= 8; ++step)
    for (BeamField* each : {&field, &other}) {
      each->begin_step(0.05 * step, 0.05);
      ASSERT_GE(each->solve_step({}), 0);
      each->accept_step();
    }
  EXPECT_EQ(field.dofs(), other.dofs());
  EXPECT_EQ(field.acceleration(), other.acceleration());
  EXPECT_EQ(field.energy().external_work, other.energy().external_work);
}

TEST(BeamField, LinearizeAndIncrementReachTheStepOfTheBuiltInNewton) {
  const Scene scene;
  const std::size_t size = 6 * static_cast<std::size_t>(scene.mesh.nodes());
  BeamField field(scene.mesh, scene.groups, scene.time, {0, -2, 0});
  set_moving(field, size);
  field.begin_step(0.2, 0.05);
  ASSERT_GE(field.solve_step({}), 0);
  const std::vector<double> expected = field.dofs();
  field.begin_step(0.2, 0.05);
  for (int iteration = 0; iteration < 8; ++iteration) {
    field.linearize();
    std::vector<double> delta = field.residual();
    for (double& value : delta) value = -value;
    for (Index f = 0; f < scene.mesh.fibers(); ++f) field.solve(f, &delta[6 * scene.mesh.first_node[f]]);
    field.increment(delta);
  }
  for (std::size_t i = 0; i < size; ++i) EXPECT_NEAR(field.dofs()[i], expected[i], 1e-9);
}

TEST(BeamField, UnsupportedStaticFiberIsAStatusNotAnException) {
  // on the last rank only: every rank must hear of it
  Comm comm;
  mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, 2);
  FiberParameters group = test::stiffness(10.0, 1.0);
  group.start = comm.rank() + 1 == comm.size() ? EndCondition::free : EndCondition::clamped;
  group.loads = {test::load(LoadType::force, {0, 1, 0})};
  BeamTimeParameters time;
  time.scheme = TimeScheme::static_;
  time.max_iterations = 8;
  BeamField field(mesh, {group}, time, Vec3::Zero());
  field.initialize({});
  field.begin_step(1.0, 1.0);
  EXPECT_EQ(field.solve_step({}), -1);
}

TEST(BeamField, NotANumberIsAStatusNotAnException) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, 2);
  FiberParameters group = test::stiffness(10.0, 1.0);
  group.start = EndCondition::clamped;
  BeamField field(mesh, {group}, {}, Vec3::Zero());
  field.initialize({});
  field.begin_step(0.1, 0.1);
  std::vector<double> force(6 * static_cast<std::size_t>(mesh.nodes()), 0.0);
  if (mesh.comm.rank() == 0) force[7] = nan;  // every rank must hear of it
  EXPECT_EQ(field.solve_step(force), -1);
  field.begin_step(0.1, 0.1);
  std::vector<double> delta(force.size(), 0.0);
  delta[7] = nan;
  field.increment(delta);
  field.linearize();
  std::vector<double> x(force.size(), 1.0);
  field.solve(0, x.data());
  EXPECT_FALSE(std::isfinite(x[7]));
}

TEST(BeamField, RefusesACurvedReference) {
  mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, 2);
  if (mesh.comm.rank() == 0) mesh.position[4] = 0.1;
  try {
    BeamField field(mesh, {test::stiffness(1, 1)}, {}, Vec3::Zero());
    FAIL() << "a curved fiber was accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::geometry);
    EXPECT_NE(std::string(error.what()).find("straight"), std::string::npos);
  }
}

TEST(BeamField, HighestFrequencyOfOneElementIsItsAxialOrBendingMode) {
  // one free element: bending sqrt(8400 EI/m)/l^2, axial modes of the cubic element: largest root found from K and M
  const mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {0, 0, 1}, 2.0, 1);
  BeamField bending(mesh, {test::stiffness(1e-6, 3.0, 2.0)}, {}, Vec3::Zero());
  EXPECT_NEAR(bending.highest_frequency(), std::sqrt(8400 * 3.0 / 2.0) / 4.0, 1e-6 * bending.highest_frequency());
}

}  // namespace
}  // namespace fbi::beam
