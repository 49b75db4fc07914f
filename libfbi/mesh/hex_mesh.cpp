#include "mesh/hex_mesh.hpp"

#include <algorithm>
#include <tuple>

#include "base/error.hpp"
#include "base/log.hpp"
#include "mesh/exchange.hpp"
#include "mesh/partition.hpp"

namespace fbi::mesh {
namespace {

struct PlacedNode {
  std::array<double, 3> x;
  int owner;           // lowest rank that asked for the node
  GlobalIndex master;  // -1: the node is no image
};

// What the ranks that hold the chunks know of their nodes.
struct NodeHome {
  std::vector<int> owner;           // lowest rank that has the node
  std::vector<GlobalIndex> master;  // -1: no image
};

// Masters of the nodes of this rank's chunk. Collective.
std::vector<GlobalIndex> home_masters(const Comm& comm, const HexMeshChunk& chunk,
                                      const std::vector<GlobalIndex>& begins) {
  std::vector<GlobalIndex> master(chunk.nodes.size() / 3, -1);
  if (!comm.any(!chunk.periodic.empty())) return master;
  std::vector<int> rank;
  for (const std::array<GlobalIndex, 2>& pair : chunk.periodic) rank.push_back(chunk_rank(begins, pair[0]));
  for (const std::array<GlobalIndex, 2>& pair : exchange(comm, make_lists(comm.size(), chunk.periodic, rank)).data)
    master[pair[0] - chunk.first_node] = pair[1];
  return master;
}

// Answers of type T, in the order of `ids`, from the ranks `rank`; `answer` maps an id to what is sent back.
// Collective.
template <class T, class Answer>
std::vector<T> ask(const Comm& comm, const std::vector<GlobalIndex>& ids, const std::vector<int>& rank, Answer answer) {
  const RankLists<GlobalIndex> asked = exchange(comm, make_lists(comm.size(), ids, rank));
  RankLists<T> answers;
  answers.first = asked.first;
  answers.data.reserve(asked.data.size());
  for (const GlobalIndex id : asked.data) answers.data.push_back(answer(id));
  const RankLists<T> received = exchange(comm, answers);
  std::vector<int> next(received.first.begin(), received.first.end() - 1);
  std::vector<T> result(ids.size());
  for (std::size_t i = 0; i < ids.size(); ++i) result[i] = received.data[next[rank[i]]++];
  return result;
}

// Coordinates, lowest asking rank and master of the nodes `ids`, from the ranks that hold their chunks. Collective.
std::vector<PlacedNode> fetch_nodes(const Comm& comm, const HexMeshChunk& chunk, const std::vector<GlobalIndex>& begins,
                                    const std::vector<GlobalIndex>& ids, NodeHome& home) {
  std::vector<int> rank(ids.size());
  for (std::size_t i = 0; i < ids.size(); ++i) rank[i] = chunk_rank(begins, ids[i]);
  const RankLists<GlobalIndex> asked = exchange(comm, make_lists(comm.size(), ids, rank));
  std::vector<int>& owner = home.owner;
  owner.assign(chunk.nodes.size() / 3, comm.size());
  for (int r = 0; r < comm.size(); ++r)
    for (int i = asked.first[r]; i < asked.first[r + 1]; ++i) {
      int& lowest = owner[asked.data[i] - chunk.first_node];
      lowest = std::min(lowest, r);
    }
  RankLists<PlacedNode> answer;
  answer.first = asked.first;
  answer.data.reserve(asked.data.size());
  for (const GlobalIndex id : asked.data) {
    const std::size_t node = static_cast<std::size_t>(id - chunk.first_node);
    answer.data.push_back({{chunk.nodes[3 * node], chunk.nodes[3 * node + 1], chunk.nodes[3 * node + 2]},
                           owner[node],
                           home.master.empty() ? -1 : home.master[node]});
  }
  const RankLists<PlacedNode> received = exchange(comm, answer);
  std::vector<int> next(received.first.begin(), received.first.end() - 1);
  std::vector<PlacedNode> nodes(ids.size());
  for (std::size_t i = 0; i < ids.size(); ++i) nodes[i] = received.data[next[rank[i]]++];
  return nodes;
}

// The different values of `ids`, ascending.
std::vector<GlobalIndex> sorted_unique(std::vector<GlobalIndex> ids) {
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  return ids;
}

std::size_t position_of(const std::vector<GlobalIndex>& sorted, GlobalIndex id) {
  return static_cast<std::size_t>(std::lower_bound(sorted.begin(), sorted.end(), id) - sorted.begin());
}

std::vector<int> place_cells(const Comm& comm, const HexMeshChunk& chunk, const std::vector<GlobalIndex>& node_begins) {
  const std::size_t cells = chunk.cells.size() / 8;
  std::vector<int> rank(cells, 0);
  if (comm.size() == 1) return rank;
  if (chunk.box) {
    const BoxPartition partition(chunk.box->cells(), comm.size());
    for (std::size_t c = 0; c < cells; ++c) rank[c] = partition.rank(chunk.first_cell + static_cast<GlobalIndex>(c));
    return rank;
  }
  const std::vector<GlobalIndex> ids = sorted_unique(chunk.cells);
  NodeHome home;
  const std::vector<PlacedNode> nodes = fetch_nodes(comm, chunk, node_begins, ids, home);
  std::vector<double> centers(3 * cells);
  std::vector<GlobalIndex> cell_ids(cells);
  for (std::size_t c = 0; c < cells; ++c) {
    cell_ids[c] = chunk.first_cell + static_cast<GlobalIndex>(c);
    for (int a = 0; a < 8; ++a) {
      const PlacedNode& node = nodes[position_of(ids, chunk.cells[8 * c + a])];
      for (int d = 0; d < 3; ++d) centers[3 * c + d] += 0.125 * node.x[d];
    }
  }
  return bisect_centers(comm, centers, cell_ids);
}

struct PlacedCell {
  GlobalIndex id;
  std::array<GlobalIndex, 8> nodes;
};

struct PlacedFace {
  GlobalIndex cell;
  Index face;
  Index set;
};

void check_chunk(const Comm& comm, const HexMeshChunk& chunk) {
  std::string text;
  for (const GlobalIndex id : chunk.cells)
    if (id < 0 || id >= chunk.global_nodes) {
      text = log::format("a cell names node %lld, but the mesh has nodes 0 to %lld; make the mesh again",
                         static_cast<long long>(id), static_cast<long long>(chunk.global_nodes) - 1);
      break;
    }
  for (const auto& [name, faces] : chunk.faces)
    for (const Face& face : faces)
      if (face.cell < 0 || face.cell >= chunk.global_cells || face.face < 0 || face.face > 5)
        text =
            log::format("face set \"%s\" names face %d of cell %lld, which the mesh does not have; make the mesh again",
                        name.c_str(), static_cast<int>(face.face), static_cast<long long>(face.cell));
  if (chunk.box) {
    GlobalIndex nodes = 1, cells = 1;
    for (int a = 0; a < 3; ++a) {
      nodes *= static_cast<GlobalIndex>(chunk.box->coordinates[a].size());
      cells *= chunk.box->cells()[a];
    }
    if (nodes != chunk.global_nodes || cells != chunk.global_cells)
      text = "the coordinate arrays of the box do not fit its number of nodes and cells; make the mesh again";
  }
  for (const std::array<GlobalIndex, 2>& pair : chunk.periodic)
    for (const GlobalIndex id : pair)
      if (id < 0 || id >= chunk.global_nodes)
        text = "a periodic pair names a node that is not there; make the mesh again";
  agree_on_error(comm, ExitCode::geometry, text);
}

// Local numbers and owners: owned nodes, then ghosts (of them first the images that this rank writes), each ascending
// by file id; sets all node data of the mesh.
void number_nodes(const Comm& comm, const HexMeshChunk& chunk, const std::vector<GlobalIndex>& begins,
                  const std::vector<GlobalIndex>& cell_nodes, HexMesh& mesh) {
  const std::vector<GlobalIndex> ids = sorted_unique(cell_nodes);
  NodeHome home;
  home.master = home_masters(comm, chunk, begins);
  const std::vector<PlacedNode> nodes = fetch_nodes(comm, chunk, begins, ids, home);
  const auto first_here = [&](std::size_t i) { return nodes[i].owner == comm.rank(); };
  const auto owned = [&](std::size_t i) { return first_here(i) && nodes[i].master < 0; };
  const auto written = [&](std::size_t i) { return first_here(i) && nodes[i].master >= 0; };
  mesh.owned_nodes = mesh.written_images = 0;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    mesh.owned_nodes += owned(i);
    mesh.written_images += written(i);
  }
  mesh.first_node = comm.sum_before(GlobalIndex{mesh.owned_nodes});
  mesh.independent_nodes = comm.sum(GlobalIndex{mesh.owned_nodes});
  const GlobalIndex total = mesh.independent_nodes + comm.sum(GlobalIndex{mesh.written_images});
  if (total != chunk.global_nodes)
    throw Error(ExitCode::geometry, log::format("%lld of %lld nodes belong to no cell; remove them from the mesh",
                                                static_cast<long long>(chunk.global_nodes - total),
                                                static_cast<long long>(chunk.global_nodes)));
  mesh.node_id.resize(ids.size());
  mesh.coordinates.resize(3 * ids.size());
  mesh.node_number.resize(ids.size());
  std::vector<Index> local(ids.size()), ghosts;
  std::vector<GlobalIndex> owned_ids, ghost_masters;  // the node whose solver number a ghost has: itself or its master
  std::vector<int> master_owner;
  Index next_owned = 0, next_written = mesh.owned_nodes, next_ghost = mesh.owned_nodes + mesh.written_images;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    local[i] = owned(i) ? next_owned++ : written(i) ? next_written++ : next_ghost++;
    mesh.node_id[local[i]] = ids[i];
    std::copy(nodes[i].x.begin(), nodes[i].x.end(), &mesh.coordinates[3 * static_cast<std::size_t>(local[i])]);
    if (owned(i)) {
      mesh.node_number[local[i]] = mesh.first_node + local[i];
      owned_ids.push_back(ids[i]);
    } else {
      ghosts.push_back(local[i]);
      ghost_masters.push_back(nodes[i].master < 0 ? ids[i] : nodes[i].master);
      master_owner.push_back(nodes[i].owner);
    }
  }
  if (mesh.independent_nodes < chunk.global_nodes) {
    std::vector<int> at;
    for (const GlobalIndex id : ghost_masters) at.push_back(chunk_rank(begins, id));
    master_owner = ask<int>(comm, ghost_masters, at, [&](GlobalIndex id) { return home.owner[id - chunk.first_node]; });
  }
  // Solver numbers of the ghosts, from the owners.
  const std::vector<GlobalIndex> numbers = ask<GlobalIndex>(comm, ghost_masters, master_owner, [&](GlobalIndex id) {
    return mesh.first_node + static_cast<GlobalIndex>(position_of(owned_ids, id));
  });
  for (std::size_t g = 0; g < ghosts.size(); ++g) mesh.node_number[ghosts[g]] = numbers[g];
  // Neighbouring cells name nearly the same nodes: try the places after the last hits before searching.
  mesh.cells.resize(cell_nodes.size());
  std::array<std::size_t, 8> last{};
  for (std::size_t k = 0; k < cell_nodes.size(); ++k) {
    std::size_t& at = last[k % 8];
    if (at + 1 < ids.size() && ids[at + 1] == cell_nodes[k])
      ++at;
    else
      at = position_of(ids, cell_nodes[k]);
    mesh.cells[k] = local[at];
  }
}

