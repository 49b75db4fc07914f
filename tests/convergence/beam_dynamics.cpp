/// Fibers in motion against independent references: S-D1 frequencies, S-D2 generalised-alpha, S-D3 flexible pendulum.
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "base/log.hpp"
#include "beam/formulation.hpp"
#include "beam/generalized_alpha.hpp"
#include "record.hpp"
#include "unit/beam/straight_fiber.hpp"

namespace fbi::beam {
namespace {

// ---------------------------------------------------------------------------------------------------------------- S-D1

// Consistent mass of one straight fiber, shape=(6 nodes,6 nodes).
Eigen::MatrixXd mass_matrix(const FiberParameters& group, const mesh::FiberMesh& mesh) {
  const ElementFormulation& formulation = *element_formulation(group.formulation);
  Eigen::MatrixXd mass = Eigen::MatrixXd::Zero(6 * mesh.nodes(), 6 * mesh.nodes());
  ElementProperties element;
  element.mass_per_length = group.material.density * group.section.area;
  for (Index e = 0; e < mesh.elements(); ++e) {
    element.length = mesh.element_length[e];
    Eigen::Matrix<double, 12, 12, Eigen::RowMajor> block;
    formulation.mass(element, block.data());
    mass.block<12, 12>(6 * e, 6 * e) += block;
  }
  return mass;
}

// Lowest bending frequencies omega from the eigenvalues 1/omega^2 of K^-1 M with the supports of the field.
std::array<double, 3> bending_frequencies(EndCondition start, EndCondition end, Index elements) {
  const mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, elements);
  FiberParameters group = test::stiffness(1e6, 1.0);
  group.start = start;
  group.end = end;
  BeamTimeParameters time;
  time.scheme = TimeScheme::static_;
  BeamField field(mesh, {group}, time, Vec3::Zero());
  field.initialize({});
  field.begin_step(1.0, 1.0);
  field.linearize();
  Eigen::MatrixXd inverse = mass_matrix(group, mesh);
  for (Eigen::Index column = 0; column < inverse.cols(); ++column) field.solve(0, inverse.col(column).data());
  const Eigen::VectorXcd values = inverse.eigenvalues();
  std::vector<double> sorted;
  for (Eigen::Index i = 0; i < values.size(); ++i)
    if (values[i].real() > 1e-14) sorted.push_back(1 / std::sqrt(values[i].real()));
  std::sort(sorted.begin(), sorted.end());
  return {sorted[0], sorted[2], sorted[4]};  // each bending mode appears in both planes
}

TEST(Frequencies, BendingModesOfSupportedFibers) {
  struct Case {
    const char* name;
    EndCondition start, end;
    std::array<double, 3> beta;  // omega = beta^2 sqrt(EI/(rho A L^4))
  };
  const Case cases[] = {
      {"cantilever", EndCondition::clamped, EndCondition::free, {1.87510406871196, 4.69409113297417, 7.85475743823761}},
      {"clamped-clamped", EndCondition::clamped, EndCondition::clamped, {4.73004074486, 7.85320462410, 10.9956078380}},
      {"clamped-pinned", EndCondition::clamped, EndCondition::pinned, {3.92660231205, 7.06858274563, 0.0}}};
  for (const Case& c : cases) {
    const std::array<double, 3> coarse = bending_frequencies(c.start, c.end, 10),
                                fine = bending_frequencies(c.start, c.end, 20);
    for (int mode = 0; mode < 3; ++mode) {
      if (c.beta[mode] == 0.0) continue;
      const double exact = c.beta[mode] * c.beta[mode];
      const double error = std::abs(fine[mode] / exact - 1),
                   order = std::log2(std::abs(coarse[mode] / exact - 1) / error);
      std::printf("%s, mode %d, 20 elements: omega %.8f, relative error %.1e, order %.2f\n", c.name, mode + 1,
                  fine[mode], error, order);
      fbi::test::record({.section = "Fibers: dynamics",
                         .id = "S-D1",
                         .check = log::format("frequency omega of a fiber %s, mode %d, 20 elements", c.name, mode + 1),
                         .source = "beta^2 sqrt(EI/(rho A L^4))",
                         .reference = exact,
                         .ours = fine[mode],
                         .order = order,
                         .bar = "1e-4, order 3.8"});
      EXPECT_LE(error, 1e-4);
      EXPECT_GE(order, 3.8);
    }
  }
}

// ---------------------------------------------------------------------------------------------------------------- S-D2

struct Discrete {
  double rho_inf, omega_dt, radius, period_ratio;
};
const Discrete discrete_values[] = {{1.0, 0.1, 1.0, 1.0008327785},          {1.0, 0.5, 1.0, 1.0204970376},
                                    {1.0, 1.0, 1.0, 1.0784052161},          {0.8, 0.1, 0.9999999316, 1.0008790238},
                                    {0.8, 0.5, 0.9999601108, 1.0216239316}, {0.8, 1.0, 0.9994746140, 1.0826025278},
                                    {0.5, 0.1, 0.9999981604, 1.0012480912}, {0.5, 0.5, 0.9990113987, 1.0301476617},
                                    {0.5, 1.0, 0.9893127860, 1.1105210437}};

// Spectral radius and T_num/T of the oscillating pair of an amplification matrix of (d, v, a).
void expect_discrete(const Discrete& expected, const Mat3& amplification, const char* what) {
  const Eigen::Vector3cd values = amplification.eigenvalues();
  std::complex<double> pair = 0.0;
  for (int i = 0; i < 3; ++i)
    if (values[i].imag() > std::abs(pair.imag())) pair = values[i];
  const double radius = std::abs(pair), ratio = expected.omega_dt / std::arg(pair);
  std::printf(
      "generalised-alpha, %s, rho_inf %.1f, omega dt %.1f: |lambda| %.10f (difference %.0e), T/T0 %.10f (%.0e)\n", what,
      expected.rho_inf, expected.omega_dt, radius, std::abs(radius - expected.radius), ratio,
      std::abs(ratio - expected.period_ratio));
  for (int i = 0; i < 2; ++i)
    fbi::test::record({.section = "Fibers: dynamics",
                       .id = "S-D2",
                       .check = log::format("generalised-alpha, %s, rho_inf = %.1f, omega dt = %.1f: %s", what,
                                            expected.rho_inf, expected.omega_dt, i == 0 ? "spectral radius" : "T/T0"),
                       .source = "exact discrete values",
                       .reference = i == 0 ? expected.radius : expected.period_ratio,
                       .ours = i == 0 ? radius : ratio,
                       .bar = "1e-9"});
  EXPECT_NEAR(radius, expected.radius, 1e-9);
  EXPECT_NEAR(ratio, expected.period_ratio, 1e-9);
}

TEST(GeneralizedAlpha, AmplificationOfAScalarOscillator) {
  for (const Discrete& expected : discrete_values) {
    const GeneralizedAlpha scheme(expected.rho_inf);
    const double dt = expected.omega_dt;
    Mat3 amplification;
    for (int column = 0; column < 3; ++column) {
      const double d = column == 0, v = column == 1, a = column == 2;
      // (1-alpha_m) a_{n+1} + alpha_m a_n + (1-alpha_f) d_{n+1} + alpha_f d_n = 0, linear in the change of d
      const double constant = (1 - scheme.alpha_m) * scheme.acceleration(0.0, v, a, dt) + scheme.alpha_m * a + d;
      const double change = -constant / (scheme.inertia_per_displacement(dt) + 1 - scheme.alpha_f);
      amplification.col(column) =
          Vec3(d + change, scheme.velocity(change, v, a, dt), scheme.acceleration(change, v, a, dt));
    }
    expect_discrete(expected, amplification, "scalar");
  }
}

TEST(GeneralizedAlpha, InfiniteFrequency) {
  for (const double rho_inf : {0.0, 0.5, 0.8, 1.0}) {
    const GeneralizedAlpha scheme(rho_inf);
    const double dt = 1e7;
    Mat3 amplification;
    for (int column = 0; column < 3; ++column) {
      const double d = column == 0, v = dt * (column == 1) / dt, a = column == 2;
      // scaled state (d, dt v, dt^2 a) with omega = 1
      const double constant = (1 - scheme.alpha_m) * scheme.acceleration(0.0, v / dt, a / (dt * dt), dt) +
                              scheme.alpha_m * a / (dt * dt) + d;
      const double change = -constant / (scheme.inertia_per_displacement(dt) + 1 - scheme.alpha_f);
      amplification.col(column) = Vec3(d + change, dt * scheme.velocity(change, v / dt, a / (dt * dt), dt),
                                       dt * dt * scheme.acceleration(change, v / dt, a / (dt * dt), dt));
    }
    // a defective eigenvalue of multiplicity two or three: its perturbation is a root of round-off
    EXPECT_NEAR(amplification.eigenvalues().cwiseAbs().maxCoeff(), rho_inf, 1e-4);
  }
}

// One axial mode of a clamped bar (exactly linear): the field's own step gives the same amplification.
TEST(GeneralizedAlpha, AmplificationOfAnAxialModeOfABar) {
  const mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, 2);
  FiberParameters group = test::stiffness(7.0, 0.3, 1.6);
  group.start = EndCondition::clamped;
  const Eigen::MatrixXd mass = mass_matrix(group, mesh);
  Eigen::VectorXd reference(18), mode = Eigen::VectorXd::Zero(18);
  for (Index node = 0; node < 3; ++node) reference.segment<6>(6 * node) << 0.5 * node, 0, 0, 1, 0, 0;
  const auto internal_force = [&](const Eigen::VectorXd& dofs) {
    Eigen::VectorXd force = Eigen::VectorXd::Zero(18);
    const ElementProperties element{0.5, 7.0, 0.3, 1.6};
    for (Index e = 0; e < 2; ++e) {
      Eigen::Matrix<double, 12, 1> part;
      element_formulation(group.formulation)->internal_force(element, dofs.data() + 6 * e, part.data(), nullptr);
      force.segment<12>(6 * e) += part;
    }
    return force;
  };
  // stretch at the clamp, and displacement and stretch of the two other nodes
  const std::array<int, 5> axial = {3, 6, 9, 12, 15};
  Eigen::Matrix<double, 5, 5> k, m;
  for (int j = 0; j < 5; ++j) {
    const Eigen::VectorXd column = internal_force(reference + 0.1 * Eigen::VectorXd::Unit(18, axial[j])) / 0.1;
    for (int i = 0; i < 5; ++i) {
      k(i, j) = column[axial[i]];
      m(i, j) = mass(axial[i], axial[j]);
    }
  }
  const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::Matrix<double, 5, 5>> modes(k, m);
  const double omega = std::sqrt(modes.eigenvalues()[1]);
  for (int i = 0; i < 5; ++i) mode[axial[i]] = modes.eigenvectors()(i, 1);

