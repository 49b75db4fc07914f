/// Fibers with shear, torsion and rotary inertia in motion: S-D1 frequencies, S-D6 momenta and elbow, orders in time.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/log.hpp"
#include "beam/newton.hpp"
#include "record.hpp"
#include "unit/beam/curved_fiber.hpp"

namespace fbi::beam {
namespace {

// ---------------------------------------------------------------------------------------------------------------- S-D1

// Lowest bending frequencies of a clamped straight fiber, from the eigenvalues 1/omega^2 of K^-1 M, rotations included.
std::array<double, 3> cantilever_frequencies(double slenderness, Index elements) {
  const double radius = 1 / slenderness, area = M_PI * radius * radius, inertia = 0.25 * area * radius * radius;
  FiberParameters group = test::round_shear_beam(1 / inertia, 0.3, 0.9, radius, 1 / area);  // EI = rho A = L = 1
  group.start = EndCondition::clamped;
  BeamTimeParameters time;
  time.scheme = TimeScheme::static_;
  FiberEquations equations(test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, elements), {group}, time, Vec3::Zero());
  equations.evaluate(0, true);
  EXPECT_TRUE(equations.factorize(0));
  const Index size = 6 * (elements + 1);
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(2 * size, 2 * size);
  ElementProperties element = equations.fibers[0].section;
  ElementMatrix mass;
  for (Index e = 0; e < elements; ++e) {
    element.length = 1.0 / elements;
    element_formulation(group.formulation)->mass(element, mass.data());
    matrix.block<12, 12>(6 * e, 6 * e) += mass;
    for (Index c = 0; c < 3; ++c)
      matrix.diagonal().segment<3>(size + 6 * e + 3 * c) +=
          triad_share[static_cast<std::size_t>(c)] * element.length * equations.triads->section[0].rotary;
  }
  for (const Index held : {Index(0), size}) {
    matrix.middleRows(held, 3).setZero();
    matrix.middleCols(held, 3).setZero();
  }
  for (Eigen::Index column = 0; column < 2 * size; ++column)
    equations.triads->solve_all(equations, 0, matrix.col(column).data());
  const Eigen::VectorXcd values = matrix.eigenvalues();
  std::vector<double> sorted;
  for (Eigen::Index i = 0; i < values.size(); ++i)
    if (values[i].real() > 1e-12) sorted.push_back(1 / std::sqrt(values[i].real()));
  std::sort(sorted.begin(), sorted.end());
  // each bending mode appears in both planes, torsion and stretch only once
  std::vector<double> pairs;
  for (std::size_t i = 0; i + 1 < sorted.size() && pairs.size() < 3; ++i)
    if (sorted[i + 1] / sorted[i] - 1 < 1e-7) pairs.push_back(sorted[i++]);
  return {pairs[0], pairs[1], pairs[2]};
}

TEST(Frequencies, TimoshenkoCantilever) {
  const double table[2][4] = {{20, 3.496355, 21.217443, 56.693473}, {50, 3.512838, 21.896988, 60.793357}};
  for (const auto& row : table) {
    std::vector<std::array<double, 3>> omega;
    for (const Index elements : {4, 8, 16}) omega.push_back(cantilever_frequencies(row[0], elements));
    for (int mode = 0; mode < 3; ++mode) {
      double error[3];
      for (int i = 0; i < 3; ++i) error[i] = omega[i][mode] / row[1 + mode] - 1;
      const double order = std::log2(std::abs((omega[0][mode] - omega[1][mode]) / (omega[1][mode] - omega[2][mode])));
      std::printf("L/R %g, mode %d: omega %.7f, errors %.2e %.2e %.2e, order %.2f\n", row[0], mode + 1, omega[2][mode],
                  error[0], error[1], error[2], order);
      EXPECT_LE(std::abs(error[2]), mode == 0 ? 2e-6 : mode == 1 ? 6e-6 : 5e-5);
      EXPECT_GE(order, 3.6);
      test::record(
          {.section = "Fibers: dynamics",
           .id = "S-D1",
           .check = log::format("Timoshenko cantilever with rotary inertia, L/R = %g, nu = 0.3, k = 0.9: omega_%d,"
                                " 16 elements",
                                row[0], mode + 1),
           .source = "characteristic equation",
           .reference = row[1 + mode],
           .ours = omega[2][mode],
           .order = order,
           .bar = "order 3.6"});
    }
  }
}

// ------------------------------------------------------------------------------------------------- free flight, S-D6

struct Flight {
  std::vector<double> dofs, rotation;
  Vec3 linear, angular;
  double energy = 0.0;
};

// A curved free fiber with an anisotropic section that spins about no principal axis and is pushed and twisted until
// t = 0.2.
Flight fly(double dt, int steps, double rho_inf) {
  const mesh::FiberMesh mesh = test::arc(1.0, 1.2, 3);
  const std::size_t nodes = static_cast<std::size_t>(mesh.nodes());
  FiberParameters group = test::shear_beam(40, 16, 0.9, 1.0, 0.02, 0.05, 0.03, 1.0);
  const auto pulse = [](double size) {
    return input::Expression(log::format("%.17g*(t/0.05)^2*max(0,1-t/0.2)^3", size));
  };
  Load push, twist;
  push.type = LoadType::force;
  push.value = {pulse(3), pulse(-2), pulse(4)};
  twist.type = LoadType::moment;
  twist.value = {pulse(1), pulse(2), pulse(-1)};
  group.loads = {push, twist};
  BeamTimeParameters time;
  time.rho_inf = rho_inf;
  time.tolerance = 1e-13;
  BeamField field(mesh, {group}, time, Vec3::Zero());
  // rigid rotation at the beginning: with the identity as first triads of the reference, spins come from the rotation
  const Vec3 omega(1.5, -1, 2);
  const auto state = field.state();
  const auto array = [&](const char* name) -> std::vector<double>& {
    for (const auto& [key, values] : state)
      if (key == name) return *values;
    throw std::logic_error(name);
  };
  for (std::size_t n = 0; n < 2 * nodes; ++n) {
    const Vec3 v = omega.cross(Vec3(&array("dofs")[3 * n]));
    const Vec3 spin = exponential(Vec3(&array("rotation")[3 * n])).conjugate() * omega;
    for (std::size_t k = 0; k < 3; ++k) {
      array("velocity")[3 * n + k] = v[static_cast<Eigen::Index>(k)];
      if (n + 1 < 2 * nodes) array("spin")[3 * n + k] = spin[static_cast<Eigen::Index>(k)];
    }
  }
  field.initialize({});
  for (int step = 1; step <= steps; ++step) {
    field.begin_step(step * dt, dt);
    EXPECT_GE(field.solve_step({}), 0);
    field.accept_step();
  }
  Flight flight{field.accepted_dofs(), array("rotation"), field.linear_momentum(field.accepted_velocity()),
                Vec3::Zero(), 0.0};
  flight.energy = field.energy().internal + field.energy().kinetic;
  // angular momentum: consistent mass for the center line, rotary inertia at the triads
  const TriadSection section(group.section, group.material);
  ElementMatrix mass;
  ElementProperties element;
  element.mass_per_length = group.material.density * group.section.area;
  for (std::size_t e = 0; e + 1 < nodes; ++e) {
    element.length = mesh.element_length[e];
    element_formulation(group.formulation)->mass(element, mass.data());
    for (std::size_t i = 0; i < 4; ++i)
      for (std::size_t j = 0; j < 4; ++j)
        flight.angular += mass(static_cast<Eigen::Index>(3 * i), static_cast<Eigen::Index>(3 * j)) *
                          Vec3(&flight.dofs[6 * e + 3 * i]).cross(Vec3(&field.accepted_velocity()[6 * e + 3 * j]));
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t t = 2 * e + c;
      flight.angular +=
          triad_share[c] * element.length *
          (exponential(Vec3(&flight.rotation[3 * t])) * Vec3(section.rotary.cwiseProduct(Vec3(&array("spin")[3 * t]))));
    }
  }
  return flight;
}

