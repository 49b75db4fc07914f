#include "mesh/hex_mesh.hpp"

namespace fbi::mesh {

HexMeshData make_box(const std::array<std::vector<double>, 3>& coordinates, bool general) {
  const Box box{coordinates};
  const std::array<Index, 3> n = box.cells();
  const GlobalIndex row = n[0] + 1, plane = row * (n[1] + 1);
  HexMeshData mesh;
  mesh.nodes.reserve(static_cast<std::size_t>(3 * plane * (n[2] + 1)));
  for (const double z : coordinates[2])
    for (const double y : coordinates[1])
      for (const double x : coordinates[0]) mesh.nodes.insert(mesh.nodes.end(), {x, y, z});
  mesh.cells.reserve(8 * static_cast<std::size_t>(n[0]) * n[1] * n[2]);
  std::array<std::vector<Face>*, 6> sides = {&mesh.faces["xmin"], &mesh.faces["xmax"], &mesh.faces["ymin"],
                                             &mesh.faces["ymax"], &mesh.faces["zmin"], &mesh.faces["zmax"]};
  GlobalIndex cell = 0;
  for (Index k = 0; k < n[2]; ++k)
    for (Index j = 0; j < n[1]; ++j)
      for (Index i = 0; i < n[0]; ++i, ++cell) {
        const GlobalIndex a = i + j * row + k * plane, b = a + plane;
        mesh.cells.insert(mesh.cells.end(), {a, a + 1, a + row + 1, a + row, b, b + 1, b + row + 1, b + row});
        const std::array<Index, 3> at = {i, j, k};
        for (int axis = 0; axis < 3; ++axis) {
          if (at[axis] == 0) sides[2 * axis]->push_back({cell, 2 * axis});
          if (at[axis] == n[axis] - 1) sides[2 * axis + 1]->push_back({cell, 2 * axis + 1});
        }
      }
  if (!general) mesh.box = box;
  return mesh;
}

}  // namespace fbi::mesh
