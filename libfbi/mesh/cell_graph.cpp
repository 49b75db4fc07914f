#include "mesh/cell_graph.hpp"

#include <algorithm>
#include <array>
#include <tuple>

#include "fem/hex8.hpp"
#include "mesh/exchange.hpp"

namespace fbi::mesh {
namespace {

struct HalfFace {
  std::array<GlobalIndex, 4> nodes;  // ascending
  GlobalIndex cell;
};
bool operator<(const HalfFace& a, const HalfFace& b) { return std::tie(a.nodes, a.cell) < std::tie(b.nodes, b.cell); }

struct Neighbors {
  GlobalIndex cell, other;
};
bool operator<(const Neighbors& a, const Neighbors& b) { return std::tie(a.cell, a.other) < std::tie(b.cell, b.other); }
bool operator==(const Neighbors& a, const Neighbors& b) { return a.cell == b.cell && a.other == b.other; }

}  // namespace

CellGraph cell_graph(const Comm& comm, const HexMeshChunk& chunk) {
  const std::vector<GlobalIndex> node_begins = chunk_begins(comm, chunk.first_node, chunk.global_nodes);
  const std::vector<GlobalIndex> cell_begins = chunk_begins(comm, chunk.first_cell, chunk.global_cells);
  const std::size_t cells = chunk.cells.size() / 8;
  std::vector<HalfFace> faces;
  std::vector<int> rank;
  for (std::size_t c = 0; c < cells; ++c)
    for (const std::array<int, 4>& corners : fem::hex8_faces) {
      HalfFace face{{}, chunk.first_cell + static_cast<GlobalIndex>(c)};
      for (int a = 0; a < 4; ++a) face.nodes[a] = chunk.cells[8 * c + corners[a]];
      std::sort(face.nodes.begin(), face.nodes.end());
      faces.push_back(face);
      rank.push_back(chunk_rank(node_begins, face.nodes[0]));
    }
  faces = exchange(comm, make_lists(comm.size(), faces, rank)).data;
  std::sort(faces.begin(), faces.end());
  std::vector<Neighbors> pairs;
  rank.clear();
  for (std::size_t i = 0; i + 1 < faces.size(); ++i) {
    const GlobalIndex a = faces[i].cell, b = faces[i + 1].cell;
    if (faces[i].nodes != faces[i + 1].nodes || a == b) continue;
    pairs.push_back({a, b});
    pairs.push_back({b, a});
    rank.push_back(chunk_rank(cell_begins, a));
    rank.push_back(chunk_rank(cell_begins, b));
  }
  pairs = exchange(comm, make_lists(comm.size(), pairs, rank)).data;
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  CellGraph graph;
  graph.begin.assign(cells + 1, 0);
  for (const Neighbors& pair : pairs) {
    ++graph.begin[pair.cell - chunk.first_cell + 1];
    graph.other.push_back(pair.other);
  }
  for (std::size_t c = 0; c < cells; ++c) graph.begin[c + 1] += graph.begin[c];
  return graph;
}

}  // namespace fbi::mesh
