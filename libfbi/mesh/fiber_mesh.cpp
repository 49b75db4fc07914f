#include "mesh/fiber_mesh.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "base/error.hpp"
#include "fem/line_shapes.hpp"
#include "mesh/exchange.hpp"

namespace fbi::mesh {
namespace {

using CellBox = std::array<double, 6>;  // low x, y, z, high x, y, z

// Boxes around the cells of every rank; low > high for a rank without cells. Collective.
std::vector<CellBox> cell_boxes(const Comm& comm, const HexMesh& fluid) {
  constexpr double far = std::numeric_limits<double>::max();
  CellBox mine = {far, far, far, -far, -far, -far};
  for (Index n = 0; n < fluid.local_nodes(); ++n)
    for (int d = 0; d < 3; ++d) {
      mine[d] = std::min(mine[d], fluid.node(n)[d]);
      mine[3 + d] = std::max(mine[3 + d], fluid.node(n)[d]);
    }
  std::vector<CellBox> boxes(comm.size());
  MPI_Allgather(mine.data(), 6, MPI_DOUBLE, boxes.data(), 6, MPI_DOUBLE, comm.get());
  return boxes;
}

int nearest_rank(const std::vector<CellBox>& boxes, const std::array<double, 3>& x) {
  int nearest = 0;
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t r = 0; r < boxes.size(); ++r) {
    if (boxes[r][0] > boxes[r][3]) continue;
    double distance = 0.0;
    for (int d = 0; d < 3; ++d) {
      const double outside = std::max({boxes[r][d] - x[d], x[d] - boxes[r][3 + d], 0.0});
      distance += outside * outside;
    }
    if (distance < smallest) {
      smallest = distance;
      nearest = static_cast<int>(r);
    }
  }
  return nearest;
}

// The middle (in the parameter) of the reference curve of fiber `f` of a chunk whose nodes start at first_node[0].
std::array<double, 3> middle(const FiberMeshData& chunk, std::size_t f) {
  const std::size_t begin = static_cast<std::size_t>(chunk.first_node[f] - chunk.first_node[0]);
  const std::size_t elements = static_cast<std::size_t>(chunk.first_node[f + 1] - chunk.first_node[f]) - 1;
  const std::size_t node = begin + elements / 2, element = node - f;
  std::array<double, 3> x;
  if (elements % 2 == 0) {
    for (int d = 0; d < 3; ++d) x[d] = chunk.position[3 * node + d];
    return x;
  }
  const std::array<double, 4> h = fem::hermite(0.0);
  const double half = 0.5 * chunk.element_length[element];
  for (int d = 0; d < 3; ++d)
    x[d] = h[0] * chunk.position[3 * node + d] + half * h[1] * chunk.tangent[3 * node + d] +
           h[2] * chunk.position[3 * node + 3 + d] + half * h[3] * chunk.tangent[3 * node + 3 + d];
  return x;
}

// Fibers that hang together on this rank, from the joints between its nodes.
void find_groups(FiberMesh& mesh) {
  const Index fibers = mesh.fibers();
  mesh.joined_group.assign(fibers, -1);
  if (mesh.joints.empty()) return;
  std::vector<Index> root(fibers);
  std::iota(root.begin(), root.end(), 0);
  const auto find = [&root](Index f) {
    while (root[f] != f) f = root[f] = root[root[f]];
    return f;
  };
  const auto fiber_of = [&mesh](Index node) {
    return static_cast<Index>(std::upper_bound(mesh.first_node.begin(), mesh.first_node.end(), node) -
                              mesh.first_node.begin()) -
           1;
  };
  std::vector<char> has_joint(fibers, 0);
  for (const FiberMesh::LocalJoint& joint : mesh.joints) {
    const Index a = fiber_of(joint.a), b = fiber_of(joint.b), low = std::min(find(a), find(b));
    has_joint[a] = has_joint[b] = 1;
    root[find(a)] = root[find(b)] = low;
  }
  for (Index f = 0; f < fibers; ++f) {
    if (!has_joint[f]) continue;
    const Index first = find(f);
    if (first == f) {
      mesh.joined_group[f] = static_cast<Index>(mesh.joined.size());
      mesh.joined.emplace_back();
    }
    mesh.joined_group[f] = mesh.joined_group[first];
    mesh.joined[mesh.joined_group[f]].push_back(f);
  }
}

struct FiberHeader {
  GlobalIndex id, first_node_id;
  Index group, nodes, name_length;
};

// List r of the result is the concatenation of what `append(fiber, list)` adds for the fibers of rank r.
template <class T, class Append>
RankLists<T> pack(int ranks, const std::vector<int>& rank, Append append) {
  std::vector<std::vector<T>> lists(ranks);
  for (std::size_t f = 0; f < rank.size(); ++f) append(f, lists[rank[f]]);
  RankLists<T> packed;
  packed.first = {0};
  for (const std::vector<T>& list : lists) {
    packed.data.insert(packed.data.end(), list.begin(), list.end());
    packed.first.push_back(static_cast<int>(packed.data.size()));
  }
  return packed;
}

}  // namespace

