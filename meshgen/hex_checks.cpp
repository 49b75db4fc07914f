#include "meshgen/hex_checks.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <tuple>

#include "base/error.hpp"
#include "base/log.hpp"
#include "base/types.hpp"
#include "fem/hex8.hpp"

namespace fbi::meshgen {
namespace {

using Corners = Eigen::Matrix<double, 3, 8>;

Corners corners_of(const mesh::HexMeshData& mesh, GlobalIndex cell) {
  Corners x;
  for (int a = 0; a < 8; ++a) x.col(a) = Eigen::Map<const Vec3>(&mesh.nodes[3 * mesh.cells[8 * cell + a]]);
  return x;
}

/// Gradients at the eight corners and the eight points of the 2 x 2 x 2 Gauss rule.
std::array<Eigen::Matrix<double, 8, 3>, 16> sample_gradients() {
  std::array<Eigen::Matrix<double, 8, 3>, 16> gradients;
  for (int a = 0; a < 8; ++a) {
    const Vec3 corner(fem::hex8_corners[a][0], fem::hex8_corners[a][1], fem::hex8_corners[a][2]);
    gradients[a] = fem::hex8_gradient(corner);
    gradients[8 + a] = fem::hex8_gradient(corner / std::sqrt(3.0));
  }
  return gradients;
}

/// Corners of a face, ascending.
std::array<GlobalIndex, 4> face_nodes(const mesh::HexMeshData& mesh, GlobalIndex cell, int face) {
  std::array<GlobalIndex, 4> nodes;
  for (int a = 0; a < 4; ++a) nodes[a] = mesh.cells[8 * cell + fem::hex8_faces[face][a]];
  std::sort(nodes.begin(), nodes.end());
  return nodes;
}

/// Different values of coordinate d, ascending; values within `tolerance` of their neighbor are one.
std::vector<double> levels(const std::vector<double>& nodes, int d, double tolerance) {
  std::vector<double> all;
  for (std::size_t n = d; n < nodes.size(); n += 3) all.push_back(nodes[n]);
  std::sort(all.begin(), all.end());
  std::vector<double> kept;
  for (const double x : all)
    if (kept.empty() || x - kept.back() > tolerance) kept.push_back(x);
  return kept;
}

std::size_t level_of(const std::vector<double>& levels, double x) {
  const auto above = std::lower_bound(levels.begin(), levels.end(), x);
  if (above == levels.begin()) return 0;
  if (above == levels.end() || x - *(above - 1) < *above - x)
    return static_cast<std::size_t>(above - levels.begin()) - 1;
  return static_cast<std::size_t>(above - levels.begin());
}

}  // namespace

Quality quality_of(const mesh::HexMeshData& mesh) {
  const std::array<Eigen::Matrix<double, 8, 3>, 16> gradients = sample_gradients();
  Quality quality;
  quality.smallest_edge = std::numeric_limits<double>::infinity();
  for (GlobalIndex cell = 0; cell < mesh.cell_count(); ++cell) {
    const Corners x = corners_of(mesh, cell);
    bool positive = true;
    for (int k = 0; k < 16; ++k) {
      const Mat3 jacobian = x * gradients[k];  // at a corner its columns are half the edges there
      const double determinant = jacobian.determinant();
      const double scale = jacobian.col(0).norm() * jacobian.col(1).norm() * jacobian.col(2).norm();
      positive = positive && determinant > 1e-9 * scale;
      if (k >= 8) {
        quality.volume += determinant;
        continue;
      }
      quality.scaled_jacobian = std::min(quality.scaled_jacobian, scale > 0.0 ? determinant / scale : 0.0);
      for (int d = 0; d < 3; ++d) {
        quality.smallest_edge = std::min(quality.smallest_edge, 2.0 * jacobian.col(d).norm());
        quality.largest_edge = std::max(quality.largest_edge, 2.0 * jacobian.col(d).norm());
      }
    }
    if (!positive) quality.inverted.push_back(cell);
  }
  return quality;
}

std::string place_of(const mesh::HexMeshData& mesh, GlobalIndex cell) {
  const Vec3 center = corners_of(mesh, cell).rowwise().mean();
  return log::format("(%.6g, %.6g, %.6g)", center[0], center[1], center[2]);
}

GlobalIndex flip_left_handed(mesh::HexMeshData& mesh) {
  const std::array<Eigen::Matrix<double, 8, 3>, 16> gradients = sample_gradients();
  GlobalIndex flipped = 0;
  for (GlobalIndex cell = 0; cell < mesh.cell_count(); ++cell) {
    const Corners x = corners_of(mesh, cell);
    bool negative = true;
    for (int k = 0; k < 8 && negative; ++k) negative = Mat3(x * gradients[k]).determinant() < 0.0;
    if (!negative) continue;
    for (int a = 0; a < 4; ++a) std::swap(mesh.cells[8 * cell + a], mesh.cells[8 * cell + 4 + a]);
    ++flipped;
  }
  return flipped;
}

std::vector<std::array<GlobalIndex, 2>> coincident_nodes(const mesh::HexMeshData& mesh, double smallest_edge) {
  const double tolerance = 1e-7 * smallest_edge;
  std::vector<GlobalIndex> order(mesh.node_count());
  std::iota(order.begin(), order.end(), GlobalIndex{0});
  std::sort(order.begin(), order.end(), [&](GlobalIndex a, GlobalIndex b) {
    return mesh.nodes[3 * a] != mesh.nodes[3 * b] ? mesh.nodes[3 * a] < mesh.nodes[3 * b] : a < b;
  });
  // Sweep along x: candidates are the nodes within the tolerance in x, found by y among them.
  std::vector<std::array<GlobalIndex, 2>> pairs;
  std::vector<std::pair<double, GlobalIndex>> group;
  for (std::size_t begin = 0; begin < order.size();) {
    std::size_t end = begin + 1;
    while (end < order.size() && mesh.nodes[3 * order[end]] - mesh.nodes[3 * order[end - 1]] <= tolerance) ++end;
    group.clear();
    for (std::size_t i = begin; i < end; ++i) group.push_back({mesh.nodes[3 * order[i] + 1], order[i]});
    std::sort(group.begin(), group.end());
    for (std::size_t i = 0; i < group.size();) {
      std::size_t stop = i + 1;
      while (stop < group.size() && group[stop].first - group[stop - 1].first <= tolerance) ++stop;
      std::vector<std::pair<double, GlobalIndex>> line;
      for (std::size_t k = i; k < stop; ++k) line.push_back({mesh.nodes[3 * group[k].second + 2], group[k].second});
      std::sort(line.begin(), line.end());
      for (std::size_t k = 0; k + 1 < line.size(); ++k)
        if (line[k + 1].first - line[k].first <= tolerance)
          pairs.push_back({std::min(line[k].second, line[k + 1].second), std::max(line[k].second, line[k + 1].second)});
      i = stop;
    }
    begin = end;
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

std::vector<GlobalIndex> connected_parts(const mesh::HexMeshData& mesh) {
  std::vector<GlobalIndex> root(mesh.node_count());
  std::iota(root.begin(), root.end(), GlobalIndex{0});
  const auto find = [&](GlobalIndex node) {
    while (root[node] != node) node = root[node] = root[root[node]];
    return node;
  };
  for (GlobalIndex cell = 0; cell < mesh.cell_count(); ++cell)
    for (int a = 1; a < 8; ++a) {
      const GlobalIndex first = find(mesh.cells[8 * cell]), other = find(mesh.cells[8 * cell + a]);
      root[std::max(first, other)] = std::min(first, other);
    }
  std::vector<char> seen(mesh.node_count(), 0);
  std::vector<GlobalIndex> parts;
  for (GlobalIndex cell = 0; cell < mesh.cell_count(); ++cell) {
    char& mark = seen[find(mesh.cells[8 * cell])];
    if (mark == 0) parts.push_back(cell);
    mark = 1;
  }
  return parts;
}

std::vector<mesh::Face> boundary_faces(const mesh::HexMeshData& mesh) {
  struct Entry {
    std::array<GlobalIndex, 4> nodes;
    GlobalIndex cell;
    int face;
  };
  std::vector<Entry> entries;
  entries.reserve(6 * static_cast<std::size_t>(mesh.cell_count()));
  for (GlobalIndex cell = 0; cell < mesh.cell_count(); ++cell)
    for (int face = 0; face < 6; ++face) entries.push_back({face_nodes(mesh, cell, face), cell, face});
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return std::tie(a.nodes, a.cell, a.face) < std::tie(b.nodes, b.cell, b.face);
  });
  std::vector<mesh::Face> faces;
  for (std::size_t i = 0; i < entries.size();) {
    std::size_t end = i + 1;
    while (end < entries.size() && entries[end].nodes == entries[i].nodes) ++end;
    if (end - i > 2)
      throw Error(ExitCode::geometry,
                  log::format("%d cells share one face, for example those at %s and %s; remove the cells that overlap",
                              static_cast<int>(end - i), place_of(mesh, entries[i].cell).c_str(),
                              place_of(mesh, entries[i + 1].cell).c_str()));
    if (end - i == 1) faces.push_back({entries[i].cell, entries[i].face});
    i = end;
  }
  std::sort(faces.begin(), faces.end(), [](const mesh::Face& a, const mesh::Face& b) {
    return std::tie(a.cell, a.face) < std::tie(b.cell, b.face);
  });
  return faces;
}

bool recognise_box(mesh::HexMeshData& mesh) {
  mesh::Box box;
  GlobalIndex nodes = 1, cells = 1;
  for (int d = 0; d < 3; ++d) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (std::size_t n = d; n < mesh.nodes.size(); n += 3) {
      low = std::min(low, mesh.nodes[n]);
      high = std::max(high, mesh.nodes[n]);
    }
    box.coordinates[d] = levels(mesh.nodes, d, 1e-9 * (high - low));
    nodes *= static_cast<GlobalIndex>(box.coordinates[d].size());
    cells *= static_cast<GlobalIndex>(box.coordinates[d].size()) - 1;
    if (nodes > mesh.node_count()) return false;
  }
  if (nodes != mesh.node_count() || cells != mesh.cell_count()) return false;
  const GlobalIndex row = static_cast<GlobalIndex>(box.coordinates[0].size());
  const GlobalIndex plane = row * static_cast<GlobalIndex>(box.coordinates[1].size());
  std::vector<std::array<GlobalIndex, 3>> lattice(mesh.node_count());
  std::vector<char> taken(mesh.node_count(), 0);
  for (GlobalIndex n = 0; n < mesh.node_count(); ++n) {
    for (int d = 0; d < 3; ++d)
      lattice[n][d] = static_cast<GlobalIndex>(level_of(box.coordinates[d], mesh.nodes[3 * n + d]));
    char& mark = taken[lattice[n][0] + row * lattice[n][1] + plane * lattice[n][2]];
    if (mark != 0) return false;
    mark = 1;
  }
  // Each cell: its place in the lattice, and where its own faces look.
  std::vector<GlobalIndex> place(mesh.cell_count());
  std::vector<std::array<int, 6>> face_of(mesh.cell_count());
  std::vector<char> used(mesh.cell_count(), 0);
  for (GlobalIndex cell = 0; cell < mesh.cell_count(); ++cell) {
    std::array<GlobalIndex, 3> low = lattice[mesh.cells[8 * cell]];
    for (int a = 1; a < 8; ++a)
      for (int d = 0; d < 3; ++d) low[d] = std::min(low[d], lattice[mesh.cells[8 * cell + a]][d]);
    int corners = 0;  // bit set: this corner of the lattice cell is there
    for (int a = 0; a < 8; ++a) {
      int bits = 0;
      for (int d = 0; d < 3; ++d) {
        const GlobalIndex step = lattice[mesh.cells[8 * cell + a]][d] - low[d];
        if (step > 1) return false;
        bits |= static_cast<int>(step) << d;
      }
      corners |= 1 << bits;
    }
    if (corners != 255) return false;
    for (int face = 0; face < 6; ++face) {
      int found = -1;
      for (int d = 0; d < 3; ++d) {
        GlobalIndex sum = 0;
        for (const int a : fem::hex8_faces[face]) sum += lattice[mesh.cells[8 * cell + a]][d] - low[d];
        if (sum == 0 || sum == 4) found = found < 0 ? 2 * d + (sum == 4) : 6;
      }
      if (found < 0 || found > 5) return false;
      face_of[cell][face] = found;
    }
    place[cell] = low[0] + (row - 1) * (low[1] + (static_cast<GlobalIndex>(box.coordinates[1].size()) - 1) * low[2]);
    if (used[place[cell]] != 0) return false;
    used[place[cell]] = 1;
  }
  for (auto& [name, faces] : mesh.faces) {
    for (mesh::Face& face : faces) face = {place[face.cell], face_of[face.cell][face.face]};
    std::sort(faces.begin(), faces.end(), [](const mesh::Face& a, const mesh::Face& b) {
      return std::tie(a.cell, a.face) < std::tie(b.cell, b.face);
    });
  }
  for (GlobalIndex n = 0; n < mesh.node_count(); ++n) {
    const GlobalIndex i = n % row, j = n % plane / row, k = n / plane;
    mesh.nodes[3 * n] = box.coordinates[0][i];
    mesh.nodes[3 * n + 1] = box.coordinates[1][j];
    mesh.nodes[3 * n + 2] = box.coordinates[2][k];
  }
  const std::array<Index, 3> counts = box.cells();
  for (GlobalIndex cell = 0; cell < mesh.cell_count(); ++cell) {
    const GlobalIndex i = cell % counts[0], j = cell / counts[0] % counts[1], k = cell / counts[0] / counts[1];
    const GlobalIndex a = i + row * j + plane * k, b = a + plane;
    const std::array<GlobalIndex, 8> corners = {a, a + 1, a + row + 1, a + row, b, b + 1, b + row + 1, b + row};
    std::copy(corners.begin(), corners.end(), mesh.cells.begin() + 8 * cell);
  }
  mesh.box = box;
  return true;
}

}  // namespace fbi::meshgen
