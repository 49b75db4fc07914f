/// Meshes, options and small helpers for the tests of the fluid.
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "fluid/fluid_field.hpp"
#include "fluid/ghosted.hpp"

namespace fbi::fluid::test {

inline std::vector<double> uniform(double from, double to, int cells) {
  std::vector<double> x(cells + 1);
  for (int i = 0; i <= cells; ++i) x[i] = from + (to - from) * i / cells;
  return x;
}

/// Cells grow by `ratio` from one to the next.
inline std::vector<double> graded(double from, double to, int cells, double ratio) {
  std::vector<double> x(cells + 1, from);
  double size = 1, total = 0;
  for (int i = 0; i < cells; ++i, size *= ratio) x[i + 1] = total += size;
  for (int i = 1; i <= cells; ++i) x[i] = from + (to - from) * x[i] / total;
  return x;
}

/// A box mesh; `warp` moves inner nodes (the boundary stays) so that cells become general hexahedra.
inline mesh::HexMesh box_mesh(const Comm& comm, const std::array<std::vector<double>, 3>& x, bool general = false,
                              double warp = 0.0) {
  mesh::HexMeshData data = mesh::make_box(x, general || warp != 0);
  if (warp != 0)
    for (std::size_t n = 0; n < data.nodes.size(); n += 3) {
      double bubble = warp;
      for (int i = 0; i < 3; ++i)
        bubble *= std::sin(M_PI * (data.nodes[n + i] - x[i].front()) / (x[i].back() - x[i].front()));
      const double a = data.nodes[n], b = data.nodes[n + 1], c = data.nodes[n + 2];
      data.nodes[n] += bubble * std::sin(5 * b + c + 1);
      data.nodes[n + 1] += bubble * std::cos(4 * a - c);
      data.nodes[n + 2] += bubble * std::sin(3 * a + 2 * b);
    }
  return mesh::distribute(comm, mesh::chunk_of(comm, data));
}

inline input::VectorExpression expressions(const std::string& x, const std::string& y, const std::string& z) {
  return {input::Expression(x), input::Expression(y), input::Expression(z)};
}

inline BoundaryCondition velocity(const input::VectorExpression& v) {
  BoundaryCondition condition;
  condition.type = BoundaryType::inflow;
  for (int i = 0; i < 3; ++i) condition.velocity[i] = v[i];
  return condition;
}

inline BoundaryCondition of_type(BoundaryType type) {
  BoundaryCondition condition;
  condition.type = type;
  return condition;
}

inline const std::array<std::string, 6> box_faces = {"xmin", "xmax", "ymin", "ymax", "zmin", "zmax"};

/// A reproducible number in [-1, 1] for an unknown, the same on any number of ranks.
inline double noise(GlobalIndex node, int component, int seed) {
  const double s = std::sin(12.9898 * static_cast<double>(node) + 78.233 * component + 37.719 * seed) * 43758.5453;
  return 2 * (s - std::floor(s)) - 1;
}

/// Owned entries from a function of file node number and component.
inline void fill(const mesh::HexMesh& mesh, Vec vector, const std::function<double(GlobalIndex, int)>& f) {
  PetscScalar* array = nullptr;
  FBI_PETSC(VecGetArray(vector, &array));
  for (Index n = 0; n < mesh.owned_nodes; ++n)
    for (int c = 0; c < 4; ++c) array[4 * n + c] = f(mesh.node_id[n], c);
  FBI_PETSC(VecRestoreArray(vector, &array));
}

inline double largest(Vec vector) {
  PetscReal norm = 0;
  FBI_PETSC(VecNorm(vector, NORM_INFINITY, &norm));
  return norm;
}

inline std::vector<double> owned_values(Vec vector) {
  PetscInt n = 0;
  const PetscScalar* array = nullptr;
  FBI_PETSC(VecGetLocalSize(vector, &n));
  FBI_PETSC(VecGetArrayRead(vector, &array));
  std::vector<double> values(array, array + n);
  FBI_PETSC(VecRestoreArrayRead(vector, &array));
  return values;
}

}  // namespace fbi::fluid::test