std::vector<double> FiberMesh::reference_dofs() const {
  std::vector<double> dofs(2 * position.size());
  for (std::size_t n = 0; n < position.size() / 3; ++n)
    for (int d = 0; d < 3; ++d) {
      dofs[6 * n + d] = position[3 * n + d];
      dofs[6 * n + 3 + d] = tangent[3 * n + d];
    }
  return dofs;
}

FiberMesh distribute(const Comm& comm, const FiberMeshData& chunk, GlobalIndex first_fiber, GlobalIndex first_node_id,
                     const HexMesh* fluid) {
  const std::size_t fibers = chunk.name.size();
  FiberMesh mesh;
  mesh.comm = comm;
  mesh.global_fibers = comm.sum(static_cast<GlobalIndex>(fibers));
  mesh.global_nodes = comm.sum(static_cast<GlobalIndex>(chunk.position.size() / 3));
  mesh.global_elements = comm.sum(static_cast<GlobalIndex>(chunk.element_length.size()));
  std::string text;
  for (std::size_t f = 0; f < fibers; ++f)
    if (chunk.first_node[f + 1] - chunk.first_node[f] < 2)
      text = "fiber \"" + chunk.name[f] + "\" has no element; give it at least one";
  agree_on_error(comm, ExitCode::geometry, text);

  std::vector<int> rank(fibers);
  const bool joints = !chunk.body.empty();
  if (fluid) {
    const std::vector<CellBox> boxes = cell_boxes(comm, *fluid);
    for (std::size_t f = 0; f < fibers; ++f) {
      const double* anchor = joints ? &chunk.anchor[3 * f] : nullptr;
      rank[f] = nearest_rank(boxes, joints ? std::array<double, 3>{anchor[0], anchor[1], anchor[2]} : middle(chunk, f));
    }
  } else {
    std::vector<GlobalIndex> begins(static_cast<std::size_t>(comm.size()) + 1);
    for (int r = 0; r <= comm.size(); ++r) begins[r] = even_begin(mesh.global_fibers, r, comm.size());
    for (std::size_t f = 0; f < fibers; ++f)
      rank[f] = chunk_rank(begins, joints ? chunk.body[f] : first_fiber + static_cast<GlobalIndex>(f));
  }

  const GlobalIndex base = fibers == 0 ? 0 : chunk.first_node[0];
  const auto first = [&](std::size_t f) { return static_cast<std::size_t>(chunk.first_node[f] - base); };
  const auto headers = exchange(
      comm, pack<FiberHeader>(comm.size(), rank, [&](std::size_t f, auto& list) {
        list.push_back({first_fiber + static_cast<GlobalIndex>(f), first_node_id + static_cast<GlobalIndex>(first(f)),
                        chunk.group[f], static_cast<Index>(first(f + 1) - first(f)),
                        static_cast<Index>(chunk.name[f].size())});
      }));
  const auto names = exchange(comm, pack<char>(comm.size(), rank, [&](std::size_t f, auto& list) {
                                list.insert(list.end(), chunk.name[f].begin(), chunk.name[f].end());
                              }));
  const auto numbers = exchange(comm, pack<double>(comm.size(), rank, [&](std::size_t f, auto& list) {
                                  for (std::size_t n = first(f); n < first(f + 1); ++n) {
                                    list.insert(list.end(), &chunk.position[3 * n], &chunk.position[3 * n] + 3);
                                    list.insert(list.end(), &chunk.tangent[3 * n], &chunk.tangent[3 * n] + 3);
                                  }
                                  list.insert(list.end(), chunk.element_length.begin() + (first(f) - f),
                                              chunk.element_length.begin() + (first(f + 1) - f - 1));
                                }));

  const auto joint_list = exchange(comm, pack<Joint>(comm.size(), rank, [&](std::size_t f, auto& list) {
                                     if (!joints) return;
                                     for (GlobalIndex j = chunk.first_joint[f]; j < chunk.first_joint[f + 1]; ++j)
                                       list.push_back(chunk.joints[j - chunk.first_joint[0]]);
                                   }));

  mesh.first_node = {0};
  const char* name = names.data.data();
  const double* number = numbers.data.data();
  for (const FiberHeader& header : headers.data) {  // ascending: chunks follow the ranks
    mesh.fiber_id.push_back(header.id);
    mesh.name.emplace_back(name, static_cast<std::size_t>(header.name_length));
    name += header.name_length;
    mesh.group.push_back(header.group);
    mesh.first_node.push_back(mesh.first_node.back() + header.nodes);
    mesh.first_node_id.push_back(header.first_node_id);
    for (Index n = 0; n < header.nodes; ++n, number += 6) {
      mesh.position.insert(mesh.position.end(), number, number + 3);
      mesh.tangent.insert(mesh.tangent.end(), number + 3, number + 6);
    }
    mesh.element_length.insert(mesh.element_length.end(), number, number + (header.nodes - 1));
    number += header.nodes - 1;
  }
  const auto local = [&mesh](GlobalIndex node) {  // fibers of one rank ascend, and so do their nodes
    const auto after = std::upper_bound(mesh.first_node_id.begin(), mesh.first_node_id.end(), node);
    const std::size_t f = static_cast<std::size_t>(after - mesh.first_node_id.begin()) - 1;
    return mesh.first_node[f] + static_cast<Index>(node - mesh.first_node_id[f]);
  };
  for (const Joint& joint : joint_list.data) mesh.joints.push_back({local(joint.a), local(joint.b), joint.type});
  find_groups(mesh);
  return mesh;
}

