/// Forces beside the stored energy: conserving scheme, damping, follower loads, supports, prescribed fibers.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "base/error.hpp"
#include "beam/formulation.hpp"
#include "unit/beam/straight_fiber.hpp"

namespace fbi::beam {
namespace {

using Vector = Eigen::Matrix<double, 12, 1>;
using Matrix = Eigen::Matrix<double, 12, 12, Eigen::RowMajor>;

const ElementProperties element{0.4, 37.0, 0.9, 1.7};

Vector deformed(double amplitude, unsigned seed) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> random(-1.0, 1.0);
  Vector q;
  q << 0, 0, 0, 1, 0, 0, 0.4, 0, 0, 1, 0, 0;
  for (int i = 0; i < 12; ++i) q[i] += amplitude * random(generator) * (i % 6 < 3 ? 0.4 : 1.0);
  return q;
}

const ElementFormulation& formulation() { return *element_formulation(Formulation::torsion_free); }

template <class Function>
Matrix differences(const Function& f, const Vector& q) {
  const double h = 1e-4;
  Matrix result;
  for (int i = 0; i < 12; ++i) {
    const auto at = [&](double step) { return Vector(f(q + step * Vector::Unit(i))); };
    result.col(i) = (45.0 * (at(h) - at(-h)) - 9.0 * (at(2 * h) - at(-2 * h)) + (at(3 * h) - at(-3 * h))) / (60 * h);
  }
  return result;
}

TEST(ConservingForce, WorkIsTheChangeOfEnergyAndNoResultantIsLeft) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Vector last = deformed(0.4, seed), next = deformed(0.4, seed + 10);
    Vector force;
    formulation().conserving_force(element, last.data(), next.data(), force.data(), nullptr);
    const double change = formulation().energy(element, next.data()) - formulation().energy(element, last.data());
    EXPECT_NEAR(force.dot(next - last), change, 1e-12 * force.norm());
    const Vec3 sum = force.segment<3>(0) + force.segment<3>(6);
    EXPECT_LE(sum.norm(), 1e-12 * force.norm());
    Vec3 moment = Vec3::Zero();
    for (int i = 0; i < 4; ++i)
      moment += Vec3(0.5 * (last + next).segment<3>(3 * i)).cross(Vec3(force.segment<3>(3 * i)));
    EXPECT_LE(moment.norm(), 1e-12 * force.norm());
  }
}

TEST(ConservingForce, EqualsTheGradientForASmallStepAndItsTangentIsExact) {
  const Vector last = deformed(0.4, 3), next = deformed(0.4, 4);
  Vector force, gradient;
  formulation().conserving_force(element, last.data(), last.data(), force.data(), nullptr);
  formulation().internal_force(element, last.data(), gradient.data(), nullptr);
  EXPECT_LE((force - gradient).norm(), 1e-12 * gradient.norm());
  Matrix tangent;
  formulation().conserving_force(element, last.data(), next.data(), force.data(), tangent.data());
  const Matrix expected = differences(
      [&](const Vector& q) {
        Vector f;
        formulation().conserving_force(element, last.data(), q.data(), f.data(), nullptr);
        return f;
      },
      next);
  EXPECT_LE((tangent - expected).norm(), 1e-8 * expected.norm());
}

// Rates of a rigid motion.
Vector rigid_rate(const Vector& q, const Vec3& spin, const Vec3& shift) {
  Vector v;
  for (int i = 0; i < 4; ++i) {
    Vec3 rate = spin.cross(Vec3(q.segment<3>(3 * i)));
    if (i % 2 == 0) rate += shift;
    v.segment<3>(3 * i) = rate;
  }
  return v;
}

TEST(ViscousForce, VanishesInRigidMotionAndDissipates) {
  // straight: any motion; bent: turns about the normal of its plane (about its own tangent a fiber does not spin)
  Vector q = deformed(0.4, 6), v, force;
  const Vector straight = 1.1 * deformed(0.0, 1);
  v = rigid_rate(straight, {0.3, -0.7, 1.1}, {0.2, 0.5, -0.4});
  formulation().viscous_force(element, straight.data(), v.data(), force.data(), nullptr, nullptr);
  EXPECT_LE(force.norm(), 1e-12 * element.axial_stiffness);
  Vector planar = q;
  for (int i = 0; i < 4; ++i) planar[3 * i + 2] = 0.0;
  v = rigid_rate(planar, {0, 0, 1.1}, {0.2, 0.5, -0.4});
  formulation().viscous_force(element, planar.data(), v.data(), force.data(), nullptr, nullptr);
  EXPECT_LE(force.norm(), 1e-12 * element.axial_stiffness);
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Vector rate = deformed(1.0, seed + 20);
    formulation().viscous_force(element, q.data(), rate.data(), force.data(), nullptr, nullptr);
    EXPECT_GT(force.dot(rate), 0.0);
  }
}

