/// Checks of hexahedral meshes: quality, orientation, twins, parts, boundary, recognition of boxes.
#include "meshgen/hex_checks.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "base/error.hpp"
#include "fem/hex8.hpp"
#include "mesh/hex_mesh.hpp"

using namespace fbi;

namespace {

mesh::HexMeshData graded_box(bool general = true) {
  return mesh::make_box({{{0.0, 0.1, 0.3, 0.7}, {-1.0, 0.0, 0.4}, {2.0, 2.5, 2.6, 2.8, 3.3}}}, general);
}

// The same mesh with nodes and cells in another order and every cell turned by one of the 24 rotations.
mesh::HexMeshData shuffled(const mesh::HexMeshData& mesh, unsigned seed) {
  constexpr int about_z[8] = {1, 2, 3, 0, 5, 6, 7, 4}, about_x[8] = {3, 2, 6, 7, 0, 1, 5, 4};
  std::mt19937 random(seed);
  std::vector<GlobalIndex> node(mesh.node_count()), cell(mesh.cell_count());
  std::iota(node.begin(), node.end(), GlobalIndex{0});
  std::iota(cell.begin(), cell.end(), GlobalIndex{0});
  std::shuffle(node.begin(), node.end(), random);
  std::shuffle(cell.begin(), cell.end(), random);
  mesh::HexMeshData result;
  result.nodes.resize(mesh.nodes.size());
  result.cells.resize(mesh.cells.size());
  for (GlobalIndex n = 0; n < mesh.node_count(); ++n) std::copy_n(&mesh.nodes[3 * n], 3, &result.nodes[3 * node[n]]);
  std::vector<std::array<int, 8>> turn(mesh.cell_count());
  for (GlobalIndex c = 0; c < mesh.cell_count(); ++c) {
    std::iota(turn[c].begin(), turn[c].end(), 0);
    for (unsigned k = random() % 12; k > 0; --k) {
      const std::array<int, 8> before = turn[c];
      for (int a = 0; a < 8; ++a) turn[c][a] = before[(k % 2 != 0 ? about_z : about_x)[a]];
    }
    for (int a = 0; a < 8; ++a) result.cells[8 * cell[c] + a] = node[mesh.cells[8 * c + turn[c][a]]];
  }
  for (const auto& [name, faces] : mesh.faces)
    for (const mesh::Face& face : faces)
      for (int f = 0; f < 6; ++f) {
        int corners = 0;
        for (const int a : fem::hex8_faces[f])
          corners +=
              std::count(fem::hex8_faces[face.face].begin(), fem::hex8_faces[face.face].end(), turn[face.cell][a]);
        if (corners == 4) result.faces[name].push_back({cell[face.cell], f});
      }
  return result;
}

}  // namespace

TEST(HexChecks, RecognisesABoxInAnyNumbering) {
  const mesh::HexMeshData box = graded_box(false);
  for (unsigned seed = 1; seed <= 5; ++seed) {
    mesh::HexMeshData mesh = shuffled(box, seed);
    EXPECT_TRUE(meshgen::quality_of(mesh).inverted.empty());
    ASSERT_TRUE(meshgen::recognise_box(mesh));
    EXPECT_EQ(mesh.box->coordinates, box.box->coordinates);
    EXPECT_EQ(mesh.nodes, box.nodes);
    EXPECT_EQ(mesh.cells, box.cells);
    for (const auto& [name, faces] : box.faces) {
      ASSERT_EQ(mesh.faces[name].size(), faces.size()) << name;
      for (std::size_t i = 0; i < faces.size(); ++i) {
        EXPECT_EQ(mesh.faces[name][i].cell, faces[i].cell);
        EXPECT_EQ(mesh.faces[name][i].face, faces[i].face);
      }
    }
  }
}

TEST(HexChecks, RecognisesNothingElse) {
  mesh::HexMeshData mesh = graded_box();
  mesh.nodes[3 * 17] += 1e-3;
  const std::vector<GlobalIndex> cells = mesh.cells;
  EXPECT_FALSE(meshgen::recognise_box(mesh));
  EXPECT_FALSE(mesh.box.has_value());
  EXPECT_EQ(mesh.cells, cells);
  // A box without one of its corner cells.
  mesh = graded_box();
  mesh.cells.erase(mesh.cells.begin(), mesh.cells.begin() + 8);
  EXPECT_FALSE(meshgen::recognise_box(mesh));
  // Coordinates that differ by round-off belong to one plane.
  mesh = graded_box();
  for (std::size_t k = 0; k < mesh.nodes.size(); ++k) mesh.nodes[k] *= 1.0 + (k % 2 == 0 ? 1e-15 : -1e-15);
  EXPECT_TRUE(meshgen::recognise_box(mesh));
}

TEST(HexChecks, FindsFoldedAndLeftHandedCells) {
  mesh::HexMeshData mesh = graded_box();
  EXPECT_NEAR(meshgen::quality_of(mesh).scaled_jacobian, 1.0, 1e-14);
  EXPECT_NEAR(meshgen::quality_of(mesh).volume, 0.7 * 1.4 * 1.3, 1e-14);
  for (int a = 0; a < 4; ++a) std::swap(mesh.cells[8 * 5 + a], mesh.cells[8 * 5 + 4 + a]);
  EXPECT_EQ(meshgen::quality_of(mesh).inverted, std::vector<GlobalIndex>{5});
  EXPECT_EQ(meshgen::flip_left_handed(mesh), 1);
  EXPECT_EQ(mesh.cells, graded_box().cells);
  // Two nodes of a cell exchanged: neither right- nor left-handed.
  std::swap(mesh.cells[8 * 3], mesh.cells[8 * 3 + 1]);
  EXPECT_EQ(meshgen::flip_left_handed(mesh), 0);
  EXPECT_EQ(meshgen::quality_of(mesh).inverted, std::vector<GlobalIndex>{3});
}

TEST(HexChecks, FindsTwinsAndParts) {
  mesh::HexMeshData mesh = graded_box();
  const mesh::HexMeshData other = mesh::make_box({{{0.7, 1.0}, {-1.0, 0.0, 0.4}, {2.0, 2.5, 2.6, 2.8, 3.3}}}, true);
  const GlobalIndex nodes = mesh.node_count(), cells = mesh.cell_count();
  mesh.nodes.insert(mesh.nodes.end(), other.nodes.begin(), other.nodes.end());
  for (const GlobalIndex node : other.cells) mesh.cells.push_back(nodes + node);
  EXPECT_EQ(meshgen::connected_parts(mesh), (std::vector<GlobalIndex>{0, cells}));
  const std::vector<std::array<GlobalIndex, 2>> twins = meshgen::coincident_nodes(mesh, 0.1);
  EXPECT_EQ(twins.size(), 15u);
  EXPECT_EQ(twins.front(), (std::array<GlobalIndex, 2>{3, nodes}));
  EXPECT_EQ(meshgen::boundary_faces(mesh).size(), 2u * (3 * 2 + 2 * 4 + 3 * 4) + 2u * (2 + 4 + 8));
}