FiberMeshData chunk_of(const Comm& comm, const FiberMeshData& fibers, GlobalIndex& first_fiber,
                       GlobalIndex& first_node_id) {
  const GlobalIndex begin = even_begin(fibers.fiber_count(), comm.rank(), comm.size());
  const GlobalIndex end = even_begin(fibers.fiber_count(), comm.rank() + 1, comm.size());
  const GlobalIndex node = fibers.first_node.empty() ? 0 : fibers.first_node[begin];
  const GlobalIndex node_end = fibers.first_node.empty() ? 0 : fibers.first_node[end];
  FiberMeshData chunk;
  first_fiber = begin;
  first_node_id = node;
  chunk.name.assign(fibers.name.begin() + begin, fibers.name.begin() + end);
  chunk.group.assign(fibers.group.begin() + begin, fibers.group.begin() + end);
  chunk.first_node = {0};
  for (GlobalIndex f = begin; f < end; ++f) chunk.first_node.push_back(fibers.first_node[f + 1] - node);
  chunk.position.assign(fibers.position.begin() + 3 * node, fibers.position.begin() + 3 * node_end);
  chunk.tangent.assign(fibers.tangent.begin() + 3 * node, fibers.tangent.begin() + 3 * node_end);
  chunk.element_length.assign(fibers.element_length.begin() + (node - begin),
                              fibers.element_length.begin() + (node_end - end));
  if (!fibers.body.empty()) {
    chunk.body.assign(fibers.body.begin() + begin, fibers.body.begin() + end);
    chunk.anchor.assign(fibers.anchor.begin() + 3 * begin, fibers.anchor.begin() + 3 * end);
    chunk.first_joint.assign(fibers.first_joint.begin() + begin, fibers.first_joint.begin() + end + 1);
    chunk.joints.assign(fibers.joints.begin() + chunk.first_joint.front(),
                        fibers.joints.begin() + chunk.first_joint.back());
  }
  return chunk;
}

}  // namespace fbi::mesh