  for (const Discrete& expected : discrete_values) {
    const double dt = expected.omega_dt / omega, amplitude = 0.05;
    BeamTimeParameters time;
    time.rho_inf = expected.rho_inf;
    BeamField field(mesh, {group}, time, Vec3::Zero());
    Mat3 amplification;
    for (int column = 0; column < 3; ++column) {
      // state (d, v/omega, a/omega^2)
      const double scale[3] = {amplitude, amplitude * omega, amplitude * omega * omega};
      const Eigen::VectorXd dofs = reference + (column == 0 ? amplitude : 0.0) * mode;
      const Eigen::VectorXd fields[4] = {dofs, (column == 1 ? scale[1] : 0.0) * mode,
                                         (column == 2 ? scale[2] : 0.0) * mode, internal_force(dofs)};
      const auto state = field.state();
      const std::array<const char*, 4> names = {"dofs", "velocity", "acceleration", "internal_force"};
      for (int i = 0; i < 4; ++i) {
        ASSERT_EQ(state[i].first, names[i]);
        state[i].second->assign(fields[i].data(), fields[i].data() + 18);
      }
      field.begin_step(dt, dt);
      ASSERT_GE(field.solve_step({}), 0);
      const auto coordinate = [&](const std::vector<double>& x, double unit) {
        return mode.dot(mass * (Eigen::Map<const Eigen::VectorXd>(x.data(), 18))) / unit;
      };
      const double rest = mode.dot(mass * reference) / amplitude;
      amplification.col(column) =
          Vec3(coordinate(field.dofs(), scale[0]) - rest, coordinate(field.velocity(), scale[1]),
               coordinate(field.acceleration(), scale[2]));
    }
    expect_discrete(expected, amplification, "axial mode");
  }
}

