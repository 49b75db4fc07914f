/// Meshes with curved and leaning walls for the tests of boundary conditions and forces.
#pragma once

#include <cmath>
#include <functional>

#include "unit/fluid/fluid_fixture.hpp"

namespace fbi::fluid::test {

/// A general box mesh whose nodes are moved by `map`; the face sets keep the names xmin ... zmax.
inline mesh::HexMesh mapped_mesh(const Comm& comm, const std::array<std::vector<double>, 3>& x,
                                 const std::function<Vec3(const Vec3&)>& map) {
  mesh::HexMeshData data = mesh::make_box(x, true);
  for (std::size_t n = 0; n < data.nodes.size(); n += 3)
    Eigen::Map<Vec3>(&data.nodes[n]) = map(Eigen::Map<const Vec3>(&data.nodes[n]));
  return mesh::distribute(comm, mesh::chunk_of(comm, data));
}

/// (angle from pi, radius, z) to a sector of a ring: xmin, xmax are its ends, ymin, ymax its curved walls.
inline Vec3 bend(const Vec3& x) { return {-x[1] * std::cos(x[0]), x[1] * std::sin(x[0]), x[2]}; }

/// A whole ring between the radii (one layer of cells along z): face sets inner, outer, zmin, zmax.
inline mesh::HexMeshData ring(const std::vector<double>& radius, int around, double height) {
  mesh::HexMeshData data;
  const int layers = static_cast<int>(radius.size());
  for (int k = 0; k < 2; ++k)
    for (const double r : radius)
      for (int i = 0; i < around; ++i) {
        const double angle = 2 * M_PI * i / around;
        for (const double x : {r * std::cos(angle), r * std::sin(angle), k * height}) data.nodes.push_back(x);
      }
  const auto node = [&](int i, int j, int k) {
    return static_cast<GlobalIndex>((k * layers + j) * around + i % around);
  };
  for (int j = 0; j + 1 < layers; ++j)
    for (int i = 0; i < around; ++i) {
      const GlobalIndex cell = data.cell_count();
      for (int k = 0; k < 2; ++k)  // radius first, then angle: a right-handed cell
        for (const GlobalIndex n : {node(i, j, k), node(i, j + 1, k), node(i + 1, j + 1, k), node(i + 1, j, k)})
          data.cells.push_back(n);
      if (j == 0) data.faces["inner"].push_back({cell, 0});
      if (j + 2 == layers) data.faces["outer"].push_back({cell, 1});
      data.faces["zmin"].push_back({cell, 4});
      data.faces["zmax"].push_back({cell, 5});
    }
  return data;
}

}  // namespace fbi::fluid::test