void place_faces(const Comm& comm, const HexMeshChunk& chunk, const std::vector<int>& rank_of_cell, HexMesh& mesh) {
  const std::vector<GlobalIndex> begins = chunk_begins(comm, chunk.first_cell, chunk.global_cells);
  std::vector<PlacedFace> faces;
  std::vector<int> rank;
  std::vector<std::vector<HexMesh::LocalFace>*> sets;
  for (const auto& [name, list] : chunk.faces) {
    for (const Face& face : list) {
      faces.push_back({face.cell, face.face, static_cast<Index>(sets.size())});
      rank.push_back(chunk_rank(begins, face.cell));
    }
    sets.push_back(&mesh.faces[name]);
  }
  faces = exchange(comm, make_lists(comm.size(), faces, rank)).data;  // to the rank that read the cell
  rank.resize(faces.size());
  for (std::size_t i = 0; i < faces.size(); ++i) rank[i] = rank_of_cell[faces[i].cell - chunk.first_cell];
  faces = exchange(comm, make_lists(comm.size(), faces, rank)).data;  // to the rank that got it
  std::sort(faces.begin(), faces.end(), [](const PlacedFace& a, const PlacedFace& b) {
    return std::tie(a.set, a.cell, a.face) < std::tie(b.set, b.cell, b.face);
  });
  for (const PlacedFace& face : faces)
    sets[face.set]->push_back({static_cast<Index>(position_of(mesh.cell_id, face.cell)), face.face});
}

}  // namespace