double difference(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}
double turn_between(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0;
  for (std::size_t i = 0; i + 3 < a.size(); i += 3)
    largest = std::max(largest, logarithm(exponential(Vec3(&a[i])).conjugate() * exponential(Vec3(&b[i]))).norm());
  return largest;
}

TEST(FreeFlight, SecondOrderInTimeForPositionsAndRotations) {
  for (const double rho_inf : {1.0, 0.8, 0.5}) {
    std::vector<Flight> flights;
    for (const int steps : {200, 400, 800, 1600}) flights.push_back(fly(0.4 / steps, steps, rho_inf));
    double change[3], turn[3];
    for (std::size_t i = 0; i < 3; ++i) {
      change[i] = difference(flights[i].dofs, flights[i + 1].dofs);
      turn[i] = turn_between(flights[i].rotation, flights[i + 1].rotation);
    }
    const double order = std::log2(change[1] / change[2]), order_of_turns = std::log2(turn[1] / turn[2]);
    std::printf("rho_inf %.1f: positions %.2e %.2e %.2e, rotations %.2e %.2e %.2e, orders %.2f %.2f\n", rho_inf,
                change[0], change[1], change[2], turn[0], turn[1], turn[2], order, order_of_turns);
    EXPECT_GE(order, 1.85);
    EXPECT_GE(order_of_turns, 1.85);
    test::record({.section = "Fibers: dynamics",
                  .id = "",
                  .check = log::format("simo_reissner in free flight, rho_inf = %.1f: order in time of rotations (of "
                                       "positions %.2f)",
                                       rho_inf, order),
                  .source = "Bruels and Cardona 2010",
                  .reference = 2.0,
                  .ours = order_of_turns,
                  .error = std::abs(order_of_turns - 2) / 2,
                  .order = order_of_turns,
                  .bar = "1.85"});
  }
}

