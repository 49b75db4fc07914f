/// The beam with shear and torsion: variation, tangent, objectivity, elimination of the triads, state.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "base/error.hpp"
#include "record.hpp"
#include "unit/beam/curved_fiber.hpp"

namespace fbi::beam {
namespace {

using Dofs = Eigen::Matrix<double, 12, 1>;
using Triads = std::array<Quaternion, 3>;

struct ElementCase {
  Dofs q;
  Triads triads;
  TriadSection section;
  TriadElement element;

  static Dofs reference() {
    Dofs q;
    const Vec3 t1 = Vec3(1, 0.2, -0.1).normalized(), t2 = Vec3(0.8, 0.5, 0.3).normalized();
    q << 0.1, -0.2, 0.3, t1, 1.1, 0.2, 0.35, t2;
    return q;
  }
  static Triads reference_triads() {
    return {turned_to(exponential({0.3, 0, 0}), reference().segment<3>(3)),
            turned_to(exponential({0.4, 0, 0}), Vec3(0.95, 0.35, 0.1).normalized()),
            turned_to(exponential({0.6, 0, 0}), reference().segment<3>(9))};
  }
  // Far from rest: relative rotations up to 1.5 rad, strains of order one.
  ElementCase() : element(1.05, reference().data(), reference_triads()) {
    section.force = {7.0, 2.0, 3.0};
    section.moment = {0.5, 0.8, 1.3};
    std::mt19937 generator(7);
    std::uniform_real_distribution<double> random(-1, 1);
    q = reference();
    for (int i = 0; i < 12; ++i) q[i] += 0.3 * random(generator);
    triads = reference_triads();
    for (Quaternion& triad : triads)
      triad = triad * exponential(0.8 * Vec3(random(generator), random(generator), random(generator)));
  }
  // Moved by `step` along unknown `i` of the element.
  ElementCase moved(int i, double step) const {
    ElementCase result = *this;
    for (int j = 0; j < 4; ++j)
      if (i >= center_line_place[j] && i < center_line_place[j] + 3) result.q[3 * j + i - center_line_place[j]] += step;
    for (int c = 0; c < 3; ++c)
      if (i >= triad_place[c] && i < triad_place[c] + 3)
        result.triads[c] = triads[c] * exponential(step * Vec3::Unit(i - triad_place[c]));
    return result;
  }
  double energy() const { return triad_energy(section, element, q.data(), triads); }
  Eigen::VectorXd residual() const {
    Eigen::VectorXd r(triad_element_dofs);
    triad_internal_force(section, element, q.data(), triads, r.data(), nullptr);
    return r;
  }
};

TEST(TriadElement, ResidualIsTheVariationOfTheEnergy) {
  const ElementCase element;
  const Eigen::VectorXd r = element.residual();
  double error = 0.0;
  for (int i = 0; i < triad_element_dofs; ++i) {
    const auto difference = [&](double h) {
      return (element.moved(i, h).energy() - element.moved(i, -h).energy()) / (2 * h);
    };
    error = std::max(error, std::abs((4 * difference(1e-3) - difference(2e-3)) / 3 - r[i]));
  }
  error /= r.cwiseAbs().maxCoeff();
  std::printf("residual against differences of the energy: %.1e\n", error);
  EXPECT_LE(error, 1e-9);
  test::record({.section = "Fibers: statics",
                .id = "",
                .check = "simo_reissner: residual is the exact variation of the energy (differences), 21 unknowns",
                .source = "identity",
                .reference = 0.0,
                .ours = error,
                .bar = "1e-9"});
}

TEST(TriadElement, TangentIsTheDerivativeOfTheResidual) {
  const ElementCase element;
  Eigen::Matrix<double, triad_element_dofs, triad_element_dofs, Eigen::RowMajor> tangent;
  Eigen::VectorXd r(triad_element_dofs);
  triad_internal_force(element.section, element.element, element.q.data(), element.triads, r.data(), tangent.data());
  EXPECT_LE((r - element.residual()).norm(), 1e-13 * r.norm());
  double error = 0.0;
  for (int i = 0; i < triad_element_dofs; ++i) {
    const double h = 1e-5;
    const Eigen::VectorXd column = (element.moved(i, h).residual() - element.moved(i, -h).residual()) / (2 * h);
    error = std::max(error, (column - tangent.col(i)).cwiseAbs().maxCoeff());
  }
  error /= tangent.cwiseAbs().maxCoeff();
  std::printf("tangent against differences of the residual: %.1e\n", error);
  EXPECT_LE(error, 1e-8);
  test::record({.section = "Fibers: statics",
                .id = "",
                .check = "simo_reissner: tangent against central differences of the residual",
                .source = "identity",
                .reference = 0.0,
                .ours = error,
                .bar = "1e-8"});
}

TEST(TriadElement, EnergyIsObjectiveAndRestIsFreeOfStress) {
  ElementCase element;
  const double energy = element.energy();
  const Quaternion turn = exponential({1.9, -0.7, 2.1});
  ElementCase turned = element;
  for (int i = 0; i < 4; ++i) turned.q.segment<3>(3 * i) = turn * Vec3(element.q.segment<3>(3 * i));
  for (int i = 0; i < 4; i += 2) turned.q.segment<3>(3 * i) += Vec3(3, -1, 2);
  for (Quaternion& triad : turned.triads) triad = turn * triad;
  const double error = std::abs(turned.energy() / energy - 1);
  std::printf("energy %.6f, after a rigid motion %.1e\n", energy, error);
  EXPECT_LE(error, 1e-12);
  test::record({.section = "Fibers: statics",
                .id = "",
                .check = "simo_reissner: energy of a strongly deformed element after a rigid rotation of 2.9 rad",
                .source = "identity",
                .reference = energy,
                .ours = turned.energy(),
                .bar = "1e-12"});
  element.q = ElementCase::reference();
  element.triads = ElementCase::reference_triads();
  EXPECT_LE(element.residual().norm(), 1e-14);
  EXPECT_EQ(element.energy(), 0.0);
}

TEST(Rotation, MapsAndSeriesAgreeWithDifferences) {
  for (const double angle : {0.0, 1e-9, 1e-3, 0.5, 2.0, 3.1}) {
    const Vec3 psi = angle * Vec3(2, -1, 2) / 3;
    EXPECT_LE((logarithm(exponential(psi)) - psi).norm(), 4e-15);
    const Mat3 map = inverse_tangent_map(psi);
    for (int k = 0; k < 3; ++k) {
      const double h = 1e-4;
      const auto moved = [&](double step) { return logarithm(exponential(psi) * exponential(step * Vec3::Unit(k))); };
      EXPECT_LE(((moved(h) - moved(-h)) / (2 * h) - map.col(k)).norm(), 1e-5) << angle;
    }
    if (angle < 0.1) continue;
    EXPECT_NEAR(coefficient_b(angle * angle).value, (1 - std::cos(angle)) / (angle * angle), 1e-15);
    EXPECT_NEAR(coefficient_c(angle * angle).value, (angle - std::sin(angle)) / (angle * angle * angle), 1e-15);
    EXPECT_NEAR(coefficient_e(angle * angle).value, (1 - 0.5 * angle / std::tan(0.5 * angle)) / (angle * angle), 1e-14);
  }
}

// ------------------------------------------------------------------------------------------------------------- the
// field

// A curved clamped fiber with a moment, a straight torsion-free one, and a free curved one.
struct Scene {
  mesh::FiberMesh mesh;
  std::vector<FiberParameters> groups;
  BeamTimeParameters time;

