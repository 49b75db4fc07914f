/// Rigid fibers against exact motions: pendulum of large amplitude, free flight, a stiff flexible fiber.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "convergence/momenta.hpp"
#include "record.hpp"

namespace fbi::beam {
namespace {

using test::formulas;
using test::order;

FiberParameters rigid(double radius = 0.01, double density = 1000) {
  FiberParameters group;
  group.name = "rod";
  group.formulation = Formulation::rigid;
  group.section.radius = radius;
  group.material.density = density;
  return group;
}

double mass_of(const FiberParameters& group) {
  return group.material.density * M_PI * std::pow(group.section.radius, 2);
}

// Largest deviation of the nodes' distances from those of the reference.
double deformation(const mesh::FiberMesh& mesh, const std::vector<double>& dofs) {
  double largest = 0.0;
  for (Index i = 0; i < mesh.nodes(); ++i)
    for (Index j = 0; j < i; ++j) {
      const double rest = (Vec3(&mesh.position[3 * i]) - Vec3(&mesh.position[3 * j])).norm();
      largest = std::max(largest, std::abs((Vec3(&dofs[6 * i]) - Vec3(&dofs[6 * j])).norm() - rest));
    }
  return largest;
}

struct Swing {
  double period = 0.0, energy_error = 0.0, deformation = 0.0;
};

// Released at rest from the horizontal: the period from the times at which the velocity of the tip changes its sign.
Swing swing(int steps_per_unit, double rho_inf) {
  const mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, 3);
  FiberParameters group = rigid(0.05);
  group.start = EndCondition::pinned;
  BeamTimeParameters time;
  time.rho_inf = rho_inf;
  BeamField field(mesh, {group}, time, {0, -9.81, 0});
  field.initialize({});
  Swing result;
  const double dt = 1.0 / steps_per_unit;
  double last_turn = 0.0, turn = 0.0;
  int turns = 0;
  for (int step = 1; step <= 8 * steps_per_unit && turns < 4; ++step) {
    field.begin_step(step * dt, dt);
    if (field.solve_step({}) < 0) break;
    field.accept_step();
    const std::vector<double>&d = field.accepted_dofs(), &v = field.accepted_velocity();
    const std::size_t tip = d.size() - 6;
    last_turn = turn;
    turn = d[tip] * v[tip + 1] - d[tip + 1] * v[tip];  // angular velocity
    if (step > 1 && turn * last_turn < 0 && ++turns == 4)
      result.period = 0.5 * ((step - 1) * dt + dt * last_turn / (last_turn - turn));
    const Energy energy = field.energy();
    result.energy_error = std::max(result.energy_error, std::abs(energy.kinetic - energy.external_work));
    result.deformation = std::max(result.deformation, deformation(mesh, d));
  }
  return result;
}

TEST(RigidPendulum, PeriodOfTheEllipticIntegral) {
  const double j = 1.0 / 3 + 0.25 * 0.05 * 0.05;  // of the line and of the section, per mass
  const double exact = 4 * std::comp_ellint_1(std::sin(M_PI / 4)) / std::sqrt(9.81 * 0.5 / j);
  for (const double rho_inf : {1.0, 0.8, 0.0}) {
    std::vector<double> error;
    Swing s;
    for (const int steps : {100, 200, 400, 800}) {
      s = swing(steps, rho_inf);
      error.push_back(std::abs(s.period / exact - 1));
      EXPECT_LE(s.deformation, 1e-14);
    }
    std::printf("rigid pendulum, rho_inf %.1f: errors of the period %.2e %.2e %.2e %.2e, order %.2f, energy %.1e\n",
                rho_inf, error[0], error[1], error[2], error[3], 0.5 * std::log2(error[1] / error[3]), s.energy_error);
    EXPECT_NEAR(0.5 * std::log2(error[1] / error[3]), 2.0, 0.1);
    EXPECT_LE(error[3], 2e-5);
    test::record({.section = "Fibers: dynamics",
                  .id = "",
                  .check = "rigid rod, pendulum released from the horizontal, period, dt 1.25e-3, rho_inf " +
                           std::to_string(rho_inf).substr(0, 3),
                  .source = "exact solution (elliptic integral)",
                  .reference = exact,
                  .ours = s.period,
                  .order = 0.5 * std::log2(error[1] / error[3]),
                  .bar = "2e-5, order 2 +- 0.1"});
  }
}

// A curved rigid fiber thrown with a spin about no principal axis.
TEST(RigidFlight, MomentaOfATumblingArc) {
  const mesh::FiberMesh mesh = test::quarter_circle(0.5, 4);
  FiberParameters group = rigid(1e-4);
  group.velocity = formulas("1+2*z-3*y", "0.5+3*x-z", "-0.2-2*x+y");  // (1, 0.5, -0.2) + (1, 2, 3) x r
  std::vector<double> error;
  double momentum_error = 0.0, shape = 0.0;
  for (const int steps : {100, 200, 400}) {
    BeamField field(mesh, {group}, {}, Vec3::Zero());
    field.initialize({});
    const Vec3 p = field.linear_momentum(field.velocity());
    const Vec3 l = test::angular_momentum(mesh, mass_of(group), field.dofs(), field.velocity());
    const double energy = field.energy().kinetic;
    double largest = 0.0;
    for (int step = 1; step <= 2 * steps; ++step) {
      field.begin_step(step / double(steps), 1.0 / steps);
      ASSERT_GE(field.solve_step({}), 0);
      field.accept_step();
      const std::vector<double>&d = field.accepted_dofs(), &v = field.accepted_velocity();
      momentum_error = std::max(momentum_error, (field.linear_momentum(v) - p).norm() / p.norm());
      largest = std::max(largest, (test::angular_momentum(mesh, mass_of(group), d, v) - l).norm() / l.norm());
      shape = std::max(shape, deformation(mesh, d));
    }
    error.push_back(largest);
    std::printf("tumbling arc, %d steps a unit: angular momentum %.2e, energy %.2e\n", steps, largest,
                std::abs(field.energy().kinetic / energy - 1));
  }
  std::printf("tumbling arc: linear momentum %.1e, shape %.1e, order %.2f\n", momentum_error, shape,
              order(error[1], error[2]));
  EXPECT_LE(momentum_error, 1e-12);
  EXPECT_LE(shape, 1e-14);
  EXPECT_NEAR(order(error[1], error[2]), 2.0, 0.2);
  EXPECT_LE(error[2], 1e-4);
  test::record({.section = "Fibers: dynamics",
                .id = "",
                .check = "rigid quarter circle in free flight, drift of the angular momentum at t <= 2, dt 2.5e-3",
                .source = "identity",
                .reference = 0.0,
                .ours = error[2],
                .order = order(error[1], error[2]),
                .bar = "1e-4, order 2 +- 0.2"});
}

// A rod that follows its moved pin, against a flexible one so stiff that it stays straight.
TEST(RigidRod, IsTheLimitOfAStiffFiber) {
  const mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {0, -1, 0}, 1.0, 4);
  FiberParameters group = rigid(0.01);
  Support pin;
  pin.motion = formulas("0.1*sin(3*t)^2", "0.05*(1-cos(5*t))", "0.1*t*t");
  group.supports = {pin};
  group.loads = {test::load(LoadType::force, {0.5, 0, 0.3})};
  FiberParameters flexible = group;
  flexible.formulation = Formulation::torsion_free;
  double last = 0.0;
  for (const double young : {1e9, 1e10}) {
    flexible.material.young = young;
    BeamTimeParameters time;
    time.rho_inf = 0.5;
    BeamField a(mesh, {group}, time, {0, -9.81, 0}), b(mesh, {flexible}, time, {0, -9.81, 0});
    a.initialize({});
    b.initialize({});
    double difference = 0.0, reaction = 0.0;
    for (int step = 1; step <= 1000; ++step) {
      for (BeamField* field : {&a, &b}) {
        field->begin_step(step * 1e-3, 1e-3);
        ASSERT_GE(field->solve_step({}), 0);
        field->accept_step();
      }
      for (std::size_t i = 0; i < a.dofs().size(); i += 6)
        difference = std::max(difference, (Vec3(&a.dofs()[i]) - Vec3(&b.dofs()[i])).norm());
      if (step < 200) continue;  // the flexible rod rings at first
      const Vec3 r(&a.reactions({})[0]), s(&b.reactions({})[0]);
      reaction = std::max(reaction, (r - s).norm() / r.norm());
    }
    std::printf("rod on a moved pin, E %.0e: largest difference of rigid and flexible %.2e, of reactions %.2e\n", young,
                difference, reaction);
    EXPECT_LE(difference, young == 1e9 ? 5e-3 : 5e-4);
    if (young == 1e10) {
      EXPECT_NEAR(std::log10(last / difference), 1.0, 0.2);  // as 1/E
    }
    if (young == 1e10)
      test::record({.section = "Fibers: dynamics",
                    .id = "",
                    .check = "rigid rod on a moved pin against a flexible one, E = 1e10 (1e9), largest difference",
                    .source = "limit E to infinity, difference as 1/E",
                    .reference = 0.0,
                    .ours = difference,
                    .bar = "5e-4"});
    last = difference;
  }
}

