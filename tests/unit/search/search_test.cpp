// Tree, bins, cell numbers and messages between ranks.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <utility>

#include "search/bins.hpp"
#include "search/pair_search.hpp"
#include "search/sparse_exchange.hpp"
#include "search/tree.hpp"

namespace fbi::search {
namespace {

std::vector<double> uniform(double begin, double end, int cells) {
  std::vector<double> x;
  for (int i = 0; i <= cells; ++i) x.push_back(begin + (end - begin) * i / cells);
  return x;
}

mesh::HexMesh distributed_box(const Comm& comm, std::array<int, 3> n, bool general) {
  return mesh::distribute(
      comm,
      mesh::chunk_of(comm, mesh::make_box({uniform(0, 3, n[0]), uniform(0, 1, n[1]), uniform(0, 1, n[2])}, general)));
}

Aabb random_box(std::mt19937& random, double size) {
  std::uniform_real_distribution<double> place(0.0, 1.0);
  Aabb box;
  for (int i = 0; i < 3; ++i) {
    box.low[i] = 3.0 * place(random) - 0.5;
    box.high[i] = box.low[i] + size * place(random);
  }
  return box;
}

TEST(Tree, FindsExactlyTheOverlappingBoxes) {
  std::mt19937 random(1);
  for (const int count : {0, 1, 4, 5, 1000}) {
    std::vector<Aabb> boxes;
    for (int i = 0; i < count; ++i) boxes.push_back(random_box(random, 0.3));
    const Tree tree(boxes);
    for (int trial = 0; trial < 50; ++trial) {
      const Aabb query = random_box(random, 0.5);
      std::vector<Index> found, expected;
      tree.overlapping(query, found);
      std::sort(found.begin(), found.end());
      for (int i = 0; i < count; ++i)
        if (boxes[i].overlaps(query)) expected.push_back(i);
      EXPECT_EQ(found, expected);
    }
  }
}

TEST(Tree, FindsEveryOverlappingPairOnce) {
  std::mt19937 random(3);
  for (const int count : {0, 1, 2, 4, 5, 9, 600}) {
    std::vector<Aabb> boxes;
    for (int i = 0; i < count; ++i) boxes.push_back(random_box(random, 0.3));
    std::vector<std::pair<Index, Index>> found, expected;
    Tree(boxes).pairs(found);
    std::sort(found.begin(), found.end());
    for (int i = 0; i < count; ++i)
      for (int j = i + 1; j < count; ++j)
        if (boxes[i].overlaps(boxes[j])) expected.emplace_back(i, j);
    EXPECT_EQ(found, expected);
    if (count == 600) {
      EXPECT_GT(found.size(), 100u);
    }
  }
}

TEST(Tree, ManyEqualBoxes) {
  Aabb box;
  const double corner[3] = {0.5, 0.5, 0.5};
  box.include(corner);
  const Tree tree(std::vector<Aabb>(100, box));
  std::vector<Index> found;
  tree.overlapping(box, found);
  EXPECT_EQ(found.size(), 100u);
}

TEST(CellNumbers, OfBoxesAndOthers) {
  const Comm comm;
  for (const bool general : {false, true}) {
    const mesh::HexMesh mesh = distributed_box(comm, {7, 5, 3}, general);
    const CellNumbers numbers(mesh);
    GlobalIndex owned = 0;
    for (GlobalIndex id = 0; id < mesh.global_cells; ++id) {
      const Index local = numbers.local(id);
      if (local < 0) continue;
      EXPECT_EQ(mesh.cell_id[local], id);
      ++owned;
    }
    EXPECT_EQ(owned, mesh.local_cells());
  }
}

TEST(Search, BinsAndTreesLoseNoCell) {
  const Comm comm;
  std::mt19937 random(2);
  for (const bool general : {false, true}) {
    const mesh::HexMesh mesh = distributed_box(comm, {9, 6, 5}, general);
    const RankBins bins(comm, mesh, 1e-8);
    const PairSearch pairs(mesh, 1e-8);
    for (int trial = 0; trial < 200; ++trial) {
      const Aabb query = random_box(random, 0.4);
      std::vector<int> ranks;
      bins.ranks_near(query, ranks);
      std::vector<Index> cells, expected;
      pairs.cells_near(query, cells);
      for (Index c = 0; c < mesh.local_cells(); ++c)
        if (cell_box(mesh, c).overlaps(query)) expected.push_back(c);
      EXPECT_EQ(cells, expected);
      EXPECT_TRUE(expected.empty() || std::binary_search(ranks.begin(), ranks.end(), comm.rank()));
    }
  }
}

TEST(RankBins, AnLShapedPartIsCutIntoBins) {
  // Cells of an L: a box around them would claim the missing quarter, bins do not.
  mesh::HexMeshData whole = mesh::make_box({uniform(0, 1, 8), uniform(0, 1, 8), uniform(0, 1, 2)}, true);
  std::vector<GlobalIndex> kept;
  for (GlobalIndex c = 0; c < whole.cell_count(); ++c)
    if (c % 8 < 4 || c / 8 % 8 < 4) kept.insert(kept.end(), &whole.cells[8 * c], &whole.cells[8 * c] + 8);
  std::vector<GlobalIndex> number(whole.node_count(), -1);
  mesh::HexMeshData part;
  for (GlobalIndex& node : kept) {
    if (number[node] < 0) {
      number[node] = part.node_count();
      part.nodes.insert(part.nodes.end(), &whole.nodes[3 * node], &whole.nodes[3 * node] + 3);
    }
    node = number[node];
  }
  part.cells = kept;
  const Comm alone(MPI_COMM_SELF);
  const mesh::HexMesh mesh = mesh::distribute(alone, mesh::chunk_of(alone, part));
  const RankBins bins(alone, mesh, 1e-8);
  std::vector<int> ranks;
  Aabb in_the_gap, in_the_l;
  const double gap[3] = {0.8, 0.8, 0.5}, l[3] = {0.2, 0.8, 0.5};
  in_the_gap.include(gap);
  in_the_l.include(l);
  bins.ranks_near(in_the_gap, ranks);
  EXPECT_TRUE(ranks.empty());
  bins.ranks_near(in_the_l, ranks);
  EXPECT_EQ(ranks, std::vector<int>{0});
}

TEST(SparseExchange, DeliversToNeighborsAgainAndAgain) {
  const Comm comm;
  SparseExchange exchange(comm);
  for (int round = 0; round < 50; ++round) {
    // Rank r writes to ranks r, r+1 and r+3 (modulo), a different number of values each time.
    std::map<int, std::vector<int>> out;
    for (const int to : {comm.rank(), (comm.rank() + 1) % comm.size(), (comm.rank() + 3) % comm.size()})
      out[to].assign(1 + (round * (comm.rank() + 1)) % 7, 1000 * round + comm.rank());
    out[0].resize(out[0].size());  // an entry may be empty: it is not sent
    std::map<int, std::vector<int>> expected;
    for (int from = 0; from < comm.size(); ++from)
      for (const int to : {from, (from + 1) % comm.size(), (from + 3) % comm.size()})
        if (to == comm.rank()) expected[from].assign(1 + (round * (from + 1)) % 7, 1000 * round + from);
    EXPECT_EQ(exchange.exchange(out), expected);
  }
}

}  // namespace
}  // namespace fbi::search
