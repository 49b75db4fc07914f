/// Partition of general meshes: the graph is symmetric, parts are complete, even, with few cut faces, the same every
/// time.
#include "linalg/graph_partition.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "fem/hex8.hpp"
#include "linalg/petsc.hpp"
#include "mesh/cell_graph.hpp"
#include "meshgen/cylinder.hpp"
#include "record.hpp"

using namespace fbi;

namespace {

mesh::HexMeshData cylinder_mesh(Index around) {
  mesh::BoxParameters box;
  box.size = {2.2, 0.41, 0.02};
  mesh::CylinderParameters cylinder;
  cylinder.center = {0.2, 0.2};
  cylinder.radius = 0.05;
  cylinder.around = around;
  return meshgen::make_cylinder_channel(box, cylinder);
}

// A duct of 160 x 8 x 8 cells bent into four half circles, up and down beside each other.
mesh::HexMeshData bent_mesh() {
  std::array<std::vector<double>, 3> x;
  for (int i = 0; i <= 160; ++i) x[0].push_back(i / 160.0);
  for (int i = 0; i <= 8; ++i) {
    x[1].push_back(i / 8.0 - 0.5);
    x[2].push_back(i / 8.0);
  }
  mesh::HexMeshData mesh = mesh::make_box(x, true);
  for (GlobalIndex n = 0; n < mesh.node_count(); ++n) {
    double* node = &mesh.nodes[3 * n];
    const double s = 4.0 * node[0], bend = std::min(std::floor(s), 3.0), turned = std::numbers::pi * (s - bend);
    const double up = std::fmod(bend, 2.0) == 0.0 ? 1.0 : -1.0, radius = 2.0 + up * node[1];
    node[0] = 4.0 * bend + 2.0 - radius * std::cos(turned);
    node[1] = up * radius * std::sin(turned);
  }
  return mesh;
}

// Ranks of all cells on all ranks: the meshes of tests are small.
std::vector<int> all_ranks(const mesh::HexMesh& mesh) {
  std::vector<int> rank(mesh.global_cells, 0);
  for (const GlobalIndex cell : mesh.cell_id) rank[cell] = mesh.comm.rank();
  MPI_Allreduce(MPI_IN_PLACE, rank.data(), static_cast<int>(rank.size()), MPI_INT, MPI_MAX, mesh.comm.get());
  return rank;
}

std::vector<int> all_ranks(const Comm& comm, const mesh::HexMeshData& mesh, mesh::Partition partition) {
  return all_ranks(linalg::distribute(comm, mesh::chunk_of(comm, mesh), partition));
}

struct Split {
  int cut_faces = 0;
  double imbalance = 0.0;  // largest part over the mean, minus 1
};
Split split_of(const mesh::HexMeshData& mesh, const std::vector<int>& rank, int ranks) {
  std::map<std::array<GlobalIndex, 4>, GlobalIndex> seen;
  Split split;
  std::vector<double> count(ranks, 0.0);
  for (GlobalIndex cell = 0; cell < mesh.cell_count(); ++cell) {
    count[rank[cell]] += 1.0;
    for (const std::array<int, 4>& corners : fem::hex8_faces) {
      std::array<GlobalIndex, 4> key;
      for (int a = 0; a < 4; ++a) key[a] = mesh.cells[8 * cell + corners[a]];
      std::sort(key.begin(), key.end());
      const auto [other, is_new] = seen.insert({key, cell});
      if (!is_new && rank[other->second] != rank[cell]) ++split.cut_faces;
    }
  }
  split.imbalance =
      *std::max_element(count.begin(), count.end()) * ranks / static_cast<double>(mesh.cell_count()) - 1.0;
  return split;
}

// Sums up the parts: a change of any cell changes it.
unsigned long long digest(const std::vector<int>& rank) {
  unsigned long long value = 1469598103934665603ull;
  for (const int r : rank) value = (value ^ static_cast<unsigned long long>(r + 1)) * 1099511628211ull;
  return value;
}

void compare(const char* name, const mesh::HexMeshData& mesh, double largest_ratio) {
  const Comm comm;
  const std::vector<int> rank = all_ranks(comm, mesh, mesh::Partition::graph);
  for (int again = 0; again < 5; ++again)
    ASSERT_EQ(all_ranks(comm, mesh, mesh::Partition::graph), rank) << name << ", call " << again + 2;
  if (comm.size() == 1) return;
  const Split graph = split_of(mesh, rank, comm.size());
  const Split bisection = split_of(mesh, all_ranks(comm, mesh, mesh::Partition::coordinates), comm.size());
  if (comm.rank() == 0)
    std::printf(
        "[ measured ] %s, %lld cells, %d ranks: graph %d faces cut, imbalance %.4f, digest %016llx; "
        "coordinates %d, %.4f\n",
        name, static_cast<long long>(mesh.cell_count()), comm.size(), graph.cut_faces, graph.imbalance, digest(rank),
        bisection.cut_faces, bisection.imbalance);
  EXPECT_LT(graph.imbalance, 0.05);
  EXPECT_GT(graph.cut_faces, 0);
  EXPECT_LE(graph.cut_faces, largest_ratio * bisection.cut_faces);
  test::record({.section = "General meshes",
                .check = std::string("faces cut by the graph partition, ") + name + ", " + std::to_string(comm.size()) +
                         " ranks",
                .source = "bisection of coordinates",
                .reference = static_cast<double>(bisection.cut_faces),
                .ours = static_cast<double>(graph.cut_faces),
                .bar = "parts within 5 %; at most " + std::to_string(largest_ratio).substr(0, 4) + " times the faces"});
}

// All pairs (cell, neighbor) of all ranks, in order of the cells.
std::vector<std::array<GlobalIndex, 2>> all_pairs(const Comm& comm, const mesh::HexMeshChunk& chunk) {
  const mesh::CellGraph graph = mesh::cell_graph(comm, chunk);
  std::vector<GlobalIndex> mine;
  for (std::size_t c = 0; c + 1 < graph.begin.size(); ++c)
    for (GlobalIndex k = graph.begin[c]; k < graph.begin[c + 1]; ++k) {
      mine.push_back(chunk.first_cell + static_cast<GlobalIndex>(c));
      mine.push_back(graph.other[k]);
    }
  std::vector<int> count(comm.size()), first(comm.size(), 0);
  const int length = static_cast<int>(mine.size());
  MPI_Allgather(&length, 1, MPI_INT, count.data(), 1, MPI_INT, comm.get());
  for (int r = 1; r < comm.size(); ++r) first[r] = first[r - 1] + count[r - 1];
  std::vector<GlobalIndex> all(first.back() + count.back());
  MPI_Allgatherv(mine.data(), length, MPI_INT64_T, all.data(), count.data(), first.data(), MPI_INT64_T, comm.get());
  std::vector<std::array<GlobalIndex, 2>> pairs;
  for (std::size_t k = 0; k < all.size(); k += 2) pairs.push_back({all[k], all[k + 1]});
  return pairs;
}

}  // namespace