TEST(RigidRod, SupportsAndReactions) {
  const mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, 4);
  const auto reaction_of = [&](EndCondition condition, Vec3& tip) {
    FiberParameters group = rigid();
    group.start = condition;
    group.loads = {test::load(LoadType::force, {0.3, 0.2, 0})};
    BeamField field(mesh, {group}, {}, Vec3::Zero());
    field.initialize({});
    for (int step = 1; step <= 10; ++step) {
      field.begin_step(0.01 * step, 0.01);
      EXPECT_GE(field.solve_step({}), 0);
      field.accept_step();
    }
    tip = Vec3(&field.dofs()[field.dofs().size() - 6]);
    const std::vector<double> r = field.reactions({});
    return std::array<Vec3, 2>{Vec3(&r[0]), Vec3(&r[3])};
  };
  Vec3 tip;
  const auto clamped = reaction_of(EndCondition::clamped, tip);
  EXPECT_LE((tip - Vec3(1, 0, 0)).norm(), 1e-15);
  EXPECT_LE((clamped[0] + Vec3(0.3, 0.2, 0)).norm(), 1e-12);
  EXPECT_LE((clamped[1] - Vec3(0, -0.2, 0)).norm(), 1e-12);  // moment -0.2 about z on the tangent along x
  const auto guided = reaction_of(EndCondition::guided, tip);
  const double mass = 1000 * M_PI * 1e-4;
  EXPECT_LE((tip - Vec3(1, 0.5 * 0.2 / mass * 0.01, 0)).norm(), 1e-12);
  EXPECT_LE((guided[0] - Vec3(-0.3, 0, 0)).norm(), 1e-12);
  EXPECT_LE((guided[1] - Vec3(0, -0.1, 0)).norm(), 1e-12);  // half of the force is inertia, on half the arm
}