TEST(ViscousForce, TangentsAreExactAndAtRestThatOfTheStiffness) {
  const Vector q = deformed(0.4, 7), v = deformed(0.6, 8);
  Vector force;
  Matrix by_q, by_v;
  formulation().viscous_force(element, q.data(), v.data(), force.data(), by_q.data(), by_v.data());
  const auto at = [&](const Vector& dofs, const Vector& rate) {
    Vector f;
    formulation().viscous_force(element, dofs.data(), rate.data(), f.data(), nullptr, nullptr);
    return f;
  };
  const Matrix expected_q = differences([&](const Vector& x) { return at(x, v); }, q);
  const Matrix expected_v = differences([&](const Vector& x) { return at(q, x); }, v);
  EXPECT_LE((by_q - expected_q).norm(), 1e-8 * expected_q.norm());
  EXPECT_LE((by_v - expected_v).norm(), 1e-8 * expected_v.norm());
  const Vector straight = deformed(0.0, 1);
  Matrix stiffness;
  formulation().internal_force(element, straight.data(), force.data(), stiffness.data());
  formulation().viscous_force(element, straight.data(), v.data(), force.data(), by_q.data(), by_v.data());
  EXPECT_LE((by_v - stiffness).norm(), 1e-12 * stiffness.norm());
}

// ------------------------------------------------------------------------------------------------------------ field

input::VectorExpression formulas(const std::string& x, const std::string& y, const std::string& z) {
  return {input::Expression(x), input::Expression(y), input::Expression(z)};
}

// Everything at once: follower loads, damping, an interior support, a clamp that moves and turns.
struct Scene {
  mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, 6);
  FiberParameters group = test::stiffness(40.0, 0.7, 1.3);
  BeamTimeParameters time;
  explicit Scene(TimeScheme scheme) {
    time.scheme = scheme;
    time.rho_inf = 0.7;
    Support clamp;
    clamp.type = EndCondition::clamped;
    clamp.motion = formulas("0.1*sin(2*t)^2", "0.2*(1-cos(t))", "0");
    clamp.direction = formulas("cos(0.4*t*t)", "sin(0.4*t*t)", "0");
    Support inner;
    inner.arc_length = 0.5;
    inner.motion = formulas("0", "0.15*(1-cos(t))", "0.02*t*t");
    group.supports = {clamp, inner};
    Load follower = test::load(LoadType::force, {0.1, -0.2, 0.3});
    follower.follower = true;
    Load pressure = test::load(LoadType::line, {0.0, 0.4, 0.1});
    pressure.follower = true;
    Load moment = test::load(LoadType::moment, {0.1, 0.05, -0.1});
    moment.arc_length = 0.7;
    moment.follower = true;
    Load point = test::load(LoadType::force, {0.0, 0.1, 0.2});
    point.arc_length = 0.3;
    Load end = test::load(LoadType::moment, {0, 0, 0});
    end.value = formulas("0.5*t", "t", "0.5*t");  // suddenly applied it would set the stiffest modes ringing
    moment.value = formulas("0.5*t", "0.2*t", "-0.5*t");
    group.loads = {follower, pressure, moment, point, end};
    group.damping = {0.3, 0.02};
  }
};

void step(BeamField& field, int number, double dt) {
  field.begin_step(dt * number, dt);
  ASSERT_GE(field.solve_step({}), 0);
  field.accept_step();
}