TEST(CellGraph, IsSymmetricWithoutLoopsAndDoublesAndCountsInnerFaces) {
  const Comm comm;
  for (const mesh::HexMeshData& mesh : {cylinder_mesh(16), bent_mesh()}) {
    const auto pairs = all_pairs(comm, mesh::chunk_of(comm, mesh));
    const std::set<std::array<GlobalIndex, 2>> known(pairs.begin(), pairs.end());
    EXPECT_EQ(known.size(), pairs.size());
    EXPECT_TRUE(std::is_sorted(pairs.begin(), pairs.end()));
    std::size_t boundary = 0;
    for (const auto& [name, faces] : mesh.faces) boundary += faces.size();
    EXPECT_EQ(pairs.size(), 6 * static_cast<std::size_t>(mesh.cell_count()) - boundary);
    for (const auto& [cell, other] : pairs) {
      ASSERT_NE(cell, other);
      ASSERT_EQ(known.count({other, cell}), 1u);
    }
  }
}

TEST(GraphPartition, CutsFewFacesEvenlyAndTheSameEveryTime) {
  if (!linalg::has_graph_partition()) GTEST_SKIP() << "a build without PT-Scotch";
  compare("channel with cylinder, 80 cells around", cylinder_mesh(80), 1.25);
  compare("duct bent into four half circles", bent_mesh(), 1.0);
}

TEST(GraphPartition, EveryCellAndNodeHasOneRank) {
  if (!linalg::has_graph_partition()) GTEST_SKIP() << "a build without PT-Scotch";
  const Comm comm;
  const mesh::HexMeshData data = cylinder_mesh(16);
  const mesh::HexMesh mesh = linalg::distribute(comm, mesh::chunk_of(comm, data), mesh::Partition::graph);
  EXPECT_EQ(comm.sum(GlobalIndex{mesh.local_cells()}), data.cell_count());
  EXPECT_EQ(comm.sum(GlobalIndex{mesh.owned_nodes}), data.node_count());
}

TEST(GraphPartition, FallsBackOnMeshesOfFewCells) {
  const Comm comm;
  const mesh::HexMeshData data = mesh::make_box({{{0.0, 1.0, 2.0, 3.0, 4.0}, {0.0, 1.0}, {0.0, 1.0}}}, true);
  if (comm.size() > 1 && linalg::has_graph_partition()) {
    EXPECT_FALSE(linalg::partition_by_graph(comm, mesh::chunk_of(comm, data)));
  }
  if (comm.size() == 1 || linalg::has_graph_partition()) {
    const mesh::HexMesh mesh = linalg::distribute(comm, mesh::chunk_of(comm, data), mesh::Partition::graph);
    EXPECT_EQ(comm.sum(GlobalIndex{mesh.local_cells()}), 4);
  }
}
