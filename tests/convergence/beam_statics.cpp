/// Static fibers against independent references: S-B1 roll-up, S-B2 elastica, S-B3 locking, S-B4, S-B6, S-B9.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "base/log.hpp"
#include "fem/line_shapes.hpp"
#include "fem/quadrature.hpp"
#include "record.hpp"
#include "unit/beam/straight_fiber.hpp"

namespace fbi::beam {
namespace {

// EI = L = 1; a round section of slenderness zeta = L/R has EA L^2/EI = 4 zeta^2.
FiberParameters cantilever(double axial) {
  FiberParameters group = test::stiffness(axial, 1.0);
  group.start = EndCondition::clamped;
  return group;
}
double axial_of(double slenderness) { return 4 * slenderness * slenderness; }

mesh::FiberMesh unit_fiber(Index elements) { return test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, elements); }

// L2 norm over s in [0, 1] of the position minus `exact(s)`.
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

double order(double coarse, double fine) { return std::log2(coarse / fine); }

// ---------------------------------------------------------------------------------------------------------------- S-B1

Vec3 circle(double moment, double s) {
  return {std::sin(moment * s) / moment, (1 - std::cos(moment * s)) / moment, 0.0};
}

TEST(RollUp, OrderFourForEverySlendernessAndTheSameNewtonSteps) {
  const double moment = 2 * M_PI;
  const std::vector<Index> elements = {8, 16, 32, 64};
  std::vector<double> slender;  // errors at slenderness 1e4
  int slender_iterations = 0;
  for (const double slenderness : {1e4, 1e3, 1e2, 1e1}) {
    std::vector<double> error;
    int iterations = 0;
    for (const Index count : elements) {
      FiberParameters group = cantilever(axial_of(slenderness));
      group.loads = {test::load(LoadType::moment, {0, 0, moment})};
      const test::StaticSolution s = test::solve_static(unit_fiber(count), group, 10);
      ASSERT_TRUE(s.converged);
      error.push_back(position_error(s.dofs, [&](double x) { return circle(moment, x); }));
      iterations = std::max(iterations, s.all_iterations);
    }
    const std::size_t last = error.size() - 1;
    std::printf("roll-up, slenderness %5g: L2 error %.3e %.3e %.3e %.3e, orders %.2f %.2f %.2f, Newton steps %d\n",
                slenderness, error[0], error[1], error[2], error[3], order(error[0], error[1]),
                order(error[1], error[2]), order(error[2], error[3]), iterations);
    fbi::test::record({.section = "Fibers: statics",
                       .id = "S-B1",
                       .check = log::format("roll-up by an end moment, slenderness %g, 64 elements: L2 error, order",
                                            slenderness),
                       .source = "circle",
                       .reference = 0.0,
                       .ours = error[last],
                       .order = order(error[last - 1], error[last]),
                       .bar = slenderness >= 1e2 ? "order 3.95" : "below the slender ones"});
    if (slenderness == 1e4) {
      slender = error;
      slender_iterations = iterations;
    }
    if (slenderness >= 1e2) {
      EXPECT_GE(order(error[last - 1], error[last]), 3.95);
      // the curves coincide: no locking, and Newton does not feel the slenderness
      for (std::size_t i = 0; i < error.size(); ++i) EXPECT_NEAR(error[i] / slender[i], 1.0, 0.02);
      EXPECT_LE(slender_iterations, iterations + 10);  // at most the closing correction of each of the ten load steps
    } else {
      // stout: elements shorter than the radius lose up to one order (the axial part converges with h^3 there), but
      // the error stays below that of slender fibers
      EXPECT_GE(order(error[0], error[1]), 3.8);
      for (std::size_t i = 0; i < error.size(); ++i) EXPECT_LE(error[i], slender[i]);
    }
  }
}

TEST(RollUp, TipOfTheExactCircle) {
  const double table[3][3] = {{M_PI / 2, 0.6366197724, 0.6366197724}, {M_PI, 0.0, 0.6366197724}, {2 * M_PI, 0.0, 0.0}};
  for (const auto& row : table) {
    FiberParameters group = cantilever(axial_of(1e3));
    group.loads = {test::load(LoadType::moment, {0, 0, row[0]})};
    const test::StaticSolution s = test::solve_static(unit_fiber(128), group, 10);
    ASSERT_TRUE(s.converged);
    const double error = std::hypot(s.tip()[0] - row[1], s.tip()[1] - row[2]);
    std::printf("roll-up, M = %.4f, 128 elements: tip error %.1e\n", row[0], error);
    fbi::test::record({.section = "Fibers: statics",
                       .id = "S-B1",
                       .check = log::format("roll-up, M = %.4f, 128 elements: distance of the tip", row[0]),
                       .source = "circle",
                       .reference = 0.0,
                       .ours = error,
                       .bar = "5e-8"});
    EXPECT_LE(error, 5e-8);
  }
}

// Follows the moment out of the plane: the fiber rolls up in the plane normal to it, whatever its direction.
TEST(RollUp, AnySkewPlane) {
  const Vec3 along = Vec3(1, 2, -2) / 3, axis = Vec3(2, 1, 2) / 3, side = axis.cross(along);
  FiberParameters group = cantilever(axial_of(1e3));
  group.loads = {test::load(LoadType::moment, M_PI * axis)};
  const test::StaticSolution s = test::solve_static(test::straight_fiber({0, 0, 0}, along, 1.0, 32), group, 10);
  ASSERT_TRUE(s.converged);
  EXPECT_LE((s.tip() - 2 / M_PI * side).norm(), 1e-6);
}

// ---------------------------------------------------------------------------------------------------------------- S-B2

TEST(Elastica, TableOfTransverseTipForces) {
  const double table[9][4] = {{0.25, 0.12429244211364, 0.99588218159002, 0.082745915354417},
                              {0.5, 0.24453364713322, 0.98408103752916, 0.16214357565837},
                              {1, 0.46135194971188, 0.94356676371662, 0.30172077379981},
                              {2, 0.78174983155654, 0.83935827917483, 0.49345748039671},
                              {3, 0.98601694671135, 0.74557981543581, 0.60325344112998},
                              {5, 1.2153681176117, 0.61237163927557, 0.71379152361191},
                              {10, 1.4302855388039, 0.44500440224625, 0.8106090248803},
                              {20, 1.532934956297, 0.31611443243352, 0.86869589828544},
                              {50, 1.5679819015714, 0.1999996039504, 0.91715544730359}};
  const double axial = 1e8;
  for (const auto& row : table) {
    FiberParameters group = cantilever(axial);
    group.loads = {test::load(LoadType::force, {0, row[0], 0})};
    std::vector<Vec3> tips;
    std::vector<double> angles;
    int iterations = 0;
    for (const Index elements : {8, 16, 32, 64, 128}) {
      const test::StaticSolution s = test::solve_static(unit_fiber(elements), group, 10);
      ASSERT_TRUE(s.converged);
      tips.push_back(s.tip());
      angles.push_back(std::atan2(s.dofs[s.dofs.size() - 2], s.dofs[s.dofs.size() - 3]));
      iterations = s.all_iterations;
    }
    const double error = std::hypot(tips[4][0] - row[2], tips[4][1] - row[3]);
    const double coarse = (tips[0] - tips[4]).norm(), fine = (tips[1] - tips[4]).norm();
    std::printf(
        "elastica, alpha %5.2f: tip error %.1e, angle error %.1e, order 8 -> 16 elements %.2f, Newton steps %d\n",
        row[0], error, std::abs(angles[4] - row[1]), order(coarse, fine), iterations);
    fbi::test::record({.section = "Fibers: statics",
                       .id = "S-B2",
                       .check = log::format("elastica, tip force alpha = %g, 128 elements: distance of the tip; order "
                                            "8 to 16 elements", row[0]),
                       .source = "elliptic integrals (Bisshopp, Drucker 1945; Mattiasson 1981)",
                       .reference = 0.0,
                       .ours = error,
                       .order = order(coarse, fine),
                       .bar = log::format("%.1e, order 3.8", 2e-8 + row[0] / axial)});
    EXPECT_LE(error, 2e-8 + row[0] / axial);  // the last part: extension, the table is inextensible
    EXPECT_LE(std::abs(angles[4] - row[1]), 1e-7 + row[0] / axial);
    EXPECT_GE(order(coarse, fine), 3.8);
  }
}

// ---------------------------------------------------------------------------------------------------------------- S-B3

TEST(Locking, TableAndCurvesThatCoincide) {
  const double table[4][3] = {{1e4, 0.671058759830, 0.669964187905},
                              {1e3, 0.671058965470, 0.669964843992},
                              {1e2, 0.671079529245, 0.670030454215},
                              {1e1, 0.673133610163, 0.676606212429}};
  std::vector<double> slender;
  for (const auto& row : table) {
    std::vector<double> error;
    for (const Index elements : {4, 8, 16, 32, 64}) {
      FiberParameters group = cantilever(axial_of(row[0]));
      group.loads = {test::load(LoadType::force, {0, 4, 0})};
      const test::StaticSolution s = test::solve_static(unit_fiber(elements), group, 4);
      ASSERT_TRUE(s.converged);
      error.push_back(std::hypot(s.tip()[0] - row[1], s.tip()[1] - row[2]));
    }
    std::printf("locking, slenderness %5g: tip error %.3e %.3e %.3e %.3e %.3e, orders %.2f %.2f %.2f %.2f\n", row[0],
                error[0], error[1], error[2], error[3], error[4], order(error[0], error[1]), order(error[1], error[2]),
                order(error[2], error[3]), order(error[3], error[4]));
    fbi::test::record({.section = "Fibers: statics",
                       .id = "S-B3",
                       .check = log::format("locking: extensible elastica, slenderness %g, 4 to 64 elements: distance "
                                            "of the tip", row[0]),
                       .source = "shooting, 12 digits",
                       .reference = 0.0,
                       .ours_text = log::format("%.2e to %.2e", error[0], error[4]),
                       .order = order(error[2], error[3]),
                       .bar = "curves of 1e2, 1e3, 1e4 coincide"});
    EXPECT_LE(error[4], 5e-9);
    EXPECT_GE(order(error[2], error[3]), 3.8);
    if (row[0] == 1e4) slender = error;
    if (row[0] < 1e2) continue;
    for (std::size_t i = 0; i + 1 < error.size(); ++i) EXPECT_NEAR(error[i] / slender[i], 1.0, 0.02);
  }
}

// ---------------------------------------------------------------------------------------------------------- S-B4, S-B5

TEST(DeadLineLoad, Table) {
  const double table[6][3] = {{1, 0.991246395347, 0.123471401983},  {2, 0.966892946896, 0.238506582873},
                              {4, 0.890110746685, 0.425159284202},  {8, 0.724424734138, 0.640630717422},
                              {10, 0.656353761239, 0.700199715514}, {20, 0.445232052240, 0.829881443439}};
  const double axial = 1e8;
  for (const auto& row : table) {
    FiberParameters group = cantilever(axial);
    group.loads = {test::load(LoadType::line, {0, row[0], 0})};
    const test::StaticSolution s = test::solve_static(unit_fiber(64), group, 5);
    ASSERT_TRUE(s.converged);
    const double error = std::hypot(s.tip()[0] - row[1], s.tip()[1] - row[2]);
    std::printf("line load, k %4.1f: tip error %.1e\n", row[0], error);
    fbi::test::record({.section = "Fibers: statics",
                       .id = "S-B4",
                       .check = log::format("dead line load k = %g, 64 elements: distance of the tip", row[0]),
                       .source = "shooting",
                       .reference = 0.0,
                       .ours = error,
                       .bar = log::format("%.1e", 5e-8 + row[0] / axial)});
    EXPECT_LE(error, 5e-8 + row[0] / axial);
  }
  // root moment at k = 10, from the curvature of the first element
  FiberParameters group = cantilever(axial);
  group.loads = {test::load(LoadType::line, {0, 10, 0})};
  const test::StaticSolution s = test::solve_static(unit_fiber(64), group, 5);
  const std::array<double, 4> h = fem::hermite_second(-1.0);
  double curvature = 0.0;
  for (int i = 0; i < 4; ++i) curvature += h[i] * (i % 2 == 0 ? 1.0 : 0.5 / 64) * s.dofs[3 * i + 1] * 4 * 64 * 64;
  EXPECT_NEAR(curvature, 3.742191110872, 5e-3);
}

TEST(Gravity, TurekHronFlapAsABeam) {
  const double table[2][3] = {{1.4e6, -7.0986e-3, -65.622e-3}, {5.6e6, -0.4632e-3, -16.851e-3}};
  for (const auto& row : table) {
    FiberParameters group;
    group.section.area = 0.02;
    group.section.inertia = std::pow(0.02, 3) / 12;
    group.material.young = row[0] / (1 - 0.4 * 0.4);
    group.material.density = 1000;
    group.start = EndCondition::clamped;
    const test::StaticSolution s =
        test::solve_static(test::straight_fiber({0, 0, 0}, {1, 0, 0}, 0.35, 16), group, 1, {0, -2, 0});
    ASSERT_TRUE(s.converged);
    const double x = s.tip()[0] - 0.35, y = s.tip()[1];
    std::printf("flap under gravity, E %.1e: %.4e %.4e, expected %.4e %.4e\n", row[0], x, y, row[1], row[2]);
    for (int i = 0; i < 2; ++i)
      fbi::test::record({.section = "Fibers: statics",
                         .id = "S-B5",
                         .check = log::format("flap under gravity as a beam, E = %.1e: tip displacement %s", row[0],
                                              i == 0 ? "x" : "y"),
                         .source = "beam theory; Turek, Hron 2006",
                         .reference = row[i + 1],
                         .ours = i == 0 ? x : y,
                         .bar = i == 0 ? "2e-4" : "1e-4"});
    EXPECT_NEAR(x / row[1], 1.0, 2e-4);  // the table has four digits
    EXPECT_NEAR(y / row[2], 1.0, 1e-4);
  }
}

// ---------------------------------------------------------------------------------------------------------------- S-B6

TEST(Buckling, PostBucklingOfAColumn) {
  const double critical = M_PI * M_PI / 4;
  const double table[3][4] = {{20, 1.01539686554, 0.969730907364, 0.219413042396},
                              {60, 1.15171962047, 0.741019606076, 0.593207646165},
                              {100, 1.51838879329, 0.348989300415, 0.791539496537}};
  for (const auto& row : table) {
    FiberParameters group = cantilever(1e8);
    Load load = test::load(LoadType::force, {-row[1] * critical, 0, 0});
    load.value[1] = input::Expression("0.5*(1-t)");  // a lateral push that ends with the last load step
    group.loads = {load};
    const test::StaticSolution s = test::solve_static(unit_fiber(64), group, 20);
    ASSERT_TRUE(s.converged);
    const double error = std::hypot(s.tip()[0] - row[2], s.tip()[1] - row[3]);
    std::printf("post-buckling, %3g degrees: tip error %.1e\n", row[0], error);
    fbi::test::record({.section = "Fibers: statics",
                       .id = "S-B6",
                       .check = log::format("post-buckling of a column, %g degrees, 64 elements: distance of the tip",
                                            row[0]),
                       .source = "elliptic integrals (Timoshenko, Gere)",
                       .reference = 0.0,
                       .ours = error,
                       .bar = "2e-6"});
    EXPECT_LE(error, 2e-6);
  }
}

// ---------------------------------------------------------------------------------------------------------------- S-B9

TEST(ThreeDimensions, TipForceAndLineLoadInDifferentPlanes) {
  const double table[2][4] = {{4e4, 0.8059046329, 0.4674709075, 0.2707197968},
                              {1e8, 0.8058880186, 0.4674456907, 0.2707054127}};
  for (const auto& row : table) {
    FiberParameters group = cantilever(row[0]);
    group.loads = {test::load(LoadType::force, {0, 2, 0}), test::load(LoadType::line, {0, 0, 3})};
    const Vec3 expected(row[1], row[2], row[3]);
    std::vector<double> error;
    for (const Index elements : {4, 8, 16, 32, 64}) {
      const test::StaticSolution s = test::solve_static(unit_fiber(elements), group, 4);
      ASSERT_TRUE(s.converged);
      error.push_back((s.tip() - expected).norm());
    }
    std::printf("3D statics, EA %g: tip error %.2e %.2e %.2e %.2e %.2e, orders %.2f %.2f\n", row[0], error[0], error[1],
                error[2], error[3], error[4], order(error[0], error[1]), order(error[1], error[2]));
    fbi::test::record({.section = "Fibers: statics",
                       .id = "S-B9",
                       .check = log::format("tip force and line load in different planes, EA = %g, 64 elements: distance "
                                            "of the tip; order 4 to 8 elements", row[0]),
                       .source = "shooting",
                       .reference = 0.0,
                       .ours = error[4],
                       .order = order(error[0], error[1]),
                       .bar = row[0] == 4e4 ? "2e-9, order 3.8" : "3e-8, order 3.8"});
    EXPECT_LE(error[4], row[0] == 4e4 ? 2e-9 : 3e-8);
    EXPECT_GE(order(error[0], error[1]), 3.8);
  }
}

}  // namespace
}  // namespace fbi::beam