TEST(FreeFlight, MomentaAreKept) {
  // both spans lie behind the end of the loads
  std::vector<double> drift, linear;
  for (const int steps : {200, 400, 800}) {
    const Flight early = fly(0.4 / steps, 5 * steps / 8, 1.0), late = fly(0.4 / steps, 2 * steps, 1.0);
    drift.push_back((late.angular - early.angular).norm() / early.angular.norm());
    linear.push_back((late.linear - early.linear).norm() / early.linear.norm());
  }
  const double order = std::log2(drift[1] / drift[2]);
  std::printf("angular momentum drifts by %.2e %.2e %.2e, order %.2f; linear momentum by %.1e\n", drift[0], drift[1],
              drift[2], order, linear[2]);
  EXPECT_LE(linear[0], 1e-10);
  EXPECT_LE(linear[2], 1e-10);
  EXPECT_GE(order, 1.7);
  EXPECT_LE(drift[2], 1e-3);
  test::record({.section = "Fibers: dynamics",
                .id = "S-D6",
                .check = "simo_reissner in free flight, rho_inf = 1: change of the linear momentum",
                .source = "identity",
                .reference = 0.0,
                .ours = linear[2],
                .bar = "1e-10"});
  test::record({.section = "Fibers: dynamics",
                .id = "S-D6",
                .check = "simo_reissner in free flight, rho_inf = 1, dt = 5e-4: drift of the angular momentum",
                .source = "identity to O(dt^2)",
                .reference = 0.0,
                .ours = drift[2],
                .order = order,
                .bar = "order 1.7"});
}

// --------------------------------------------------------------------------------------------------------- S-D6, elbow

