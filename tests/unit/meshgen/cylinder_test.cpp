/// Channels with a cylinder: the circle, the cells, the face sets.
#include "meshgen/cylinder.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "fem/hex8.hpp"
#include "meshgen/hex_checks.hpp"

using namespace fbi;

namespace {

// The channel of Schaefer and Turek 1996.
mesh::BoxParameters dfg_box() {
  mesh::BoxParameters box;
  box.size = {2.2, 0.41, 0.02};
  return box;
}

mesh::CylinderParameters dfg_cylinder(Index around, Index layers = 1) {
  mesh::CylinderParameters cylinder;
  cylinder.center = {0.2, 0.2};
  cylinder.radius = 0.05;
  cylinder.around = around;
  cylinder.layers = layers;
  return cylinder;
}

}  // namespace

TEST(Cylinder, NodesLieOnTheCircleAndCellsAreSound) {
  for (const Index around : {16, 48, 80, 160}) {
    const mesh::HexMeshData mesh = meshgen::make_cylinder_channel(dfg_box(), dfg_cylinder(around));
    ASSERT_EQ(mesh.faces.at("cylinder").size(), static_cast<std::size_t>(around));
    std::set<GlobalIndex> nodes;
    for (const mesh::Face& face : mesh.faces.at("cylinder"))
      for (const int a : fem::hex8_faces[face.face]) nodes.insert(mesh.cells[8 * face.cell + a]);
    EXPECT_EQ(nodes.size(), 2u * around);
    for (const GlobalIndex node : nodes)
      EXPECT_NEAR(std::hypot(mesh.nodes[3 * node] - 0.2, mesh.nodes[3 * node + 1] - 0.2), 0.05, 1e-16);
    const meshgen::Quality quality = meshgen::quality_of(mesh);
    EXPECT_TRUE(quality.inverted.empty());
    EXPECT_GT(quality.scaled_jacobian, 0.7) << around;
    // The volume lacks the cylinder, a polygon with `around` corners.
    const double polygon = 0.5 * around * 0.05 * 0.05 * std::sin(2.0 * std::numbers::pi / around);
    EXPECT_NEAR(quality.volume / (0.02 * (2.2 * 0.41 - polygon)), 1.0, 1e-11);
    EXPECT_TRUE(meshgen::coincident_nodes(mesh, quality.smallest_edge).empty());
    EXPECT_EQ(meshgen::connected_parts(mesh).size(), 1u);
  }
}

TEST(Cylinder, EveryBoundaryFaceHasOneName) {
  for (const mesh::Axis axis : {mesh::Axis::x, mesh::Axis::y, mesh::Axis::z}) {
    mesh::BoxParameters box;
    box.origin = {-1.0, -2.0, -3.0};
    box.size = {2.0, 3.0, 4.0};
    mesh::CylinderParameters cylinder = dfg_cylinder(16, 3);
    const int w = static_cast<int>(axis);
    cylinder.axis = axis;
    for (int i = 0, d = 0; d < 3; ++d)
      if (d != w) cylinder.center[i++] = box.origin[d] + 0.4 * box.size[d];
    cylinder.radius = 0.3;
    const mesh::HexMeshData mesh = meshgen::make_cylinder_channel(box, cylinder);
    EXPECT_TRUE(meshgen::quality_of(mesh).inverted.empty());
    std::set<std::pair<GlobalIndex, Index>> named;
    for (const auto& [name, faces] : mesh.faces) {
      for (const mesh::Face& face : faces) {
        EXPECT_TRUE(named.insert({face.cell, face.face}).second);
        for (const int a : fem::hex8_faces[face.face]) {
          const double* x = &mesh.nodes[3 * mesh.cells[8 * face.cell + a]];
          if (name == "cylinder") continue;
          const int d = name[0] - 'x';
          EXPECT_EQ(x[d], name.substr(1) == "min" ? box.origin[d] : box.origin[d] + box.size[d]);
        }
      }
    }
    EXPECT_EQ(mesh.faces.size(), 7u);
    EXPECT_EQ(named.size(), meshgen::boundary_faces(mesh).size());
  }
}

TEST(Cylinder, OneNumberRefinesAll) {
  // The quadrangles of the two-dimensional benchmarks: about 5e3, 2e4, 8e4.
  const double wanted[] = {5e3, 2e4, 8e4};
  const Index around[] = {80, 160, 320};
  for (int level = 0; level < 3; ++level) {
    const mesh::HexMeshData mesh = meshgen::make_cylinder_channel(dfg_box(), dfg_cylinder(around[level]));
    EXPECT_NEAR(static_cast<double>(mesh.cell_count()) / wanted[level], 1.0, 0.1) << mesh.cell_count();
  }
}
