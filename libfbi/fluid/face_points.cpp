#include "fluid/face_points.hpp"

#include <Eigen/Geometry>
#include <cmath>

#include "fem/hex8.hpp"

namespace fbi::fluid {

Index face_node(const mesh::HexMesh& mesh, const mesh::HexMesh::LocalFace& face, int a) {
  return mesh.cells[8 * static_cast<std::size_t>(face.cell) + fem::hex8_faces[face.face][a]];
}

FacePoints face_points(const mesh::HexMesh& mesh, const mesh::HexMesh::LocalFace& face) {
  FacePoints result;
  std::array<Vec3, 4> x;
  for (int a = 0; a < 4; ++a) x[a] = Eigen::Map<const Vec3>(mesh.node(face_node(mesh, face, a)));
  const double g = 1 / std::sqrt(3.0);
  for (int q = 0; q < 4; ++q) {
    const double s = q == 0 || q == 3 ? -g : g, t = q < 2 ? -g : g;
    const double corner[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    Vec3 along_s = Vec3::Zero(), along_t = Vec3::Zero();
    result.position[q].setZero();
    for (int a = 0; a < 4; ++a) {
      result.shape[q][a] = 0.25 * (1 + corner[a][0] * s) * (1 + corner[a][1] * t);
      result.position[q] += result.shape[q][a] * x[a];
      along_s += 0.25 * corner[a][0] * (1 + corner[a][1] * t) * x[a];
      along_t += 0.25 * corner[a][1] * (1 + corner[a][0] * s) * x[a];
    }
    const Vec3 normal = along_s.cross(along_t);
    result.weight[q] = normal.norm();
    result.normal[q] = normal / result.weight[q];
  }
  return result;
}

int axis_of(const Vec3& normal) {
  for (int i = 0; i < 3; ++i)
    if (std::abs(normal[i]) > 1 - 1e-9) return i;
  return -1;
}

}  // namespace fbi::fluid
