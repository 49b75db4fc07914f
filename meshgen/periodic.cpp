#include "meshgen/periodic.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "base/error.hpp"
#include "base/log.hpp"
#include "base/types.hpp"
#include "fem/hex8.hpp"
#include "search/tree.hpp"

namespace fbi::meshgen {
namespace {

constexpr double tolerance = 1e-4;  // of the smallest edge of both sets

Vec3 place(const mesh::HexMeshData& mesh, GlobalIndex node) { return Eigen::Map<const Vec3>(&mesh.nodes[3 * node]); }

std::string text_of(const Vec3& x) { return log::format("(%.8g, %.8g, %.8g)", x[0], x[1], x[2]); }

struct Set {
  std::vector<GlobalIndex> nodes;  // ascending
  search::Aabb box;
  double smallest_edge = std::numeric_limits<double>::infinity();
};

Set set_of(const mesh::HexMeshData& mesh, const std::string& name) {
  Set set;
  for (const mesh::Face& face : mesh.faces.at(name))
    for (int a = 0; a < 4; ++a) {
      const GlobalIndex node = mesh.cells[8 * face.cell + fem::hex8_faces[face.face][a]];
      const GlobalIndex next = mesh.cells[8 * face.cell + fem::hex8_faces[face.face][(a + 1) % 4]];
      set.nodes.push_back(node);
      set.smallest_edge = std::min(set.smallest_edge, (place(mesh, node) - place(mesh, next)).norm());
    }
  std::sort(set.nodes.begin(), set.nodes.end());
  set.nodes.erase(std::unique(set.nodes.begin(), set.nodes.end()), set.nodes.end());
  for (const GlobalIndex node : set.nodes) set.box.include(&mesh.nodes[3 * node]);
  return set;
}

/// Pairs of nodes of `from` and `to`; returns what is wrong, or "".
std::string match(const mesh::HexMeshData& mesh, const std::string& from_name, const std::string& to_name,
                  std::vector<std::array<GlobalIndex, 2>>& pairs) {
  const Set from = set_of(mesh, from_name), to = set_of(mesh, to_name);
  const std::string names = "periodic faces \"" + from_name + "\" and \"" + to_name + "\"";
  const std::string remedy = "; mesh both alike (in gmsh: Periodic Surface {B} = {A} Translate {dx, dy, dz};)";
  if (from.nodes.size() != to.nodes.size())
    return names +
           log::format(" have %lld and %lld nodes", static_cast<long long>(from.nodes.size()),
                       static_cast<long long>(to.nodes.size())) +
           remedy;
  const Vec3 shift = 0.5 * (Eigen::Map<const Vec3>(to.box.low) - Eigen::Map<const Vec3>(from.box.low) +
                            Eigen::Map<const Vec3>(to.box.high) - Eigen::Map<const Vec3>(from.box.high));
  const double reach = tolerance * std::min(from.smallest_edge, to.smallest_edge);
  if (shift.norm() < 0.5 * from.smallest_edge) return names + " lie at the same place; name opposite faces";
  std::vector<search::Aabb> boxes(to.nodes.size());
  for (std::size_t i = 0; i < to.nodes.size(); ++i) {
    boxes[i].include(&mesh.nodes[3 * to.nodes[i]]);
    boxes[i].inflate(reach);
  }
  const search::Tree tree(boxes);
  std::vector<Index> near;
  for (const GlobalIndex node : from.nodes) {
    const Vec3 image = place(mesh, node) + shift;
    search::Aabb point;
    point.include(image.data());
    near.clear();
    tree.overlapping(point, near);
    if (near.size() != 1) {
      double nearest = std::numeric_limits<double>::infinity();
      for (const GlobalIndex other : to.nodes) nearest = std::min(nearest, (place(mesh, other) - image).norm());
      return names + " do not match: the node at " + text_of(place(mesh, node)) + " has no partner at " +
             text_of(image) + log::format(", the nearest is %.3g away", nearest) + remedy;
    }
    pairs.push_back({node, to.nodes[near.front()]});
  }
  return "";
}

}  // namespace

void match_periodic(const std::map<std::string, std::string>& partner, mesh::HexMeshData& mesh) {
  std::vector<std::array<GlobalIndex, 2>> pairs;
  std::string errors;
  for (const auto& [name, other] : partner) {
    if (other < name) continue;  // once a pair
    const std::string text = match(mesh, name, other, pairs);
    if (!text.empty()) errors += (errors.empty() ? "" : "\n") + text;
  }
  if (!errors.empty()) throw Error(ExitCode::geometry, errors);
  std::map<GlobalIndex, GlobalIndex> root;
  const auto find = [&](GlobalIndex node) {
    for (auto at = root.find(node); at != root.end(); at = root.find(node)) node = at->second;
    return node;
  };
  for (const std::array<GlobalIndex, 2>& pair : pairs) {
    const GlobalIndex a = find(pair[0]), b = find(pair[1]);
    if (a != b) root[std::max(a, b)] = std::min(a, b);
  }
  mesh.periodic.clear();
  for (const auto& [image, next] : root) mesh.periodic.push_back({image, find(next)});
}

}  // namespace fbi::meshgen