// Two legs of length 10 that meet at a right angle, the corner rounded with a small radius; force at the corner out of
// their plane, 0 -> 50 (t = 1) -> 0 (t = 2). Rotary inertia is a number of its own here, not rho I.
TEST(Elbow, PeaksOfTheCantileverOfSimoAndVuQuoc) {
  const double radius = 0.05, leg = 10 - radius, bend = 0.5 * M_PI * radius, dt = 0.01;
  const Index on_leg = 12, on_bend = 2, elements = 2 * on_leg + on_bend;
  mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, elements);
  double s = 0.0;
  for (Index node = 0; node <= elements; ++node) {
    Vec3 x, g;
    if (s <= leg + 1e-12) {
      x = {s, 0, 0};
      g = {1, 0, 0};
    } else if (s < leg + bend - 1e-12) {
      const double a = (s - leg) / radius;
      x = {leg + radius * std::sin(a), radius * (1 - std::cos(a)), 0};
      g = {std::cos(a), std::sin(a), 0};
    } else {
      x = {10, radius + s - leg - bend, 0};
      g = {0, 1, 0};
    }
    for (int k = 0; k < 3; ++k) {
      mesh.position[3 * static_cast<std::size_t>(node) + k] = x[k];
      mesh.tangent[3 * static_cast<std::size_t>(node) + k] = g[k];
    }
    if (node == elements) break;
    const bool on_corner = node >= on_leg && node < on_leg + on_bend;
    mesh.element_length[static_cast<std::size_t>(node)] = on_corner ? bend / on_bend : leg / on_leg;
    s += mesh.element_length[static_cast<std::size_t>(node)];
  }
  FiberParameters group = test::shear_beam(1e6, 1e6, 1.0, 1.0, 1e-3, 1e-3, 1e-3, 1.0);
  group.start = EndCondition::clamped;
  BeamTimeParameters time;
  time.rho_inf = 0.9;
  time.tolerance = 1e-9;
  FiberEquations equations(mesh, {group}, time, Vec3::Zero());
  equations.triads->section[0].rotary = {20, 10, 10};
  const std::size_t corner = 6 * static_cast<std::size_t>(on_leg + on_bend / 2), tip = equations.dofs.size() - 6;
  const auto load = [](double t) { return t < 1 ? 50 * t : t < 2 ? 50 * (2 - t) : 0.0; };
  std::vector<double> force(equations.dofs.size(), 0.0);
  double largest = 0, largest_time = 0, smallest = 0, smallest_time = 0, elbow = 0, elbow_time = 0;
  for (int step = 1; step <= 1700; ++step) {
    const double t = step * dt;
    equations.dofs = equations.dofs_n;
    equations.velocity = equations.velocity_n;
    equations.acceleration = equations.acceleration_n;
    equations.triads->begin_step();
    equations.level.dynamic = true;
    equations.level.dt = dt;
    equations.level.internal = 1 - equations.scheme.alpha_f;
    equations.level.previous = equations.scheme.alpha_f;
    equations.level.inertia = equations.scheme.inertia_per_displacement(dt);
    force[corner + 2] = (1 - equations.scheme.alpha_f) * load(t) + equations.scheme.alpha_f * load(t - dt);
    predict(equations, 0);
    ASSERT_GE(solve_fiber(equations, 0, force), 0) << t;
    equations.evaluate(0, false);
    equations.dofs_n = equations.dofs;
    equations.velocity_n = equations.velocity;
    equations.acceleration_n = equations.acceleration;
    equations.internal_n = equations.internal;
    equations.external_n = equations.external;
    equations.triads->accept_step();
    const double z = equations.dofs[tip + 2], corner_z = equations.dofs[corner + 2];
    if (t > 5 && t < 10 && z > largest) {
      largest = z;
      largest_time = t;
    }
    if (z < smallest) {
      smallest = z;
      smallest_time = t;
    }
    if (corner_z < elbow) {
      elbow = corner_z;
      elbow_time = t;
    }
  }
  std::printf("elbow cantilever: tip %.3f at %.2f and %.3f at %.2f, elbow %.3f at %.2f\n", largest, largest_time,
              smallest, smallest_time, elbow, elbow_time);
  EXPECT_NEAR(largest, 8.25, 0.02 * 8.25);
  EXPECT_NEAR(smallest, -9.73, 0.02 * 9.73);
  EXPECT_NEAR(elbow, -4.06, 0.02 * 4.06);
  const double table[3][2] = {{8.25, largest}, {-9.73, smallest}, {-4.06, elbow}};
  const char* const names[3] = {"tip, largest", "tip, smallest", "elbow, smallest"};
  for (int i = 0; i < 3; ++i)
    test::record({.section = "Fibers: dynamics",
                  .id = "S-D6",
                  .check = log::format("elbow cantilever, corner of radius 0.05, 26 elements, dt = 0.01: out-of-plane "
                                       "displacement of the %s",
                                       names[i]),
                  .source = "Simo and Vu-Quoc 1988; test file of EXUDYN",
                  .reference = table[i][0],
                  .ours = table[i][1],
                  .bar = "2 %"});
}

}  // namespace
}  // namespace fbi::beam