// ---------------------------------------------------------------------------------------------------------------- S-D3

struct Pendulum {
  bool completed = true;
  double end_time = 0.0;
  std::array<Vec3, 6> tip;                   // at t = 0.2, 0.4, 0.6, 0.8, 1.0 and of the middle at t = 0.5
  double largest_energy = 0.0;               // max |E|, t <= 1
  std::array<double, 4> energy_in_second{};  // max |E| in each second
  double internal = 0.0, kinetic = 0.0;      // at t = 0.2
  int iterations = 0, most_iterations = 0;
};

Pendulum run_pendulum(Index elements, int steps_per_unit, double end_time = 1.0, double rho_inf = 1.0) {
  mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, elements);
  FiberParameters group;
  group.section.radius = 0.01;
  group.material.young = 1e7;
  group.material.density = 1000;
  group.start = EndCondition::pinned;
  BeamTimeParameters time;
  time.rho_inf = rho_inf;
  BeamField field(mesh, {group}, time, {0, -9.81, 0});
  field.initialize({});
  Pendulum result;
  const double dt = 1.0 / steps_per_unit;
  const int steps = static_cast<int>(std::lround(end_time * steps_per_unit));
  for (int step = 1; step <= steps; ++step) {
    field.begin_step(step * dt, dt);
    const int iterations = field.solve_step({});
    if (iterations < 0) {
      result.completed = false;
      break;
    }
    field.accept_step();
    result.end_time = step * dt;
    result.iterations += iterations;
    result.most_iterations = std::max(result.most_iterations, iterations);
    const Energy energy = field.energy();
    const double error = std::abs(energy.internal + energy.kinetic - energy.external_work);
    if (step <= steps_per_unit) result.largest_energy = std::max(result.largest_energy, error);
    double& in_second = result.energy_in_second[std::min(3, (step - 1) / steps_per_unit)];
    in_second = std::max(in_second, error);
    const std::vector<double>& d = field.dofs();
    for (int k = 1; k <= 5; ++k)
      if (5 * step == k * steps_per_unit) result.tip[k - 1] = Vec3(&d[d.size() - 6]);
    if (2 * step == steps_per_unit) result.tip[5] = Vec3(&d[6 * (elements / 2)]);
    if (5 * step == steps_per_unit) {
      result.internal = energy.internal;
      result.kinetic = energy.kinetic;
    }
  }
  return result;
}