TEST(Options, SolveInvertsTheDerivativeOfTheResidual) {
  for (const TimeScheme scheme : {TimeScheme::generalized_alpha, TimeScheme::midpoint}) {
    Scene scene(scheme);
    scene.group.supports[0].direction.reset();  // the tangent leaves out how the stretch turns with the clamp
    BeamField field(scene.mesh, {scene.group}, scene.time, {0, -0.1, 0});
    field.initialize({});
    for (int n = 1; n <= 3; ++n) step(field, n, 0.05);
    field.begin_step(0.2, 0.05);
    const std::size_t size = 6 * static_cast<std::size_t>(scene.mesh.nodes());
    std::mt19937 generator(5);
    std::uniform_real_distribution<double> random(-1.0, 1.0);
    std::vector<double> direction(size);
    for (double& value : direction) value = random(generator);
    field.linearize();
    field.solve(0, direction.data());
    double norm = 0.0;
    for (const double value : direction) norm = std::max(norm, std::abs(value));
    for (double& value : direction) value /= norm;
    const double h = 1e-5;
    const auto residual_at = [&](double length) {
      std::vector<double> delta(size);
      for (std::size_t i = 0; i < size; ++i) delta[i] = length * direction[i];
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
    field.solve(0, image.data());
    for (std::size_t i = 0; i < size; ++i) EXPECT_NEAR(image[i], direction[i], 1e-6);
  }
}

TEST(Options, SupportsAreWhereTheyAreSent) {
  for (const TimeScheme scheme : {TimeScheme::generalized_alpha, TimeScheme::midpoint}) {
    const Scene scene(scheme);
    BeamField field(scene.mesh, {scene.group}, scene.time, Vec3::Zero());
    field.initialize({});
    for (int n = 1; n <= 20; ++n) step(field, n, 0.02);
    const double t = 0.4;
    const std::vector<double>&d = field.accepted_dofs(), &v = field.accepted_velocity();
    EXPECT_LE((Vec3(&d[0]) - Vec3(0.1 * std::pow(std::sin(2 * t), 2), 0.2 * (1 - std::cos(t)), 0)).norm(), 1e-14);
    EXPECT_LE((Vec3(&v[0]) - Vec3(0.2 * std::sin(4 * t), 0.2 * std::sin(t), 0)).norm(), 1e-8);
    EXPECT_LE((Vec3(&d[3]).normalized() - Vec3(std::cos(0.4 * t * t), std::sin(0.4 * t * t), 0)).norm(), 1e-14);
    EXPECT_LE((Vec3(&d[18]) - Vec3(0.5, 0.15 * (1 - std::cos(t)), 0.02 * t * t)).norm(), 1e-14);
  }
}

TEST(Options, StateRestoresBitwise) {
  for (const TimeScheme scheme : {TimeScheme::generalized_alpha, TimeScheme::midpoint}) {
    const Scene scene(scheme);
    BeamField field(scene.mesh, {scene.group}, scene.time, Vec3::Zero()),
        other(scene.mesh, {scene.group}, scene.time, Vec3::Zero());
    field.initialize({});
    for (int n = 1; n <= 4; ++n) step(field, n, 0.05);
    auto from = field.state(), to = other.state();
    ASSERT_EQ(from.size(), to.size());
    for (std::size_t i = 0; i < from.size(); ++i) *to[i].second = *from[i].second;
    for (int n = 5; n <= 8; ++n) {
      step(field, n, 0.05);
      step(other, n, 0.05);
    }
    EXPECT_EQ(field.dofs(), other.dofs());
    EXPECT_EQ(field.acceleration(), other.acceleration());
  }
}

TEST(Supports, GuidedEndDeflectsLikeAFrameColumn) {
  // F L^3/(12 EI), a twelfth of it at small load; the reaction along the fiber and the moment balance the load
  mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, 4);
  FiberParameters group = test::stiffness(1e4, 1.0);
  group.start = EndCondition::clamped;
  group.end = EndCondition::guided;
  const double force = 1e-5;
  group.loads = {test::load(LoadType::force, {0, force, 0})};
  const test::StaticSolution s = test::solve_static(mesh, group, 1);
  ASSERT_TRUE(s.converged);
  EXPECT_NEAR(s.tip()[1], force / 12, 1e-9 * force);
  EXPECT_EQ(s.tip()[0], 1.0);
  EXPECT_NEAR(s.dofs[s.dofs.size() - 2], 0.0, 1e-16);
}

