/// Fibers in motion: conserving scheme, momenta (S-D6), moved supports (S-D5), damping, large vibrations (S-D4).
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "convergence/momenta.hpp"
#include "record.hpp"

namespace fbi::beam {
namespace {

using test::formulas;
using test::order;

BeamTimeParameters scheme_of(double rho_inf) {  // below 0: midpoint
  BeamTimeParameters time;
  if (rho_inf < 0)
    time.scheme = TimeScheme::midpoint;
  else
    time.rho_inf = rho_inf;
  return time;
}
std::string name_of(double rho_inf) {
  return rho_inf < 0 ? "midpoint" : "generalised-alpha, rho_inf " + std::to_string(rho_inf).substr(0, 3);
}

bool step(BeamField& field, int number, double dt) {
  field.begin_step(number * dt, dt);
  if (field.solve_step({}) < 0) return false;
  field.accept_step();
  return true;
}

// ---------------------------------------------------------------------------------------------------------------- S-D3

FiberParameters pendulum_fiber() {
  FiberParameters group;
  group.section.radius = 0.01;
  group.material.young = 1e7;
  group.material.density = 1000;
  group.start = EndCondition::pinned;
  return group;
}

struct Pendulum {
  double end_time = 0.0, energy = 0.0, kinetic = 0.0;
  std::vector<Vec3> tip;  // at t = 0.2, 0.4, ..., 1
};

Pendulum run_pendulum(double rho_inf, int steps_per_unit, double end_time) {
  const mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, 8);
  BeamField field(mesh, {pendulum_fiber()}, scheme_of(rho_inf), {0, -9.81, 0});
  field.initialize({});
  Pendulum result;
  for (int n = 1; n <= std::lround(end_time * steps_per_unit); ++n) {
    if (!step(field, n, 1.0 / steps_per_unit)) break;
    result.end_time = n / double(steps_per_unit);
    const Energy energy = field.energy();
    result.energy = std::max(result.energy, std::abs(energy.internal + energy.kinetic - energy.external_work));
    result.kinetic = std::max(result.kinetic, energy.kinetic);
    if (5 * n % steps_per_unit == 0 && n <= steps_per_unit)
      result.tip.push_back(Vec3(&field.dofs()[field.dofs().size() - 6]));
  }
  return result;
}

TEST(Midpoint, PendulumKeepsItsEnergyForLongTimes) {
  for (const int steps : {20, 25, 50, 100, 200, 1000})
    for (const double rho_inf : {-1.0, 1.0, 0.8}) {
      const double end = steps <= 200 ? 20.0 : 10.0;
      const Pendulum p = run_pendulum(rho_inf, steps, end);
      std::printf("pendulum, %s, dt %g: %s t = %.2f, max |E| %.2e (largest kinetic energy %.2f)\n",
                  name_of(rho_inf).c_str(), 1.0 / steps, p.end_time == end ? "completed" : "stopped at", p.end_time,
                  p.energy, p.kinetic);
      test::record({.section = "Fibers: dynamics",
                    .id = "S-D3",
                    .check = "flexible pendulum to t = " + std::to_string(int(end)) + ", " + name_of(rho_inf) +
                             ", dt 1/" + std::to_string(steps) + ": largest energy error (kinetic energy up to 1.5)",
                    .source = "identity",
                    .reference = 0.0,
                    .ours = p.energy,
                    .ours_text = p.end_time == end ? "" : "stopped at t = " + std::to_string(p.end_time).substr(0, 5),
                    .bar = rho_inf < 0 && steps >= 50 ? "1e-6" : "reported"});
      if (rho_inf < 0 && steps >= 50) {
        EXPECT_EQ(p.end_time, end);
        EXPECT_LE(p.energy, 1e-6);
      }
    }
}

TEST(Midpoint, SecondOrderInTime) {
  const Pendulum reference = run_pendulum(1.0, 8000, 1.0);
  std::vector<double> error;
  for (const int steps : {250, 500, 1000}) {
    const Pendulum p = run_pendulum(-1.0, steps, 1.0);
    double sum = 0.0;
    for (std::size_t k = 0; k < 5; ++k) sum += (p.tip[k] - reference.tip[k]).squaredNorm();
    error.push_back(std::sqrt(sum));
  }
  const double slope = 0.5 * std::log2(error[0] / error[2]);
  std::printf("pendulum, midpoint, dt 4e-3, 2e-3, 1e-3: errors %.2e %.2e %.2e, order %.2f\n", error[0], error[1],
              error[2], slope);
  EXPECT_NEAR(slope, 2.0, 0.2);
  test::record({.section = "Fibers: dynamics",
                .id = "S-D3",
                .check = "flexible pendulum, midpoint, tips at t <= 1 against dt 1.25e-4, dt 1e-3",
                .source = "self-convergence",
                .reference = 0.0,
                .ours = error[2],
                .order = slope,
                .bar = "order 2 +- 0.2"});
}

// ---------------------------------------------------------------------------------------------------------------- S-D6

// A free flexible rod that spins and is bent by a push, then flies free.
TEST(Momenta, OfAFreeFlexibleFiber) {
  const mesh::FiberMesh mesh = test::straight_fiber({-0.5, 0, 0}, {1, 0, 0}, 1.0, 8);
  for (const double rho_inf : {-1.0, 1.0, 0.6}) {
    std::vector<double> drift;
    double impulse_error = 0.0;
    for (const int steps : {500, 1000, 2000}) {
      FiberParameters group = test::stiffness(2000.0, 0.05, 0.5);
      group.velocity = formulas("0.3", "4*x", "-2*x+0.1");
      Load push;
      push.value = formulas("0", "t<0.1 ? 0.5 : 0", "t<0.1 ? 0.3*t : 0");
      group.loads = {push};
      BeamField field(mesh, {group}, scheme_of(rho_inf), Vec3::Zero());
      field.initialize({});
      const Vec3 p0 = field.linear_momentum(field.velocity());
      Vec3 impulse = Vec3::Zero(), after = Vec3::Zero();
      double largest = 0.0;
      const double dt = 1.0 / steps, alpha = rho_inf < 0 ? 0.5 : rho_inf / (rho_inf + 1);
      const auto push_at = [&](double t) { return t < 0.1 ? Vec3(0, 0.5, 0.3 * t) : Vec3(0, 0, 0); };
      for (int n = 1; n <= steps; ++n) {
        ASSERT_TRUE(step(field, n, dt));
        impulse += dt * ((1 - alpha) * push_at(n * dt) + alpha * push_at((n - 1) * dt));
        if (rho_inf < 0 || rho_inf == 1.0)  // the sum the scheme makes is the trapezoidal rule
          impulse_error =
              std::max(impulse_error, (field.linear_momentum(field.velocity()) - p0 - impulse).norm() / p0.norm());
        if (10 * n == 2 * steps) after = test::angular_momentum(mesh, 0.5, field.dofs(), field.velocity());
        if (10 * n > 2 * steps)
          largest =
              std::max(largest, (test::angular_momentum(mesh, 0.5, field.dofs(), field.velocity()) - after).norm() /
                                    after.norm());
      }
      drift.push_back(largest);
    }
    const double slope = order(drift[1], drift[2]);
    std::printf("free fiber, %s: impulse %.1e, angular momentum drift %.2e %.2e %.2e, order %.2f\n",
                name_of(rho_inf).c_str(), impulse_error, drift[0], drift[1], drift[2], slope);
    if (rho_inf < 0 || rho_inf == 1.0) {
      EXPECT_LE(impulse_error, 1e-10);
    }
    if (rho_inf < 0) {
      EXPECT_LE(drift[0], 1e-9);
    } else {
      EXPECT_NEAR(slope, 2.0, 0.3);
    }
    test::record({.section = "Fibers: dynamics",
                  .id = "S-D6",
                  .check = "free flexible fiber after a push, drift of the angular momentum in 0.8, dt 5e-4, " +
                           name_of(rho_inf),
                  .source = "identity",
                  .reference = 0.0,
                  .ours = drift[2],
                  .order = rho_inf < 0 ? test::not_given : slope,
                  .bar = rho_inf < 0 ? "1e-9" : "order 2 +- 0.3"});
    if (rho_inf == 1.0 || rho_inf < 0)
      test::record({.section = "Fibers: dynamics",
                    .id = "S-D6",
                    .check = "free flexible fiber, linear momentum minus impulse, " + name_of(rho_inf),
                    .source = "identity",
                    .reference = 0.0,
                    .ours = impulse_error,
                    .bar = "1e-10"});
  }
}

// ------------------------------------------------------------------------------------------------------- moved
// supports

// A flexible fiber whose clamp moves and turns; every scheme keeps order 2.
TEST(MovedSupports, SecondOrderInTime) {
  const mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, 3);
  const auto run = [&](double rho_inf, int steps) {
    FiberParameters group = test::stiffness(10.0, 0.02, 1.0);
    Support clamp;
    clamp.type = EndCondition::clamped;
    clamp.motion = formulas("0.1*sin(3*t)^4", "0.2*sin(2*t)^4", "0.1*(1-cos(4*t))^2");
    clamp.direction = formulas("cos(0.5*sin(3*t)^4)", "sin(0.5*sin(3*t)^4)", "0");
    group.supports = {clamp};
    BeamField field(mesh, {group}, scheme_of(rho_inf), Vec3::Zero());
    field.initialize({});
    for (int n = 1; n <= steps; ++n) EXPECT_TRUE(step(field, n, 1.0 / steps));
    return field.dofs();
  };
  for (const double rho_inf : {-1.0, 1.0, 0.5, 0.0}) {
    const std::vector<double> exact = run(rho_inf, 12800);
    std::vector<double> error;
    for (const int steps : {400, 800, 1600}) {
      const std::vector<double> d = run(rho_inf, steps);
      double sum = 0.0;
      for (std::size_t i = 0; i < d.size(); ++i) sum += std::pow(d[i] - exact[i], 2);
      error.push_back(std::sqrt(sum));
    }
    const double slope = order(error[1], error[2]);
    std::printf("clamp that moves and turns, %s: errors %.2e %.2e %.2e, orders %.2f %.2f\n", name_of(rho_inf).c_str(),
                error[0], error[1], error[2], order(error[0], error[1]), slope);
    EXPECT_NEAR(slope, 2.0, 0.2);
    test::record({.section = "Fibers: dynamics",
                  .id = "",
                  .check = "clamp that moves and turns by formulas, nodes at t = 1 against dt 1/12800, dt 1/1600, " +
                           name_of(rho_inf),
                  .source = "self-convergence",
                  .reference = 0.0,
                  .ours = error[2],
                  .order = slope,
                  .bar = "order 2 +- 0.2"});
  }
}