TEST(Pendulum, TipsAndEnergyOfTheReference) {
  const double table[6][2] = {{0.95153, -0.18305},  {0.41840, -0.91003}, {-0.55538, -0.83189},
                              {-0.97772, -0.20301}, {-0.83049, 0.17996}, {0.00324, -0.49987}};
  for (const Index elements : {8, 16}) {
    const Pendulum coarse = run_pendulum(elements, 1000), middle = run_pendulum(elements, 2000);
    ASSERT_TRUE(coarse.completed && middle.completed);
    double worst = 0.0;
    for (int k = 0; k < 6; ++k)
      worst = std::max({worst, std::abs(coarse.tip[k][0] - table[k][0]), std::abs(coarse.tip[k][1] - table[k][1])});
    const double ratio = coarse.largest_energy / middle.largest_energy;
    std::printf(
        "pendulum, %d elements, dt 1e-3: largest tip difference %.1e, max |E| %.2e, its fall when dt is halved %.2f, "
        "E_int(0.2) %.6f, E_kin(0.2) %.6f, %.2f Newton steps a step\n",
        elements, worst, coarse.largest_energy, ratio, coarse.internal, coarse.kinetic, coarse.iterations / 1000.0);
    const auto row = [&](const char* what, double reference, double ours, const char* bar) {
      fbi::test::record({.section = "Fibers: dynamics",
                         .id = "S-D3",
                         .check = log::format("flexible pendulum, %d elements, dt = 1e-3, t <= 1: %s", elements, what),
                         .source = "Legendre-Galerkin, DOP853",
                         .reference = reference,
                         .ours = ours,
                         .bar = bar});
    };
    row("largest distance of a coordinate of the tips", 0.0, worst, "3e-4");
    row("largest energy error", 0.0, coarse.largest_energy, "5e-5");
    row("its fall when dt is halved", 4.0, ratio, "± 0.3");
    row("elastic energy at t = 0.2", 0.025149, coarse.internal, "± 5e-5");
    row("kinetic energy at t = 0.2", 0.471197, coarse.kinetic, "± 5e-5");
    EXPECT_LE(worst, 3e-4);
    EXPECT_LE(coarse.largest_energy, 5e-5);
    EXPECT_NEAR(ratio, 4.0, 0.3);
    EXPECT_NEAR(coarse.internal, 0.025149, 5e-5);
    EXPECT_NEAR(coarse.kinetic, 0.471197, 5e-5);
  }
}