  Scene() {
    mesh = test::arc(1.0, 1.2, 3);
    test::add_straight_fiber(mesh, {0, 3, 0}, Vec3(0, 1, 0), 2.0, 2, 1);
    const Index before = mesh.nodes();
    test::add_straight_fiber(mesh, {1, 0, 0}, Vec3(0, 0, 1), 1.2, 4, 2);
    const mesh::FiberMesh other = test::arc(0.8, 1.5, 4);
    for (std::size_t i = 0; i < other.position.size(); ++i) {
      mesh.position[3 * static_cast<std::size_t>(before) + i] = other.position[i];
      mesh.tangent[3 * static_cast<std::size_t>(before) + i] = other.tangent[i];
    }
    FiberParameters first = test::shear_beam(40, 16, 0.9, 1.0, 0.02, 0.03, 0.04, 1.3);
    first.section.direction = {0, 1, 1};
    first.start = EndCondition::clamped;
    first.end = EndCondition::pinned;
    first.loads = {test::load(LoadType::line, {0.1, -0.2, 0.3}), test::load(LoadType::moment, {0.2, 0.1, 0.3})};
    FiberParameters second = test::stiffness(40.0, 0.7, 1.3);
    second.start = EndCondition::clamped;
    FiberParameters third = test::shear_beam(30, 12, 0.9, 1.0, 0.02, 0.03, 0.04, 1.3);
    third.loads = {test::load(LoadType::force, {0.3, 0.1, 0.2}),
                   test::load(LoadType::moment, {0.2, -0.1, 0.1}, End::start)};
    groups = {first, second, third};
    time.rho_inf = 0.7;
  }
  std::size_t size() const { return 6 * static_cast<std::size_t>(mesh.nodes()); }
};

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

// Turns the triads until they are in equilibrium with the center line as it is.
void settle(BeamField& field, std::size_t size) {
  for (int k = 0; k < 5; ++k) {
    field.linearize();
    field.increment(std::vector<double>(size, 0.0));
  }
  field.linearize();
  ASSERT_LE(field.squared_moment_residual(), 1e-20);
}

TEST(TriadField, SolveInvertsTheDerivativeOfTheEliminatedResidual) {
  const Scene scene;
  BeamField field(scene.mesh, scene.groups, scene.time, {0, -0.1, 0});
  set_moving(field, scene.size());
  settle(field, scene.size());
  std::mt19937 generator(5);
  std::uniform_real_distribution<double> random(-1.0, 1.0);
  std::vector<double> direction(scene.size());
  for (double& value : direction) value = random(generator);
  for (Index f = 0; f < scene.mesh.fibers(); ++f) field.solve(f, &direction[6 * scene.mesh.first_node[f]]);
  double norm = 0.0;
  for (double value : direction) norm = std::max(norm, std::abs(value));
  for (double& value : direction) value /= norm;
  const double h = 1e-5;
  const auto residual_at = [&](double step) {
    std::vector<double> delta(scene.size());
    for (std::size_t i = 0; i < delta.size(); ++i) delta[i] = step * direction[i];
    field.increment(delta);
    settle(field, scene.size());
    std::vector<double> residual = field.residual();
    for (double& value : delta) value = -value;
    field.increment(delta);
    settle(field, scene.size());
    return residual;
  };
  const std::vector<double> plus = residual_at(h), minus = residual_at(-h);
  std::vector<double> image(scene.size());
  for (std::size_t i = 0; i < image.size(); ++i) image[i] = (plus[i] - minus[i]) / (2 * h);
  for (Index f = 0; f < scene.mesh.fibers(); ++f) field.solve(f, &image[6 * scene.mesh.first_node[f]]);
  double error = 0.0;
  for (std::size_t i = 0; i < image.size(); ++i) error = std::max(error, std::abs(image[i] - direction[i]));
  std::printf("K_b^-1 times differences of the eliminated residual: %.1e\n", error);
  EXPECT_LE(error, 1e-6);
}

TEST(TriadField, ComplianceIsDInverseTangentDTransposed) {
  const Scene scene;
  BeamField field(scene.mesh, scene.groups, scene.time, Vec3::Zero());
  set_moving(field, scene.size());
  field.linearize();
  std::mt19937 generator(9);
  std::uniform_real_distribution<double> random(-1.0, 1.0);
  for (Index f = 0; f < scene.mesh.fibers(); ++f) {
    const Index nodes = scene.mesh.first_node[f + 1] - scene.mesh.first_node[f], rows = 3;
    std::vector<double> d(static_cast<std::size_t>(rows) * 2 * nodes);
    for (double& value : d) value = random(generator);
    RowMatrix block;
    field.compliance(f, d.data(), rows, block);
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
  }
}

// The force is raised by h: the converged step moves by K_b^-1 h.
TEST(TriadField, ComplianceIsTheDifferenceOfConvergedSteps) {
  const Scene scene;
  BeamTimeParameters time = scene.time;
  time.tolerance = 1e-13;
  BeamField field(scene.mesh, scene.groups, time, {0, -0.1, 0});
  set_moving(field, scene.size());
  std::vector<double> direction(scene.size());
  std::mt19937 generator(9);
  std::uniform_real_distribution<double> random(-1.0, 1.0);
  for (double& value : direction) value = random(generator);
  const double h = 1e-4;
  const auto solved = [&](double step) {
    std::vector<double> force(scene.size());
    for (std::size_t i = 0; i < force.size(); ++i) force[i] = step * direction[i];
    field.begin_step(0.2, 0.05);
    EXPECT_GE(field.solve_step(force), 0);
    return field.dofs();
  };
  const std::vector<double> plus = solved(h), minus = solved(-h);
  solved(0.0);
  field.linearize();
  double error = 0.0, largest = 0.0;
  for (Index f = 0; f < scene.mesh.fibers(); ++f) field.solve(f, &direction[6 * scene.mesh.first_node[f]]);
  for (std::size_t i = 0; i < direction.size(); ++i) {
    error = std::max(error, std::abs((plus[i] - minus[i]) / (2 * h) - direction[i]));
    largest = std::max(largest, std::abs(direction[i]));
  }
  std::printf("solve against differences of converged steps: %.1e\n", error / largest);
  EXPECT_LE(error, 1e-6 * largest);
}

TEST(TriadField, LinearizeAndIncrementReachTheStepOfTheBuiltInNewtonQuadratically) {
  const Scene scene;
  BeamTimeParameters time = scene.time;
  time.tolerance = 1e-12;
  BeamField field(scene.mesh, scene.groups, time, {0, -2, 0});
  set_moving(field, scene.size());
  field.begin_step(0.2, 0.05);
  ASSERT_GE(field.solve_step({}), 0);
  const std::vector<double> expected = field.dofs();
  field.begin_step(0.2, 0.05);
  std::vector<double> norms;
  for (int iteration = 0; iteration < 7; ++iteration) {
    field.linearize();
    std::vector<double> delta = field.residual();
    double sum = field.squared_moment_residual();
    for (double& value : delta) {
      sum += value * value;
      value = -value;
    }
    norms.push_back(std::sqrt(sum));
    for (Index f = 0; f < scene.mesh.fibers(); ++f) field.solve(f, &delta[6 * scene.mesh.first_node[f]]);
    field.increment(delta);
  }
  std::printf("residuals of Newton:");
  for (const double value : norms) std::printf(" %.1e", value);
  std::printf("\n");
  for (std::size_t i = 0; i < expected.size(); ++i) EXPECT_NEAR(field.dofs()[i], expected[i], 1e-9);
  EXPECT_LE(norms[4], 1e-10 * norms[0]);
}

TEST(TriadField, BeginStepRestartsTheStepAndStateRestoresItBitwise) {
  const Scene scene;
  BeamField field(scene.mesh, scene.groups, scene.time, {0, -2, 0}),
      other(scene.mesh, scene.groups, scene.time, {0, -2, 0});
  set_moving(field, scene.size());
  field.begin_step(0.2, 0.05);
  ASSERT_GE(field.solve_step({}), 0);
  const std::vector<double> once = field.dofs();
  field.begin_step(0.2, 0.05);
  ASSERT_GE(field.solve_step({}), 0);
  EXPECT_EQ(once, field.dofs());
  field.accept_step();
  const auto from = field.state(), to = other.state();
  ASSERT_EQ(from.size(), to.size());
  for (std::size_t i = 0; i < from.size(); ++i) {
    EXPECT_EQ(from[i].second->size(), scene.size()) << from[i].first;
    *to[i].second = *from[i].second;
  }
  for (int step = 5; step <= 8; ++step)
    for (BeamField* each : {&field, &other}) {
      each->begin_step(0.05 * step, 0.05);
      ASSERT_GE(each->solve_step({}), 0);
      each->accept_step();
    }
  for (std::size_t i = 0; i < from.size(); ++i) EXPECT_EQ(*to[i].second, *from[i].second) << from[i].first;
  EXPECT_EQ(field.energy().external_work, other.energy().external_work);
  EXPECT_EQ(field.energy().internal, other.energy().internal);
}

TEST(TriadField, ClampedEndHoldsTheTriadAndLetsTheTangentShear) {
  mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, 4);
  FiberParameters group = test::shear_beam(1e3, 400, 1.0, 1.0, 1.0, 1.0, 2.0);
  group.start = EndCondition::clamped;
  group.loads = {test::load(LoadType::force, {0, 4, 0})};
  const test::StaticSolution s = test::solve_static(mesh, group, 1);
  ASSERT_TRUE(s.converged);
  EXPECT_EQ(Vec3(&s.dofs[0]).norm(), 0.0);
  EXPECT_NEAR(s.dofs[4], 4 / 400.0, 1e-4);  // shear angle Q/(k G A)
}

TEST(TriadField, NotANumberIsAStatusNotAnException) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, 2);
  FiberParameters group = test::shear_beam(10, 4, 0.9, 1.0, 0.1, 0.1, 0.2);
  group.start = EndCondition::clamped;
  BeamField field(mesh, {group}, {}, Vec3::Zero());
  field.initialize({});
  field.begin_step(0.1, 0.1);
  std::vector<double> force(6 * static_cast<std::size_t>(mesh.nodes()), 0.0);
  force[7] = nan;
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

TEST(TriadField, ImpulseOfAFreeFiberIsItsMomentum) {
  const mesh::FiberMesh mesh = test::arc(0.8, 1.5, 4);
  FiberParameters group = test::shear_beam(200, 80, 0.9, 1.0, 0.004, 0.003, 0.004, 1.3);
  group.loads = {test::load(LoadType::force, {0.1, -0.2, 0.3}), test::load(LoadType::moment, {0.01, -0.02, 0.03})};
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
    const Vec3 impulse = 0.4 * (Vec3(0.1, -0.2, 0.3) + 1.3 * 1.2 * Vec3(0, 0, -1));
    EXPECT_LE((field.linear_momentum(field.accepted_velocity()) - impulse).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace fbi::beam