HexMesh distribute(const Comm& comm, HexMeshChunk chunk) {
  check_chunk(comm, chunk);
  const std::vector<GlobalIndex> node_begins = chunk_begins(comm, chunk.first_node, chunk.global_nodes);
  const std::vector<int> rank_of_cell = place_cells(comm, chunk, node_begins);
  return distribute(comm, std::move(chunk), rank_of_cell);
}

HexMesh distribute(const Comm& comm, HexMeshChunk chunk, const std::vector<int>& rank_of_cell) {
  check_chunk(comm, chunk);
  const std::vector<GlobalIndex> node_begins = chunk_begins(comm, chunk.first_node, chunk.global_nodes);
  HexMesh mesh;
  mesh.comm = comm;
  mesh.global_nodes = chunk.global_nodes;
  mesh.global_cells = chunk.global_cells;
  mesh.box = chunk.box;

  std::vector<PlacedCell> cells(rank_of_cell.size());
  for (std::size_t c = 0; c < cells.size(); ++c) {
    cells[c].id = chunk.first_cell + static_cast<GlobalIndex>(c);
    std::copy_n(&chunk.cells[8 * c], 8, cells[c].nodes.begin());
  }
  cells = exchange(comm, make_lists(comm.size(), cells, rank_of_cell)).data;  // ascending: chunks follow the ranks
  std::vector<GlobalIndex> cell_nodes(8 * cells.size());
  mesh.cell_id.resize(cells.size());
  for (std::size_t c = 0; c < cells.size(); ++c) {
    mesh.cell_id[c] = cells[c].id;
    std::copy_n(cells[c].nodes.begin(), 8, &cell_nodes[8 * c]);
  }
  number_nodes(comm, chunk, node_begins, cell_nodes, mesh);
  place_faces(comm, chunk, rank_of_cell, mesh);
  return mesh;
}