// Against dt = 1.25e-4. At the fine end axial modes with omega dt of order 1 blur the order of the tips (not of the
// energy).
TEST(Pendulum, SecondOrderInTime) {
  const Pendulum reference = run_pendulum(8, 8000);
  const std::vector<int> steps = {250, 500, 1000};
  std::vector<double> error;
  for (const int count : steps) {
    const Pendulum p = run_pendulum(8, count);
    double sum = 0.0;
    for (int k = 0; k < 6; ++k) sum += (p.tip[k] - reference.tip[k]).squaredNorm();
    error.push_back(std::sqrt(sum));
  }
  const double order = 0.5 * std::log2(error[0] / error[2]);
  std::printf("pendulum, dt 4e-3, 2e-3, 1e-3: errors in time %.2e %.2e %.2e, order %.2f\n", error[0], error[1],
              error[2], order);
  fbi::test::record({.section = "Fibers: dynamics",
                     .id = "S-D3",
                     .check = "flexible pendulum, dt = 4e-3 to 1e-3: error of the tips against dt = 1.25e-4, order in time",
                     .source = "definition",
                     .ours = error[2],
                     .order = order,
                     .bar = "order 2 ± 0.2"});
  EXPECT_NEAR(order, 2.0, 0.2);
}

// Averaging the forces is not energy stable in large rotations: how the error grows, and with which dt a run completes.
TEST(Pendulum, EnergyGrowth) {
  for (const double rho_inf : {1.0, 0.8})
    for (const int steps : {100, 200, 400, 1000}) {
      const Pendulum p = run_pendulum(8, steps, 4.0, rho_inf);
      std::printf("pendulum, rho_inf %.1f, dt %g: %s t = %.3f, max |E| in each second %.2e %.2e %.2e %.2e\n", rho_inf,
                  1.0 / steps, p.completed ? "completed" : "stopped at", p.end_time, p.energy_in_second[0],
                  p.energy_in_second[1], p.energy_in_second[2], p.energy_in_second[3]);
      if (steps != 1000) continue;
      fbi::test::record({.section = "Fibers: dynamics",
                         .id = "S-D3",
                         .check = log::format("flexible pendulum to t = 4, rho_inf = %.1f, dt = 1e-3: energy error in "
                                              "each second", rho_inf),
                         .source = "definition",
                         .reference = 0.0,
                         .ours_text = log::format("%.1e, %.1e, %.1e, %.1e", p.energy_in_second[0],
                                                  p.energy_in_second[1], p.energy_in_second[2], p.energy_in_second[3]),
                         .bar = "2e-3 in the last"});
      EXPECT_TRUE(p.completed);
      EXPECT_LE(p.energy_in_second[3], 2e-3);  // E_kin is about 0.5 to 1.5
    }
}

}  // namespace
}  // namespace fbi::beam
