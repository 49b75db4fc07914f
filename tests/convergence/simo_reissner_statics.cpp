/// Static fibers with shear and torsion against independent references: S-B1, S-B3, S-B8.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "base/log.hpp"
#include "fem/line_shapes.hpp"
#include "fem/quadrature.hpp"
#include "record.hpp"
#include "unit/beam/curved_fiber.hpp"

namespace fbi::beam {
namespace {

double order(double coarse, double fine) { return std::log2(coarse / fine); }

// ---------------------------------------------------------------------------------------------------------------- S-B8

// Arc of 45 degrees and radius 100, unit square section, E = 1e7, nu = 0: k G A = 5/6 5e6, EI = 1e7/12.
TEST(FortyFiveDegreeBend, AllLoadsAndBothTorsionConstants) {
  struct Reference {
    double torsion, load;
    Vec3 tip;
  };
  const std::vector<Reference> table = {{1.0 / 6, 300, {58.778897330, 22.244679427, 40.192392332}},
                                        {1.0 / 6, 450, {52.238261847, 18.508064876, 48.503491532}},
                                        {1.0 / 6, 600, {47.150096240, 15.684689479, 53.475477998}},
                                        {0.1406, 300, {58.535958776, 22.112656976, 40.480459550}},
                                        {0.1406, 450, {51.969699388, 18.369313945, 48.705140756}},
                                        {0.1406, 600, {46.891850282, 15.557814727, 53.607849529}}};
  for (const Reference& row : table) {
    std::vector<double> error;
    Vec3 tip = Vec3::Zero();
    int iterations = 0;
    for (const Index elements : {2, 4, 8, 16, 32, 64}) {
      FiberParameters group = test::shear_beam(1e7, 5e6, 5.0 / 6, 1.0, 1.0 / 12, 1.0 / 12, row.torsion);
      group.start = EndCondition::clamped;
      group.loads = {test::load(LoadType::force, {0, 0, row.load})};
      const test::StaticSolution s = test::solve_static(test::arc(100, M_PI / 4, elements), group, 6);
      ASSERT_TRUE(s.converged);
      tip = s.tip();
      error.push_back((tip - row.tip).norm());
      iterations = s.all_iterations;
    }
    const double observed = order(error[2], error[4]) / 2;
    std::printf("45 degree bend, J %.4f, P %g: tip error", row.torsion, row.load);
    for (const double e : error) std::printf(" %.2e", e);
    std::printf(", orders");
    for (std::size_t i = 0; i + 1 < error.size(); ++i) std::printf(" %.2f", order(error[i], error[i + 1]));
    std::printf(", Newton %d, tip %.9f %.9f %.9f\n", iterations, tip[0], tip[1], tip[2]);
    EXPECT_GE(observed, 3.9);
    EXPECT_LE(error[4], 3e-6);
    EXPECT_LE(error[5], 2e-7);
    test::record(
        {.section = "Fibers: statics",
         .id = "S-B8",
         .check = log::format("45 degree bend, simo_reissner, J = %.4f, P = %g, 64 elements: tip x; largest tip "
                              "error %.1e",
                              row.torsion, row.load, error[5]),
         .source = "shooting with quaternions; Bathe and Bolourchi 1979; Simo and Vu-Quoc 1986",
         .reference = row.tip[0],
         .ours = tip[0],
         .order = observed,
         .bar = "order 3.9, tip within 2e-7"});
  }
}

// The same end state by other paths: one component of the load after the other, or more steps.
TEST(FortyFiveDegreeBend, EndStateDoesNotDependOnThePath) {
  FiberParameters group = test::shear_beam(1e7, 5e6, 5.0 / 6, 1.0, 1.0 / 12, 1.0 / 12, 0.1406);
  group.start = EndCondition::clamped;
  BeamTimeParameters time;
  time.scheme = TimeScheme::static_;
  time.tolerance = 1e-13;
  const auto solved = [&](const std::vector<std::array<const char*, 3>>& forces, int steps) {
    const mesh::FiberMesh mesh = test::arc(100, M_PI / 4, 6);
    std::vector<double> dofs;
    // each stage has loads that are formulas of the load factor t in [0, 1]; statics multiply them by t once more
    FiberParameters loaded = group;
    Load load;
    load.type = LoadType::force;
    load.value = {input::Expression(forces[0][0]), input::Expression(forces[0][1]), input::Expression(forces[0][2])};
    loaded.loads = {load};
    BeamField field(mesh, {loaded}, time, Vec3::Zero());
    field.initialize({});
    for (int step = 1; step <= steps; ++step) {
      field.begin_step(static_cast<double>(step) / steps, 1.0 / steps);
      EXPECT_GE(field.solve_step({}), 0);
      field.accept_step();
    }
    return field.accepted_dofs();
  };
  const std::vector<double> straight = solved({{{"200", "-150", "500"}}}, 8);
  const std::vector<double> fine = solved({{{"200", "-150", "500"}}}, 29);
  // first z, then y, then x, with a detour to the other side
  const std::vector<double> detour =
      solved({{{"200*max(0,3*t-2)", "-150*min(1,max(0,3*t-1))+900*sin(2*pi*t)", "500*min(1,3*t)"}}}, 24);
  double error = 0.0;
  for (std::size_t i = 0; i < straight.size(); ++i)
    error = std::max({error, std::abs(fine[i] - straight[i]), std::abs(detour[i] - straight[i])});
  std::printf("end states by three paths: largest difference %.1e of %g\n", error, 100.0);
  EXPECT_LE(error, 1e-9 * 100);
  test::record(
      {.section = "Fibers: statics",
       .id = "",
       .check = "simo_reissner: end state of a spatial load by three paths, largest difference over the radius",
       .source = "identity",
       .reference = 0.0,
       .ours = error / 100,
       .bar = "1e-9"});
}

// ---------------------------------------------------------------------------------------------------------- S-B1, S-B3

// L = EI = 1, round, slenderness zeta = L/R: EA = 4 zeta^2; k G A = `shear` if given.
FiberParameters cantilever(double slenderness, double shear = 0.0) {
  const double radius = 1 / slenderness, area = M_PI * radius * radius;
  const double inertia = 0.25 * area * radius * radius, young = 1 / inertia, shear_modulus = young / 2.6;
  FiberParameters group = test::shear_beam(young, shear_modulus, shear > 0 ? shear / (shear_modulus * area) : 0.9, area,
                                           inertia, inertia, 2 * inertia);
  group.start = EndCondition::clamped;
  return group;
}
mesh::FiberMesh unit_fiber(Index elements) { return test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, elements); }

template <class Exact>
double position_error(const std::vector<double>& dofs, const Exact& exact) {
  const fem::QuadratureRule rule = fem::gauss_legendre(6);
  const int elements = static_cast<int>(dofs.size() / 6) - 1;
  const double length = 1.0 / elements;
  double sum = 0.0;
  for (int e = 0; e < elements; ++e)
    for (std::size_t p = 0; p < rule.points.size(); ++p) {
      const std::array<double, 4> h = fem::hermite(rule.points[p]);
      Vec3 r = Vec3::Zero();
      for (int i = 0; i < 4; ++i) r += h[i] * (i % 2 == 0 ? 1.0 : 0.5 * length) * Vec3(&dofs[6 * e + 3 * i]);
      sum += rule.weights[p] * 0.5 * length * (r - exact((e + 0.5 * (1 + rule.points[p])) * length)).squaredNorm();
    }
  return std::sqrt(sum);
}

TEST(RollUp, OrderFourForEverySlenderness) {
  const double moment = 2 * M_PI;
  const Vec3 axis = Vec3(0, 3, 4) / 5, side = axis.cross(Vec3(1, 0, 0));
  const auto circle = [&](double s) {
    return Vec3(std::sin(moment * s) / moment * Vec3(1, 0, 0) + (1 - std::cos(moment * s)) / moment * side);
  };
  std::vector<double> slender;
  for (const double slenderness : {1e4, 1e3, 1e2, 1e1}) {
    std::vector<double> error;
    int iterations = 0;
    for (const Index elements : {8, 16, 32, 64}) {
      FiberParameters group = cantilever(slenderness);
      group.loads = {test::load(LoadType::moment, moment * axis)};
      const test::StaticSolution s = test::solve_static(unit_fiber(elements), group, 10);
      ASSERT_TRUE(s.converged);
      error.push_back(position_error(s.dofs, circle));
      iterations = std::max(iterations, s.all_iterations);
    }
    std::printf("roll-up, slenderness %5g: L2 error %.3e %.3e %.3e %.3e, orders %.2f %.2f %.2f, Newton steps %d\n",
                slenderness, error[0], error[1], error[2], error[3], order(error[0], error[1]),
                order(error[1], error[2]), order(error[2], error[3]), iterations);
    if (slender.empty()) slender = error;
    EXPECT_GE(order(error[1], error[3]) / 2, 3.9);
    for (std::size_t i = 0; i < error.size(); ++i) EXPECT_LE(error[i], 1.02 * slender[i]);
    test::record(
        {.section = "Fibers: statics",
         .id = "S-B1",
         .check = log::format("roll-up to a circle, simo_reissner, slenderness %g: L2 error of the position, 64 "
                              "elements",
                              slenderness),
         .source = "exact solution",
         .reference = 0.0,
         .ours = error[3],
         .order = order(error[1], error[3]) / 2,
         .bar = "order 3.9, no locking"});
  }
}

TEST(Locking, TableOfTheExtensibleElasticaInTheLimitOfStiffShear) {
  const double table[4][3] = {{10, 0.673133610163, 0.676606212429},
                              {1e2, 0.671079529245, 0.670030454215},
                              {1e3, 0.671058965470, 0.669964843992},
                              {1e4, 0.671058759830, 0.669964187905}};
  std::vector<double> slender;
  for (int row = 3; row >= 0; --row) {
    const double slenderness = table[row][0];
    std::vector<double> error;
    for (const Index elements : {2, 4, 8, 16, 32}) {
      FiberParameters group = cantilever(slenderness, std::max(1e9, 4 * slenderness * slenderness));
      group.loads = {test::load(LoadType::force, {0, 4, 0})};
      const test::StaticSolution s = test::solve_static(unit_fiber(elements), group, 4);
      ASSERT_TRUE(s.converged);
      error.push_back(std::hypot(s.tip()[0] - table[row][1], s.tip()[1] - table[row][2]));
    }
    std::printf("elastica alpha 4, slenderness %5g, no shear: tip error", slenderness);
    for (const double e : error) std::printf(" %.2e", e);
    std::printf(", orders %.2f %.2f %.2f\n", order(error[0], error[1]), order(error[1], error[2]),
                order(error[2], error[3]));
    if (slender.empty()) slender = error;
    for (std::size_t i = 0; i < 4; ++i) {
      if (slenderness > 50) {
        EXPECT_NEAR(error[i] / slender[i], 1.0, 0.05);
      }
    }
    EXPECT_GE(order(error[1], error[3]) / 2, 3.8);
    EXPECT_LE(error[4], 2e-7);
    test::record(
        {.section = "Fibers: statics",
         .id = "S-B3",
         .check = log::format("extensible elastica, simo_reissner with stiff shear, slenderness %g, 32 elements: "
                              "tip error",
                              slenderness),
         .source = "elliptic integrals",
         .reference = 0.0,
         .ours = error[4],
         .order = order(error[1], error[3]) / 2,
         .bar = "order 3.8, curves of 1e2, 1e3, 1e4 coincide to 5 %"});
  }
}

// With shear the difference to torsion_free falls with the square of the slenderness.
TEST(KirchhoffLimit, AgreesWithTorsionFree) {
  std::vector<double> difference;
  for (const double slenderness : {10.0, 100.0, 1000.0}) {
    FiberParameters shear = cantilever(slenderness);
    FiberParameters plain = test::stiffness(4 * slenderness * slenderness, 1.0);
    plain.start = EndCondition::clamped;
    Vec3 tip[2];
    for (int i = 0; i < 2; ++i) {
      FiberParameters group = i == 0 ? shear : plain;
      group.loads = {test::load(LoadType::force, {0, 4, 0})};
      const test::StaticSolution s = test::solve_static(unit_fiber(64), group, 4);
      ASSERT_TRUE(s.converged);
      tip[i] = s.tip();
    }
    difference.push_back((tip[0] - tip[1]).norm() / (tip[1] - Vec3(1, 0, 0)).norm());
  }
  std::printf("simo_reissner against torsion_free, slenderness 10, 100, 1000: %.2e %.2e %.2e of the tip displacement\n",
              difference[0], difference[1], difference[2]);
  EXPECT_LE(difference[0], 0.03);
  EXPECT_NEAR(difference[0] / difference[1], 100, 10);
  EXPECT_NEAR(difference[1] / difference[2], 100, 10);
  test::record({.section = "Fibers: statics",
                .id = "",
                .check = "simo_reissner against torsion_free, elastica alpha = 4, slenderness 1000: tip displacement",
                .source = "Kirchhoff limit",
                .reference = 0.0,
                .ours = difference[2],
                .order = std::log10(difference[1] / difference[2]),
                .bar = "order 2 in 1/slenderness"});
}

// A straight fiber under an end moment along its axis twists by M L/(G J), for any angle.
TEST(Torsion, TwistByManyTurns) {
  FiberParameters group = test::shear_beam(1e4, 4e3, 0.9, 1.0, 0.01, 0.02, 0.015);
  group.start = EndCondition::clamped;
  group.loads = {test::load(LoadType::moment, {600, 0, 0})};
  BeamTimeParameters time;
  time.scheme = TimeScheme::static_;
  BeamField field(unit_fiber(4), {group}, time, Vec3::Zero());
  field.initialize({});
  for (int step = 1; step <= 8; ++step) {
    field.begin_step(step / 8.0, 1.0 / 8);
    ASSERT_GE(field.solve_step({}), 0);
    field.accept_step();
  }
  const double twist = 600 / (4e3 * 0.015), energy = 0.5 * 600 * twist;
  std::printf("twist by %.3f rad: energy %.12f, exact %.12f\n", twist, field.energy().internal, energy);
  EXPECT_NEAR(field.energy().internal / energy, 1, 1e-12);
  EXPECT_NEAR(field.energy().external_work / energy, 1, 1e-12);
  test::record({.section = "Fibers: statics",
                .id = "",
                .check = "simo_reissner: energy of a twist by 10 rad",
                .source = "exact solution",
                .reference = energy,
                .ours = field.energy().internal,
                .bar = "1e-12"});
}

}  // namespace
}  // namespace fbi::beam
