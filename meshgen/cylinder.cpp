#include "meshgen/cylinder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/error.hpp"

namespace fbi::meshgen {
namespace {

/// Section coordinates (u, v) and the axis w of a cylinder as a right-handed triple, by number of the direction.
struct Frame {
  int u, v, w;
};
Frame frame_of(mesh::Axis axis) {
  switch (axis) {
    case mesh::Axis::x:
      return {1, 2, 0};
    case mesh::Axis::y:
      return {2, 0, 1};
    case mesh::Axis::z:
      break;
  }
  return {0, 1, 2};
}

std::array<double, 2> center_in_frame(const mesh::CylinderParameters& cylinder) {
  if (cylinder.axis == mesh::Axis::y) return {cylinder.center[1], cylinder.center[0]};
  return cylinder.center;
}

/// One direction of the lattice: the block lies between the nodes first and first + cells.
struct Line {
  std::vector<double> x;
  Index first = 0;
};

void append_even(std::vector<double>& x, double begin, double end, Index cells) {
  for (Index i = 0; i < cells; ++i) x.push_back(begin + (end - begin) * i / cells);
}

Line make_line(double origin, double size, double center, double half, Index cells) {
  const double h = 2.0 * half / cells, low = center - half, high = center + half, end = origin + size;
  Line line;
  line.first = std::max<Index>(1, static_cast<Index>(std::lround((low - origin) / h)));
  const Index last = std::max<Index>(1, static_cast<Index>(std::lround((end - high) / h)));
  append_even(line.x, origin, low, line.first);
  append_even(line.x, low, high, cells);
  append_even(line.x, high, end, last);
  line.x.push_back(end);
  return line;
}

/// Shares of the way from the circle to the block, from 0 to 1: about `gap` long in all, geometric from `thinnest` to
/// `thickest`.
std::vector<double> ring_shares(double gap, double thinnest, double thickest) {
  thinnest = std::min(thinnest, 0.5 * gap);
  thickest = std::min(thickest, 0.9 * gap);
  const double growth = std::abs(thickest - thinnest) < 1e-6 * gap ? 1.0 : (gap - thinnest) / (gap - thickest);
  Index rings = std::abs(growth - 1.0) < 1e-9
                    ? static_cast<Index>(std::lround(gap / thinnest))
                    : 1 + static_cast<Index>(std::lround(std::log(thickest / thinnest) / std::log(growth)));
  rings = std::max<Index>(2, rings);
  std::vector<double> share;
  for (Index k = 0; k <= rings; ++k)
    share.push_back(std::abs(growth - 1.0) < 1e-9
                        ? static_cast<double>(k) / rings
                        : std::expm1(k * std::log(growth)) / std::expm1(rings * std::log(growth)));
  share.back() = 1.0;
  return share;
}

/// Nodes and quadrangles of the section; the sides of each quadrangle that lie on a boundary.
struct Section {
  struct Side {
    GlobalIndex cell;
    int side;  // 0 u-, 1 u+, 2 v-, 3 v+ of the cell's own directions
    int wall;  // 0 umin, 1 umax, 2 vmin, 3 vmax, 4 cylinder
  };
  std::vector<std::array<double, 2>> nodes;
  std::vector<std::array<GlobalIndex, 4>> cells;  // counterclockwise
  std::vector<Side> sides;
};

Section make_section(const Line& u, const Line& v, const std::array<double, 2>& center, double half,
                     const mesh::CylinderParameters& cylinder) {
  const Index n = cylinder.around / 4;
  const Index nu = static_cast<Index>(u.x.size()), nv = static_cast<Index>(v.x.size());
  Section section;
  std::vector<GlobalIndex> lattice(static_cast<std::size_t>(nu) * nv, -1);
  const auto inside = [&](Index i, Index first) { return i > first && i < first + n; };
  for (Index j = 0; j < nv; ++j)
    for (Index i = 0; i < nu; ++i) {
      if (inside(i, u.first) && inside(j, v.first)) continue;
      lattice[i + static_cast<std::size_t>(j) * nu] = static_cast<GlobalIndex>(section.nodes.size());
      section.nodes.push_back({u.x[i], v.x[j]});
    }
  const auto at = [&](Index i, Index j) { return lattice[i + static_cast<std::size_t>(j) * nu]; };
  for (Index j = 0; j + 1 < nv; ++j)
    for (Index i = 0; i + 1 < nu; ++i) {
      if (i >= u.first && i < u.first + n && j >= v.first && j < v.first + n) continue;
      const GlobalIndex cell = static_cast<GlobalIndex>(section.cells.size());
      section.cells.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
      if (i == 0) section.sides.push_back({cell, 0, 0});
      if (i + 2 == nu) section.sides.push_back({cell, 1, 1});
      if (j == 0) section.sides.push_back({cell, 2, 2});
      if (j + 2 == nv) section.sides.push_back({cell, 3, 3});
    }
  // Rings. Node j of the outermost one is a node of the lattice, counted from the lower right corner of the block.
  const double along = 2.0 * std::numbers::pi * cylinder.radius / cylinder.around;
  const std::vector<double> share = ring_shares(half - cylinder.radius, cylinder.first * along, 2.0 * half / n);
  const Index rings = static_cast<Index>(share.size()) - 1;
  const auto outer = [&](Index j) {
    const Index side = j / n, k = j % n, i0 = u.first, j0 = v.first;
    return side == 0   ? at(i0 + n, j0 + k)
           : side == 1 ? at(i0 + n - k, j0 + n)
           : side == 2 ? at(i0, j0 + n - k)
                       : at(i0 + k, j0);
  };
  const GlobalIndex first_ring = static_cast<GlobalIndex>(section.nodes.size());
  for (Index k = 0; k < rings; ++k)
    for (Index j = 0; j < cylinder.around; ++j) {
      // Angles of an eighth of the circle, mirrored, so that the mesh is as symmetric as its block.
      const double angle = 2.0 * std::numbers::pi * (j - n / 2) / cylinder.around;
      const std::array<double, 2>& end = section.nodes[outer(j)];
      const double x = center[0] + cylinder.radius * std::cos(angle), y = center[1] + cylinder.radius * std::sin(angle);
      section.nodes.push_back({x + share[k] * (end[0] - x), y + share[k] * (end[1] - y)});
    }
  const auto ring = [&](Index k, Index j) {
    return k == rings ? outer(j % cylinder.around)
                      : first_ring + GlobalIndex{k} * cylinder.around + j % cylinder.around;
  };
  for (Index k = 0; k < rings; ++k)
    for (Index j = 0; j < cylinder.around; ++j) {
      const GlobalIndex cell = static_cast<GlobalIndex>(section.cells.size());
      section.cells.push_back({ring(k, j), ring(k + 1, j), ring(k + 1, j + 1), ring(k, j + 1)});
      if (k == 0) section.sides.push_back({cell, 0, 4});
    }
  return section;
}

}  // namespace

double block_half_width(const mesh::BoxParameters& box, const mesh::CylinderParameters& cylinder) {
  if (cylinder.block > 0.0) return cylinder.block;
  const Frame frame = frame_of(cylinder.axis);
  const std::array<double, 2> center = center_in_frame(cylinder);
  double distance = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 2; ++i) {
    const int d = i == 0 ? frame.u : frame.v;
    distance = std::min({distance, center[i] - box.origin[d], box.origin[d] + box.size[d] - center[i]});
  }
  return std::min(3.0 * cylinder.radius, 0.75 * distance);
}