// Spin-up of Simo and Vu-Quoc: the clamp turns, the steady extension is that of tan(b L)/b - L.
TEST(SpinningRod, SteadyExtension) {
  const mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 10.0, 10);
  FiberParameters group = test::stiffness(2.8e7, 1.4e4, 1.2);
  const std::string turn = "(t<15 ? 0.4*(t*t/2+(15/(2*pi))^2*(cos(2*pi*t/15)-1)) : 6*t-45)";
  Support clamp;
  clamp.type = EndCondition::clamped;
  clamp.direction = formulas("cos" + turn, "sin" + turn, "0");
  group.supports = {clamp};
  const auto angle = [](double t) {
    return t < 15 ? 0.4 * (t * t / 2 + std::pow(15 / (2 * M_PI), 2) * (std::cos(2 * M_PI * t / 15) - 1)) : 6 * t - 45;
  };
  BeamTimeParameters time;
  time.rho_inf = 0.5;
  BeamField field(mesh, {group}, time, Vec3::Zero());
  field.initialize({});
  double sum = 0.0, lowest = 0.0, lowest_at = 0.0;
  int count = 0;
  const double dt = 5e-3;
  for (int n = 1; n <= 4000; ++n) {
    ASSERT_TRUE(step(field, n, dt));
    const double t = n * dt;
    const Vec3 tip(&field.dofs()[60]), across(-std::sin(angle(t)), std::cos(angle(t)), 0);
    if (tip.dot(across) < lowest) {
      lowest = tip.dot(across);
      lowest_at = t;
    }
    if (t > 18) {
      double length = 0.0;  // extension along the fiber: chords of slightly bent elements
      length = tip.norm();
      sum += length - 10.0;
      ++count;
    }
  }
  const double b = 6 * std::sqrt(1.2 / 2.8e7), exact = std::tan(10 * b) / b - 10, mean = sum / count;
  std::printf("spin-up: mean extension at t in [18, 20] %.7e, exact %.7e; lowest tip deflection %.4f at t = %.2f\n",
              mean, exact, lowest, lowest_at);
  EXPECT_NEAR(exact, 5.1431745504e-4, 1e-12);
  EXPECT_NEAR(mean / exact, 1.0, 2e-3);
  test::record({.section = "Fibers: dynamics",
                .id = "S-D5",
                .check = "spin-up of a rod by its clamp, mean extension at t in [18, 20], 10 elements, dt 5e-3",
                .source = "exact solution; Simo, Vu-Quoc 1986",
                .reference = exact,
                .ours = mean,
                .bar = "2e-3"});
}