TEST(Supports, BeamOnThreeSupportsAndPointLoadBetweenNodes) {
  // two equal spans of length 1, force F in the middle of the first: reactions 13/32, 22/32, -3/32 of F
  mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 2.0, 10);
  FiberParameters group = test::stiffness(1e4, 1.0);
  group.start = EndCondition::pinned;
  Support inner, last;
  inner.arc_length = 1.0;
  last.at = End::end;
  group.supports = {inner, last};
  const double force = -1e-4;
  Load load = test::load(LoadType::force, {0, force, 0});
  load.arc_length = 0.5;  // the middle of an element
  group.loads = {load};
  BeamTimeParameters time;
  time.scheme = TimeScheme::static_;
  BeamField field(mesh, {group}, time, Vec3::Zero());
  field.initialize({});
  field.begin_step(1.0, 1.0);
  ASSERT_GE(field.solve_step({}), 0);
  field.accept_step();
  const std::vector<double> r = field.reactions({});
  EXPECT_NEAR(r[1], -13.0 / 32 * force, 2e-6 * std::abs(force));
  EXPECT_NEAR(r[6 * 5 + 1], -22.0 / 32 * force, 2e-6 * std::abs(force));
  EXPECT_NEAR(r[6 * 10 + 1], 3.0 / 32 * force, 2e-6 * std::abs(force));
}

TEST(Supports, BetweenNodesTwiceOrNotAtRestAreRefused) {
  const mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, 4);
  const auto message = [&](const FiberParameters& group) -> std::string {
    try {
      BeamField field(mesh, {group}, {}, Vec3::Zero());
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::geometry);
      return error.what();
    }
    return "";
  };
  FiberParameters group = test::stiffness(10.0, 1.0);
  Support support;
  support.arc_length = 0.3;
  group.supports = {support};
  EXPECT_NE(message(group).find("between nodes"), std::string::npos);
  group.supports[0].arc_length = 0.0;
  group.start = EndCondition::pinned;
  EXPECT_NE(message(group).find("twice"), std::string::npos);
  group.start = EndCondition::free;
  group.supports[0].motion = formulas("0.1+t", "0", "0");
  EXPECT_NE(message(group).find("zero at t = 0"), std::string::npos);
  group.supports[0].motion.reset();
  group.supports[0].type = EndCondition::clamped;
  group.supports[0].direction = formulas("0", "1", "0");
  EXPECT_NE(message(group).find("direction"), std::string::npos);
}

TEST(Loads, BuoyancyTakesOffTheDisplacedFluid) {
  const mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, 4);
  FiberParameters group = test::stiffness(10.0, 1.0, 3.0);
  group.displaced_density = 0.25 * group.material.density;
  BeamField field(mesh, {group}, {}, {0, 0, -2});
  field.initialize({});
  Vec3 force = field.linear_momentum(field.acceleration());
  EXPECT_LE((force - Vec3(0, 0, -2 * 3.0 * 0.75)).norm(), 1e-12);
}

TEST(Prescribed, PositionsTangentsAndRatesOfAWave) {
  const mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, 5);
  FiberParameters group;
  group.formulation = Formulation::prescribed;
  group.motion = formulas("0", "0.1*sin(3*x-2*t)", "0.05*x*t");
  BeamField field(mesh, {group}, {}, {0, 0, -2});
  EXPECT_EQ(field.moving_fibers(), 0);
  EXPECT_TRUE(field.is_fixed(0));
  field.initialize({});
  for (int n = 1; n <= 7; ++n) step(field, n, 0.01);
  const double t = 0.07;
  for (Index node = 0; node < mesh.nodes(); ++node) {
    const double x = 0.2 * node, p = 3 * x - 2 * t;
    const double* d = &field.accepted_dofs()[6 * node];
    const double* v = &field.accepted_velocity()[6 * node];
    const double* a = &field.accepted_acceleration()[6 * node];
    EXPECT_LE((Vec3(d) - Vec3(x, 0.1 * std::sin(p), 0.05 * x * t)).norm(), 1e-15);
    EXPECT_LE((Vec3(d + 3) - Vec3(1, 0.3 * std::cos(p), 0.05 * t)).norm(), 1e-9);
    EXPECT_LE((Vec3(v) - Vec3(0, -0.2 * std::cos(p), 0.05 * x)).norm(), 1e-9);
    EXPECT_LE((Vec3(v + 3) - Vec3(0, 0.6 * std::sin(p), 0.05)).norm(), 1e-7);
    EXPECT_LE((Vec3(a) - Vec3(0, -0.4 * std::sin(p), 0)).norm(), 1e-7);
  }
}

}  // namespace
}  // namespace fbi::beam
