#include "fluid/wall_normals.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <tuple>

#include "fluid/face_points.hpp"
#include "fluid/ghosted.hpp"
#include "mesh/exchange.hpp"

namespace fbi::fluid {

namespace {

constexpr int most_pieces = 3;
const double smooth = std::sqrt(0.5);  // cosine of the angle between faces of one smooth piece of wall
constexpr double independent = 1e-6;   // part of a normal that must be left by others to count

/// One face's share int N_a n at one of its nodes.
struct Share {
  GlobalIndex node, cell;
  int face;
  double area[3];
};

/// Sums of the shares of each smooth piece: faces are joined while they meet at less than the limit.
std::vector<Vec3> pieces_of(const std::vector<Share>& shares) {
  std::vector<int> piece(shares.size());
  std::vector<Vec3> unit(shares.size());
  for (std::size_t i = 0; i < shares.size(); ++i) {
    piece[i] = static_cast<int>(i);
    unit[i] = Eigen::Map<const Vec3>(shares[i].area).normalized();
  }
  for (std::size_t i = 0; i < shares.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (unit[i].dot(unit[j]) > smooth && piece[i] != piece[j]) {
        const int low = std::min(piece[i], piece[j]), high = std::max(piece[i], piece[j]);
        std::replace(piece.begin(), piece.end(), high, low);
      }
  std::vector<Vec3> sums;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    if (piece[i] != static_cast<int>(i) || sums.size() == most_pieces) continue;
    Vec3 sum = Vec3::Zero();
    for (std::size_t j = i; j < shares.size(); ++j)
      if (piece[j] == piece[i]) sum += Eigen::Map<const Vec3>(shares[j].area);
    if (sum.norm() > 0) sums.push_back(sum.normalized());
  }
  return sums;
}

}  // namespace

std::vector<NodeNormals> wall_normals(const mesh::HexMesh& mesh, const std::vector<mesh::HexMesh::LocalFace>& faces) {
  const std::vector<GlobalIndex> begins = mesh::chunk_begins(mesh.comm, mesh.first_node, mesh.global_nodes);
  std::vector<Share> mine;
  std::vector<int> rank;
  for (const mesh::HexMesh::LocalFace& face : faces) {
    const FacePoints at = face_points(mesh, face);
    for (int a = 0; a < 4; ++a) {
      const Vec3 area = at.area_vector(a);
      mine.push_back({mesh.node_number[face_node(mesh, face, a)],
                      mesh.cell_id[face.cell],
                      static_cast<int>(face.face),
                      {area[0], area[1], area[2]}});
      rank.push_back(mesh::chunk_rank(begins, mine.back().node));
    }
  }
  std::vector<Share> all = mesh::exchange(mesh.comm, mesh::make_lists(mesh.comm.size(), mine, rank)).data;
  std::sort(all.begin(), all.end(), [](const Share& a, const Share& b) {
    return std::make_tuple(a.node, a.cell, a.face) < std::make_tuple(b.node, b.cell, b.face);
  });
  const auto same = [](const Share& a, const Share& b) {  // a face of two sets counts once
    return a.node == b.node && a.cell == b.cell && a.face == b.face;
  };
  all.erase(std::unique(all.begin(), all.end(), same), all.end());
  std::array<linalg::VecHandle, most_pieces> normals;
  for (linalg::VecHandle& vector : normals) vector = create_ghosted(mesh);
  for (std::size_t begin = 0, end = 0; begin < all.size(); begin = end) {
    while (end < all.size() && all[end].node == all[begin].node) ++end;
    const std::vector<Vec3> pieces =
        pieces_of({all.begin() + static_cast<std::ptrdiff_t>(begin), all.begin() + static_cast<std::ptrdiff_t>(end)});
    const std::size_t node = static_cast<std::size_t>(all[begin].node - mesh.first_node);
    for (std::size_t k = 0; k < pieces.size(); ++k) {
      LocalArray to(normals[k]);
      for (int i = 0; i < 3; ++i) to[4 * node + i] = pieces[k][i];
    }
  }
  std::vector<NodeNormals> result;
  for (linalg::VecHandle& vector : normals) update_ghosts(vector);
  std::array<std::unique_ptr<LocalArray>, most_pieces> values;
  for (int k = 0; k < most_pieces; ++k) values[k] = std::make_unique<LocalArray>(normals[k]);
  for (Index n = 0; n < mesh.local_nodes(); ++n) {
    NodeNormals at{n};
    for (const auto& value : values) {
      const Eigen::Map<const Vec3> normal(value->data() + 4 * static_cast<std::size_t>(n));
      if (normal.squaredNorm() > 0) at.normals.emplace_back(normal);
    }
    if (!at.normals.empty()) result.push_back(at);
  }
  return result;
}

NormalConstraint make_constraint(const NodeNormals& at, const char* given) {
  NormalConstraint result;
  result.node = at.node;
  for (Vec3 full : at.normals) {
    Vec3 direction = full;
    for (int i = 0; i < 3; ++i)
      if (given[i]) direction[i] = 0;
    for (std::size_t k = 0; k < result.direction.size(); ++k) {
      const double part = result.direction[k].dot(direction);
      direction -= part * result.direction[k];
      full -= part * result.full[k];
    }
    const double left = direction.norm();
    if (left < independent) continue;
    result.direction.push_back(direction / left);
    result.full.push_back(full / left);
  }
  return result;
}

}  // namespace fbi::fluid