// ---------------------------------------------------------------------------------------------------------------
// damping

// First mode of a cantilever: the tip against exp(-d t) sin(w t), d = (a_M + a_K w0^2)/2.
TEST(Damping, DecayOfTheFirstMode) {
  const double beta = 1.87510406871196, omega0 = beta * beta;
  const double sigma = (std::cosh(beta) + std::cos(beta)) / (std::sinh(beta) + std::sin(beta));
  const std::string b = "1.87510406871196*x", s = std::to_string(sigma);
  const std::string mode = "1e-4*(cosh(" + b + ")-cos(" + b + ")-" + s + "*(sinh(" + b + ")-sin(" + b + ")))";
  const mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, 8);
  struct Case {
    double mass, stiffness, rho_inf;
  };
  for (const Case& c : {Case{0.5, 0.0, 1.0}, Case{0.0, 0.04, 1.0}, Case{0.2, 0.02, 0.5}, Case{0.2, 0.02, -1.0}}) {
    const double decay = 0.5 * (c.mass + c.stiffness * omega0 * omega0);
    const double omega = std::sqrt(omega0 * omega0 - decay * decay);
    std::vector<double> error;
    for (const int steps : {100, 200, 400}) {
      FiberParameters group = test::stiffness(1e4, 1.0);
      group.start = EndCondition::clamped;
      group.velocity = formulas("0", mode, "0");
      group.damping = {c.mass, c.stiffness};
      BeamField field(mesh, {group}, scheme_of(c.rho_inf), Vec3::Zero());
      field.initialize({});
      const double amplitude = field.velocity()[6 * 8 + 1] / omega;
      double largest = 0.0;
      for (int n = 1; n <= 2 * steps; ++n) {
        ASSERT_TRUE(step(field, n, 1.0 / steps));
        const double t = n / double(steps);
        largest = std::max(largest,
                           std::abs(field.dofs()[6 * 8 + 1] / amplitude - std::exp(-decay * t) * std::sin(omega * t)));
      }
      error.push_back(largest);
    }
    std::printf("damping a_M %.1f, a_K %.2f, %s: largest error of the tip %.2e %.2e %.2e, orders %.2f %.2f\n", c.mass,
                c.stiffness, name_of(c.rho_inf).c_str(), error[0], error[1], error[2], order(error[0], error[1]),
                order(error[1], error[2]));
    EXPECT_NEAR(order(error[0], error[1]), 2.0, 0.2);
    EXPECT_LE(error[2], 2e-3);
    test::record({.section = "Fibers: dynamics",
                  .id = "",
                  .check = "decay of the first mode of a cantilever in a period, a_M " +
                           std::to_string(c.mass).substr(0, 3) + ", a_K " + std::to_string(c.stiffness).substr(0, 4) +
                           ", " + name_of(c.rho_inf) + ", dt 1/400",
                  .source = "exact solution",
                  .reference = 0.0,
                  .ours = error[2],
                  .order = order(error[0], error[1]),
                  .bar = "2e-3, order 2 +- 0.2"});
  }
}