mesh::HexMeshData make_cylinder_channel(const mesh::BoxParameters& box, const mesh::CylinderParameters& cylinder) {
  const Frame frame = frame_of(cylinder.axis);
  const std::array<double, 2> center = center_in_frame(cylinder);
  const double half = block_half_width(box, cylinder);
  const Index n = cylinder.around / 4;
  const double h = 2.0 * half / n;
  if (box.size[frame.u] / h * (box.size[frame.v] / h) * cylinder.layers > 5e8)
    throw Error(ExitCode::geometry, "the channel has more than 5e8 cells; use fewer cells around the cylinder");
  const Line u = make_line(box.origin[frame.u], box.size[frame.u], center[0], half, n);
  const Line v = make_line(box.origin[frame.v], box.size[frame.v], center[1], half, n);
  const Section section = make_section(u, v, center, half, cylinder);

  mesh::HexMeshData mesh;
  const GlobalIndex plane = static_cast<GlobalIndex>(section.nodes.size());
  for (Index k = 0; k <= cylinder.layers; ++k) {
    const double w = k == cylinder.layers ? box.origin[frame.w] + box.size[frame.w]
                                          : box.origin[frame.w] + box.size[frame.w] * k / cylinder.layers;
    for (const std::array<double, 2>& node : section.nodes) {
      std::array<double, 3> x{};
      x[frame.u] = node[0];
      x[frame.v] = node[1];
      x[frame.w] = w;
      mesh.nodes.insert(mesh.nodes.end(), x.begin(), x.end());
    }
  }
  const char* names[3][2] = {{"xmin", "xmax"}, {"ymin", "ymax"}, {"zmin", "zmax"}};
  const std::array<std::string, 7> walls = {names[frame.u][0], names[frame.u][1], names[frame.v][0], names[frame.v][1],
                                            "cylinder",        names[frame.w][0], names[frame.w][1]};
  const GlobalIndex layer_cells = static_cast<GlobalIndex>(section.cells.size());
  for (Index k = 0; k < cylinder.layers; ++k) {
    for (const std::array<GlobalIndex, 4>& cell : section.cells) {
      for (const GlobalIndex level : {GlobalIndex{k}, GlobalIndex{k} + 1})
        for (const GlobalIndex node : cell) mesh.cells.push_back(node + level * plane);
    }
    for (const Section::Side& side : section.sides)
      mesh.faces[walls[side.wall]].push_back({side.cell + k * layer_cells, side.side});
  }
  for (GlobalIndex cell = 0; cell < layer_cells; ++cell) {
    mesh.faces[walls[5]].push_back({cell, 4});
    mesh.faces[walls[6]].push_back({cell + (cylinder.layers - 1) * layer_cells, 5});
  }
  return mesh;
}

}  // namespace fbi::meshgen
