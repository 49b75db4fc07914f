/// Node coordinates of channels.
#include "meshgen/channel.hpp"

#include <gtest/gtest.h>

#include <cmath>

using namespace fbi;
using meshgen::graded_line;

TEST(Channel, UniformLine) {
  const std::vector<double> x = graded_line(-1.0, 3.0, 3, {});
  ASSERT_EQ(x.size(), 4u);
  EXPECT_EQ(x[0], -1.0);
  EXPECT_NEAR(x[1], 0.0, 1e-15);
  EXPECT_EQ(x[3], 2.0);
}

TEST(Channel, GeometricLine) {
  const std::vector<double> x = graded_line(1.0, 2.0, 7, {mesh::Grading::geometric, 1.3});
  EXPECT_EQ(x.front(), 1.0);
  EXPECT_EQ(x.back(), 3.0);
  for (int i = 0; i + 2 < static_cast<int>(x.size()); ++i)
    EXPECT_NEAR((x[i + 2] - x[i + 1]) / (x[i + 1] - x[i]), 1.3, 1e-12);
  const std::vector<double> falling = graded_line(0.0, 1.0, 4, {mesh::Grading::geometric, 0.5});
  EXPECT_NEAR(falling[1], 8.0 / 15, 1e-14);
}

TEST(Channel, TanhLineHasTheRatioAndIsSymmetric) {
  for (const Index cells : {3, 8, 33}) {
    for (const double ratio : {1.0, 1.5, 4.0, 20.0}) {
      const std::vector<double> x = graded_line(0.0, 2.0, cells, {mesh::Grading::tanh, ratio});
      double smallest = 2.0, largest = 0.0;
      for (Index i = 0; i < cells; ++i) {
        smallest = std::min(smallest, x[i + 1] - x[i]);
        largest = std::max(largest, x[i + 1] - x[i]);
        EXPECT_NEAR(x[i] + x[cells - i], 2.0, 1e-14);
      }
      EXPECT_NEAR(largest / smallest, ratio, 1e-9 * ratio) << cells << " cells";
      EXPECT_EQ(x.back(), 2.0);
      EXPECT_NEAR(x[1], smallest, 1e-12);
    }
  }
}

TEST(Channel, MeshCoversTheBox) {
  mesh::BoxParameters box;
  box.origin = Vec3(-1, 0, 2);
  box.size = Vec3(3, 1, 0.5);
  box.elements = {4, 3, 2};
  box.grading[1] = {mesh::Grading::tanh, 2.0};
  const mesh::HexMeshData mesh = meshgen::make_channel(box);
  EXPECT_EQ(mesh.node_count(), 5 * 4 * 3);
  EXPECT_EQ(mesh.cell_count(), 24);
  ASSERT_TRUE(mesh.box);
  EXPECT_EQ(mesh.faces.size(), 6u);
  EXPECT_EQ(mesh.faces.at("ymax").size(), 8u);
  for (int a = 0; a < 3; ++a) EXPECT_EQ(mesh.nodes[mesh.nodes.size() - 3 + a], box.origin[a] + box.size[a]);
  box.general = true;
  const mesh::HexMeshData general = meshgen::make_channel(box);
  EXPECT_FALSE(general.box);
  EXPECT_EQ(general.nodes, mesh.nodes);
}