HexMeshChunk chunk_of(const Comm& comm, const HexMeshData& mesh) {
  HexMeshChunk chunk;
  chunk.global_nodes = mesh.node_count();
  chunk.global_cells = mesh.cell_count();
  const auto range = [&](GlobalIndex count) {
    return std::pair{even_begin(count, comm.rank(), comm.size()), even_begin(count, comm.rank() + 1, comm.size())};
  };
  const auto [node, node_end] = range(chunk.global_nodes);
  const auto [cell, cell_end] = range(chunk.global_cells);
  chunk.first_node = node;
  chunk.first_cell = cell;
  chunk.nodes.assign(mesh.nodes.begin() + 3 * node, mesh.nodes.begin() + 3 * node_end);
  chunk.cells.assign(mesh.cells.begin() + 8 * cell, mesh.cells.begin() + 8 * cell_end);
  for (const auto& [name, faces] : mesh.faces) {
    const auto [begin, end] = range(static_cast<GlobalIndex>(faces.size()));
    chunk.faces[name].assign(faces.begin() + begin, faces.begin() + end);
  }
  const auto [pair, pair_end] = range(static_cast<GlobalIndex>(mesh.periodic.size()));
  chunk.periodic.assign(mesh.periodic.begin() + pair, mesh.periodic.begin() + pair_end);
  chunk.box = mesh.box;
  return chunk;
}

}  // namespace fbi::mesh