// ---------------------------------------------------------------------------------------------------------------- S-D4

TEST(Vibration, TurekHronFlapReleasedUnderGravity) {
  FiberParameters group;
  group.section.area = 0.02;
  group.section.inertia = std::pow(0.02, 3) / 12;
  group.material.young = 1.4e6 / (1 - 0.4 * 0.4);
  group.material.density = 1000;
  group.start = EndCondition::clamped;
  struct Result {
    double mean_x, size_x, mean_y, size_y, frequency;
  };
  const auto run = [&](double dt) {
    BeamField field(test::straight_fiber({0, 0, 0}, {1, 0, 0}, 0.35, 16), {group}, scheme_of(-1.0), {0, -2, 0});
    field.initialize({});
    double low[2] = {1, 1}, high[2] = {-1, -1}, last = 0.0;
    std::vector<double> crossing;
    for (int n = 1; n <= std::lround(10.0 / dt); ++n) {
      EXPECT_TRUE(step(field, n, dt));
      const double u[2] = {field.dofs()[6 * 16] - 0.35, field.dofs()[6 * 16 + 1]};
      for (int k = 0; k < 2; ++k) {
        low[k] = std::min(low[k], u[k]);
        high[k] = std::max(high[k], u[k]);
      }
      const double level = u[1] + 0.0633;
      if (n > 1 && last < 0 && level >= 0) crossing.push_back(dt * (n - 1 + last / (last - level)));
      last = level;
    }
    const double frequency = (crossing.size() - 1) / (crossing.back() - crossing.front());
    return Result{500 * (high[0] + low[0]), 500 * (high[0] - low[0]), 500 * (high[1] + low[1]),
                  500 * (high[1] - low[1]), frequency};
  };
  const Result r = run(2e-3);
  const double reference[5] = {-14.368, 14.368, -63.321, 65.194, 1.1034};
  const double featflow[5] = {-14.305, 14.305, -63.607, 65.160, 1.0995};
  const double ours[5] = {r.mean_x, r.size_x, r.mean_y, r.size_y, r.frequency};
  const char* names[5] = {"mean u_x [mm]", "amplitude of u_x [mm]", "mean u_y [mm]", "amplitude of u_y [mm]",
                          "frequency"};
  for (int k = 0; k < 5; ++k) {
    std::printf("flap released, %s: %.4f, beam theory %.4f, flow solver %.4f\n", names[k], ours[k], reference[k],
                featflow[k]);
    EXPECT_NEAR(ours[k] / reference[k], 1.0, 1e-2);
    EXPECT_NEAR(ours[k] / featflow[k], 1.0, 1e-2);
    test::record({.section = "Fibers: dynamics",
                  .id = "S-D4",
                  .check = std::string("CSM3 flap as a beam, ") + names[k] + ", 16 elements, dt 2e-3",
                  .source = "Turek, Hron 2006 (plane strain solid)",
                  .reference = featflow[k],
                  .ours = ours[k],
                  .bar = "1e-2"});
  }
}

}  // namespace
}  // namespace fbi::beam