TEST(RigidRod, StateRestoresBitwise) {
  const mesh::FiberMesh mesh = test::quarter_circle(0.5, 3);
  FiberParameters group = rigid();
  group.velocity = formulas("2*z-3*y", "3*x-z", "-2*x+y");
  BeamField field(mesh, {group}, {}, {0, -1, 0}), other(mesh, {group}, {}, {0, -1, 0});
  field.initialize({});
  const auto step = [](BeamField& each, int n) {
    each.begin_step(0.02 * n, 0.02);
    ASSERT_GE(each.solve_step({}), 0);
    each.accept_step();
  };
  for (int n = 1; n <= 5; ++n) step(field, n);
  auto from = field.state(), to = other.state();
  ASSERT_EQ(from.size(), to.size());
  for (std::size_t i = 0; i < from.size(); ++i) *to[i].second = *from[i].second;
  for (int n = 6; n <= 9; ++n) {
    step(field, n);
    step(other, n);
  }
  EXPECT_EQ(field.dofs(), other.dofs());
  EXPECT_EQ(field.velocity(), other.velocity());
}

// The increments of a coupled scheme: solve and increment reach the step of the built-in Newton.
TEST(RigidRod, LinearizeSolveIncrement) {
  const mesh::FiberMesh mesh = test::quarter_circle(0.5, 3);
  FiberParameters group = rigid();
  group.velocity = formulas("2*z-3*y", "3*x-z", "-2*x+y");
  BeamField field(mesh, {group}, {}, {0, -1, 0});
  field.initialize({});
  std::vector<double> force(6 * static_cast<std::size_t>(mesh.nodes()), 0.0);
  for (std::size_t i = 0; i < force.size(); ++i) force[i] = 0.01 * std::sin(double(i));
  field.begin_step(0.05, 0.05);
  ASSERT_GE(field.solve_step(force), 0);
  const std::vector<double> expected = field.dofs();
  field.begin_step(0.05, 0.05);
  for (int iteration = 0; iteration < 12; ++iteration) {
    field.linearize();
    std::vector<double> delta = force;
    for (std::size_t i = 0; i < delta.size(); ++i) delta[i] -= field.residual()[i];
    field.solve(0, delta.data());
    field.increment(delta);
  }
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(field.dofs()[i], expected[i], 1e-12);
  field.linearize();
  std::vector<double> unbalanced = field.residual();
  for (std::size_t i = 0; i < force.size(); ++i) unbalanced[i] -= force[i];
  field.remove_constrained(unbalanced);
  for (const double value : unbalanced) EXPECT_NEAR(value, 0.0, 1e-12);
}

}  // namespace
}  // namespace fbi::beam
