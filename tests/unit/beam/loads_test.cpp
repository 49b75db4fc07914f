/// Loads: work-equivalent nodal forces, time, load factor, fixed fibers.
#include "beam/loads.hpp"

#include <gtest/gtest.h>

#include "unit/beam/straight_fiber.hpp"

namespace fbi::beam {
namespace {

double total(const std::vector<double>& dead, int direction) {
  double sum = 0.0;
  for (std::size_t i = 0; i < dead.size(); i += 6) sum += dead[i + direction];
  return sum;
}

TEST(Loads, LineLoadOfTheReferencePositionIsIntegratedExactly) {
  // along y from 1 to 3: q = (y^2, 0, t); a linear displacement u = y does the work int y^3 dy = 20 in x
  const mesh::FiberMesh mesh = test::straight_fiber({0, 1, 0}, {0, 1, 0}, 2.0, 3);
  FiberParameters group = test::stiffness(2.0, 1.0, 3.0);
  Load load;
  load.type = LoadType::line;
  load.value = {input::Expression("y*y"), input::Expression(0.0), input::Expression("t")};
  group.loads = {load};
  const std::vector<FiberParameters> groups = {group};
  const Loads loads(mesh, groups, {0, 0, -10});
  LoadValues values;
  loads.evaluate(0.5, 1.0, values);
  EXPECT_NEAR(total(values.dead, 0), 26.0 / 3, 1e-13);
  EXPECT_NEAR(total(values.dead, 2), 2 * 0.5 - 10 * 3.0 * 2.0, 1e-12);
  double work = 0.0;
  for (Index node = 0; node < mesh.nodes(); ++node)
    work += values.dead[6 * node] * mesh.position[3 * node + 1] + values.dead[6 * node + 3];
  EXPECT_NEAR(work, 20.0, 1e-12);
  loads.evaluate(2.0, 0.25, values);
  EXPECT_NEAR(total(values.dead, 2), 0.25 * (2 * 2.0 - 60.0), 1e-12);
}

TEST(Loads, EndForcesAndMomentsGoToTheirEnd) {
  const mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, 2);
  FiberParameters group = test::stiffness(2.0, 1.0);
  group.loads = {test::load(LoadType::force, {1, 2, 3}, End::start), test::load(LoadType::force, {4, 5, 6}),
                 test::load(LoadType::moment, {7, 8, 9}, End::start), test::load(LoadType::moment, {1, 0, 2})};
  const std::vector<FiberParameters> groups = {group};
  const Loads loads(mesh, groups, Vec3::Zero());
  LoadValues values;
  loads.evaluate(0.0, 2.0, values);
  EXPECT_EQ(Vec3(&values.dead[0]), Vec3(2, 4, 6));
  EXPECT_EQ(Vec3(&values.dead[6]), Vec3(0, 0, 0));
  EXPECT_EQ(Vec3(&values.dead[12]), Vec3(8, 10, 12));
  ASSERT_EQ(values.point[0].size(), 2u);
  EXPECT_EQ(values.point[0][0].value, Vec3(14, 16, 18));
  EXPECT_EQ(values.point[0][0].x, -1.0);
  EXPECT_EQ(values.point[0][1].value, Vec3(2, 0, 4));
  EXPECT_EQ(values.point[0][1].element, 1);
}

TEST(Loads, FixedFibersCarryNone) {
  const mesh::FiberMesh mesh = test::straight_fiber({0, 0, 0}, {1, 0, 0}, 1.0, 2);
  FiberParameters group = test::stiffness(2.0, 1.0);
  group.formulation = Formulation::fixed;
  group.loads = {test::load(LoadType::force, {1, 2, 3})};
  const std::vector<FiberParameters> groups = {group};
  const Loads loads(mesh, groups, {0, 0, -10});
  LoadValues values;
  loads.evaluate(0.0, 1.0, values);
  for (const double value : values.dead) EXPECT_EQ(value, 0.0);
}

}  // namespace
}  // namespace fbi::beam
