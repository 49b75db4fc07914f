/// Boxes and their distribution over ranks.
#include "mesh/hex_mesh.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <vector>

#include "base/error.hpp"
#include "mesh/exchange.hpp"

namespace fbi::mesh {
namespace {

std::vector<double> spread(Index cells, double from, double to) {
  std::vector<double> x(static_cast<std::size_t>(cells) + 1);
  for (Index i = 0; i <= cells; ++i) x[i] = from + (to - from) * i / cells;
  return x;
}

HexMeshData test_box(Index nx, Index ny, Index nz, bool general = false) {
  return make_box({spread(nx, 0.0, 3.0), spread(ny, -1.0, 1.0), spread(nz, 0.0, 0.5)}, general);
}

// Everything a distributed mesh promises, against the whole mesh.
void check(const Comm& comm, const HexMeshData& whole, const HexMesh& mesh) {
  EXPECT_EQ(mesh.global_nodes, whole.node_count());
  EXPECT_EQ(mesh.global_cells, whole.cell_count());
  EXPECT_EQ(comm.sum(GlobalIndex{mesh.owned_nodes}), whole.node_count());
  EXPECT_EQ(comm.sum(GlobalIndex{mesh.local_cells()}), whole.cell_count());
  EXPECT_EQ(comm.sum_before(GlobalIndex{mesh.owned_nodes}), mesh.first_node);
  EXPECT_TRUE(std::is_sorted(mesh.cell_id.begin(), mesh.cell_id.end()));
  const auto ghosts = mesh.node_id.begin() + mesh.owned_nodes;
  EXPECT_TRUE(std::is_sorted(mesh.node_id.begin(), ghosts));
  EXPECT_TRUE(std::is_sorted(ghosts, mesh.node_id.end()));
  for (Index n = 0; n < mesh.local_nodes(); ++n)
    for (int d = 0; d < 3; ++d) ASSERT_EQ(mesh.node(n)[d], whole.nodes[3 * mesh.node_id[n] + d]);
  for (Index c = 0; c < mesh.local_cells(); ++c)
    for (int a = 0; a < 8; ++a) ASSERT_EQ(mesh.node_id[mesh.cells[8 * c + a]], whole.cells[8 * mesh.cell_id[c] + a]);

  // Owner of a node: the lowest rank with a cell at it. One number a node, the same on every rank.
  const int nodes = static_cast<int>(whole.node_count());
  std::vector<int> lowest(nodes, comm.size());
  for (const Index n : mesh.cells) lowest[mesh.node_id[n]] = comm.rank();
  MPI_Allreduce(MPI_IN_PLACE, lowest.data(), nodes, MPI_INT, MPI_MIN, comm.get());
  std::vector<GlobalIndex> number(nodes, -1);
  for (Index n = 0; n < mesh.owned_nodes; ++n) {
    ASSERT_EQ(lowest[mesh.node_id[n]], comm.rank());
    number[mesh.node_id[n]] = mesh.first_node + n;
  }
  MPI_Allreduce(MPI_IN_PLACE, number.data(), nodes, MPI_INT64_T, MPI_MAX, comm.get());
  for (Index n = 0; n < mesh.local_nodes(); ++n) ASSERT_EQ(mesh.node_number[n], number[mesh.node_id[n]]);

  ASSERT_EQ(mesh.faces.size(), whole.faces.size());
  for (const auto& [name, faces] : whole.faces) {
    ASSERT_TRUE(mesh.faces.count(name)) << name;
    const std::vector<HexMesh::LocalFace>& mine = mesh.faces.at(name);
    EXPECT_EQ(comm.sum(static_cast<GlobalIndex>(mine.size())), static_cast<GlobalIndex>(faces.size())) << name;
    for (const HexMesh::LocalFace& face : mine)
      EXPECT_TRUE(std::any_of(faces.begin(), faces.end(),
                              [&](const Face& f) { return f.cell == mesh.cell_id[face.cell] && f.face == face.face; }));
  }
}

TEST(Box, NumbersXFastest) {
  const HexMeshData box = test_box(3, 2, 1);
  EXPECT_EQ(box.node_count(), 4 * 3 * 2);
  EXPECT_EQ(box.cell_count(), 6);
  const std::vector<GlobalIndex> second(box.cells.begin() + 8, box.cells.begin() + 16);
  EXPECT_EQ(second, (std::vector<GlobalIndex>{1, 2, 6, 5, 13, 14, 18, 17}));
  EXPECT_DOUBLE_EQ(box.nodes[3 * 5 + 0], 1.0);
  EXPECT_DOUBLE_EQ(box.nodes[3 * 5 + 1], 0.0);
  ASSERT_TRUE(box.box);
  EXPECT_EQ(box.box->cells(), (std::array<Index, 3>{3, 2, 1}));
  EXPECT_FALSE(test_box(3, 2, 1, true).box);
}

TEST(Box, FacesLieOnTheirSides) {
  const HexMeshData box = test_box(3, 4, 5);
  // Nodes of face f in the local numbering, straight from the definition of the faces by the sign of one coordinate.
  const int sign[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                          {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
  const std::map<std::string, std::array<double, 2>> side = {{"xmin", {0, 0.0}},  {"xmax", {0, 3.0}},
                                                             {"ymin", {1, -1.0}}, {"ymax", {1, 1.0}},
                                                             {"zmin", {2, 0.0}},  {"zmax", {2, 0.5}}};
  const std::map<std::string, std::size_t> count = {{"xmin", 20}, {"xmax", 20}, {"ymin", 15},
                                                    {"ymax", 15}, {"zmin", 12}, {"zmax", 12}};
  for (const auto& [name, where] : side) {
    EXPECT_EQ(box.faces.at(name).size(), count.at(name));
    const int axis = static_cast<int>(where[0]);
    for (const Face& face : box.faces.at(name)) {
      EXPECT_EQ(face.face / 2, axis);
      for (int a = 0; a < 8; ++a)
        if (sign[a][axis] == (face.face % 2 ? 1 : -1)) {
          EXPECT_EQ(box.nodes[3 * box.cells[8 * face.cell + a] + axis], where[1]);
        }
    }
  }
}

TEST(Distribute, BoxAndGeneralMeshKeepTheirPromises) {
  const Comm comm;
  for (const bool general : {false, true}) {
    const HexMeshData whole = test_box(7, 5, 3, general);
    check(comm, whole, distribute(comm, chunk_of(comm, whole)));
  }
}

TEST(Distribute, TinyMeshLeavesRanksEmpty) {
  const Comm comm;
  for (const bool general : {false, true}) {
    const HexMeshData whole = test_box(1, 1, 1, general);
    const HexMesh mesh = distribute(comm, chunk_of(comm, whole));
    check(comm, whole, mesh);
    if (comm.size() > 1) {
      EXPECT_GT(comm.sum(GlobalIndex{mesh.local_cells() == 0}), 0);
    }
  }
}

TEST(Distribute, PartsAreBalanced) {
  const Comm comm;
  const HexMesh box = distribute(comm, chunk_of(comm, test_box(24, 4, 4)));
  EXPECT_EQ(box.local_cells(), 24 * 16 / comm.size());
  const HexMesh general = distribute(comm, chunk_of(comm, test_box(5, 7, 3, true)));
  EXPECT_LE(std::abs(general.local_cells() - 105.0 / comm.size()), 1.0);
}

TEST(Distribute, DoesNotDependOnTheChunks) {
  const Comm comm;
  const HexMeshData whole = test_box(6, 5, 4, true);
  const HexMesh even = distribute(comm, chunk_of(comm, whole));
  // Everything in the chunk of the last rank.
  HexMeshChunk chunk = chunk_of(comm, whole);
  const bool last = comm.rank() == comm.size() - 1;
  chunk.first_node = chunk.first_cell = 0;
  chunk.nodes = last ? whole.nodes : std::vector<double>{};
  chunk.cells = last ? whole.cells : std::vector<GlobalIndex>{};
  for (auto& [name, faces] : chunk.faces) faces = last ? whole.faces.at(name) : std::vector<Face>{};
  const HexMesh uneven = distribute(comm, chunk);
  EXPECT_EQ(even.cell_id, uneven.cell_id);
  EXPECT_EQ(even.node_id, uneven.node_id);
  EXPECT_EQ(even.node_number, uneven.node_number);
  EXPECT_EQ(even.cells, uneven.cells);
}

TEST(Distribute, RefusesNodesWithoutCellAndWrongNumbers) {
  const Comm comm;
  HexMeshData whole = test_box(2, 2, 2, true);
  whole.nodes.insert(whole.nodes.end(), {9.0, 9.0, 9.0});
  EXPECT_THROW(distribute(comm, chunk_of(comm, whole)), Error);
  whole = test_box(2, 2, 2, true);
  whole.cells[11] = 1000;
  EXPECT_THROW(distribute(comm, chunk_of(comm, whole)), Error);
  whole = test_box(2, 2, 2, true);
  whole.faces["xmin"][0].cell = 8;
  EXPECT_THROW(distribute(comm, chunk_of(comm, whole)), Error);
}

// Periodic in x and z: images have the numbers of their masters, and every node of the file is written once.
TEST(Distribute, ImagesCarryTheNumbersOfTheirMasters) {
  const Comm comm;
  for (const bool general : {false, true}) {
    HexMeshData whole = test_box(7, 3, 1, general);
    const GlobalIndex row = 8, plane = 8 * 4;
    std::vector<GlobalIndex> master(whole.node_count());
    for (GlobalIndex n = 0; n < whole.node_count(); ++n) {
      master[n] = n % plane;
      if (master[n] % row == row - 1) master[n] -= row - 1;
      if (master[n] != n) whole.periodic.push_back({n, master[n]});
    }
    const HexMesh mesh = distribute(comm, chunk_of(comm, whole));
    EXPECT_EQ(mesh.independent_nodes, 7 * 4);
    EXPECT_TRUE(mesh.has_images());
    EXPECT_EQ(comm.sum(GlobalIndex{mesh.owned_nodes}), 7 * 4);
    EXPECT_EQ(comm.sum(GlobalIndex{mesh.written_images}), whole.node_count() - 7 * 4);
    // Solver number of each master, from its owner.
    std::vector<GlobalIndex> number(whole.node_count(), 0), written(whole.node_count(), 0);
    for (Index n = 0; n < mesh.owned_nodes; ++n) {
      EXPECT_EQ(master[mesh.node_id[n]], mesh.node_id[n]);
      number[mesh.node_id[n]] = mesh.node_number[n];
    }
    for (Index n = 0; n < mesh.owned_nodes + mesh.written_images; ++n) written[mesh.node_id[n]] += 1;
    for (std::vector<GlobalIndex>* all : {&number, &written})
      MPI_Allreduce(MPI_IN_PLACE, all->data(), static_cast<int>(all->size()), MPI_INT64_T, MPI_SUM, comm.get());
    EXPECT_EQ(written, std::vector<GlobalIndex>(whole.node_count(), 1));
    for (Index n = 0; n < mesh.local_nodes(); ++n) {
      EXPECT_EQ(mesh.node_number[n], number[master[mesh.node_id[n]]]);
      for (int d = 0; d < 3; ++d) EXPECT_EQ(mesh.node(n)[d], whole.nodes[3 * mesh.node_id[n] + d]);
    }
  }
}

// Cells may be placed by anybody.
TEST(Distribute, TakesGivenRanks) {
  const Comm comm;
  const HexMeshData whole = test_box(5, 4, 3, true);
  HexMeshChunk chunk = chunk_of(comm, whole);
  std::vector<int> rank(chunk.cells.size() / 8);
  for (std::size_t c = 0; c < rank.size(); ++c)
    rank[c] = static_cast<int>((7 * (chunk.first_cell + static_cast<GlobalIndex>(c))) % comm.size());
  const HexMesh mesh = distribute(comm, chunk, rank);
  check(comm, whole, mesh);
  for (const GlobalIndex cell : mesh.cell_id) EXPECT_EQ(7 * cell % comm.size(), comm.rank());
}

TEST(Distribute, HalfAMillionCells) {
  const Comm comm;
  HexMeshChunk chunk = chunk_of(comm, test_box(480, 32, 32));
  for (const bool general : {false, true}) {
    if (general) chunk.box.reset();
    MPI_Barrier(comm.get());
    const auto start = std::chrono::steady_clock::now();
    const HexMesh mesh = distribute(comm, chunk);
    const double seconds = comm.max(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
    EXPECT_EQ(comm.sum(GlobalIndex{mesh.local_cells()}), 491520);
    if (comm.rank() == 0)
      std::printf("distribute %s: %.3f s on %d ranks\n", general ? "general" : "box", seconds, comm.size());
  }
}

}  // namespace
}  // namespace fbi::mesh
