/// Checks of meshes: folded cells, fibers outside, fibers that cross.
#include "meshgen/quality.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "mesh/hex_mesh.hpp"

using namespace fbi;

namespace {

void add_line(mesh::FiberMeshData& fibers, const Vec3& from, const Vec3& to, Index elements = 1) {
  if (fibers.first_node.empty()) fibers.first_node.push_back(0);
  for (Index n = 0; n <= elements; ++n) {
    const Vec3 x = from + (to - from) * (static_cast<double>(n) / elements), t = (to - from).normalized();
    fibers.position.insert(fibers.position.end(), x.begin(), x.end());
    fibers.tangent.insert(fibers.tangent.end(), t.begin(), t.end());
    if (n > 0) fibers.element_length.push_back((to - from).norm() / elements);
  }
  fibers.name.push_back(std::string("f").append(std::to_string(fibers.name.size())));
  fibers.group.push_back(0);
  fibers.first_node.push_back(fibers.first_node.back() + elements + 1);
}

}  // namespace

TEST(Quality, JacobianOfBricksAndFoldedCells) {
  mesh::HexMeshData mesh = mesh::make_box({{{0, 1, 3}, {0, 2}, {0, 0.1, 0.2}}});
  EXPECT_NEAR(meshgen::smallest_jacobian(mesh), 1.0, 1e-14);
  mesh.nodes[3 * 1] = 3.5;  // a node pushed through its neighbor
  EXPECT_LT(meshgen::smallest_jacobian(mesh), 0.0);
}

TEST(Quality, FibersOutside) {
  const mesh::Box box{{{{0, 0.5, 1}, {0, 0.5, 1}, {0, 0.5, 1}}}};
  mesh::FiberMeshData fibers;
  add_line(fibers, {0.5, 0, 0.5}, {0.5, 1, 0.5}, 3);      // from floor to ceiling: inside
  add_line(fibers, {0.5, -4e-10, 0.5}, {0.5, 0.5, 0.5});  // within 1e-9 cell sizes
  add_line(fibers, {0.5, -6e-10, 0.5}, {0.5, 0.5, 0.5});  // just beyond
  add_line(fibers, {0.5, 0.5, 0.5}, {0.5, 0.5, 1.5}, 2);  // half outside
  add_line(fibers, {-0.2, 0.5, 0.5}, {-0.1, 0.5, 0.5});   // wholly outside
  const std::vector<meshgen::OutsideFiber> outside = meshgen::fibers_outside(fibers, box);
  ASSERT_EQ(outside.size(), 3u);
  EXPECT_EQ(outside[0].fiber, 2);
  EXPECT_EQ(outside[0].face, "ymin");
  EXPECT_EQ(outside[1].fiber, 3);
  EXPECT_EQ(outside[1].face, "zmax");
  EXPECT_NEAR(outside[1].distance, 0.5, 1e-15);
  EXPECT_NEAR(outside[1].share, 0.5, 1e-8);
  EXPECT_EQ(outside[2].fiber, 4);
  EXPECT_NEAR(outside[2].distance, 0.2, 1e-15);
  EXPECT_EQ(outside[2].share, 1.0);
}

TEST(Quality, FibersThatCross) {
  mesh::FiberMeshData fibers;
  add_line(fibers, {0, 0, 0}, {1, 0, 0}, 4);
  add_line(fibers, {0.5, -1, 0.015}, {0.5, 1, 0.015}, 2);  // passes over the first one at a distance of 0.015
  add_line(fibers, {0, 0, 1}, {1, 0, 1}, 4);               // far
  EXPECT_EQ(meshgen::crossing_fibers(fibers, {0.01, 0.01, 0.01}).pairs, 1);
  EXPECT_EQ(meshgen::crossing_fibers(fibers, {0.007, 0.007, 0.007}).pairs, 0);
  add_line(fibers, {0, 0, 1}, {1, 0, 1}, 4);  // the same as the third
  const meshgen::Crossings crossings = meshgen::crossing_fibers(fibers, {0.01, 0.01, 0.01, 0.01});
  EXPECT_EQ(crossings.pairs, 1);
  EXPECT_EQ(crossings.coincident, 1);
  EXPECT_EQ(crossings.example[1], 3);
  add_line(fibers, {0.25, 0, 0}, {0.25, 1, 0});  // center lines that meet, without thickness
  EXPECT_EQ(meshgen::crossing_fibers(fibers, std::vector<double>(5, 0.0)).pairs, 1);
}

// Against all pairs, for fibers in random places.
TEST(Quality, CrossingsAgreeWithDenseSampling) {
  mesh::FiberMeshData fibers;
  unsigned state = 1;
  const auto random = [&] { return (state = state * 1664525u + 1013904223u) / 4294967296.0; };
  for (int i = 0; i < 60; ++i) {
    const Vec3 from(random(), random(), random());
    add_line(fibers, from, from + 0.4 * Vec3(random() - 0.5, random() - 0.5, random() - 0.5), 1 + i % 3);
  }
  const double radius = 0.05;
  GlobalIndex near = 0, unclear = 0;
  for (GlobalIndex a = 0; a < 60; ++a) {
    for (GlobalIndex b = 0; b < a; ++b) {
      const auto end = [&](GlobalIndex f, bool last) {
        return Vec3(
            Eigen::Map<const Vec3>(&fibers.position[3 * (last ? fibers.first_node[f + 1] - 1 : fibers.first_node[f])]));
      };
      const Vec3 p = end(a, false), u = end(a, true) - p, q = end(b, false), v = end(b, true) - q;
      double distance = 1e300;
      for (int i = 0; i <= 200; ++i) {
        for (int j = 0; j <= 200; ++j) distance = std::min(distance, (p + i / 200.0 * u - q - j / 200.0 * v).norm());
      }
      near += distance < 2 * radius;
      unclear += std::abs(distance - 2 * radius) < 2e-3 && distance >= 2 * radius;
    }
  }
  const GlobalIndex found = meshgen::crossing_fibers(fibers, std::vector<double>(60, radius)).pairs;
  EXPECT_GE(found, near);
  EXPECT_LE(found, near + unclear);
  EXPECT_GT(near, 10);
}
