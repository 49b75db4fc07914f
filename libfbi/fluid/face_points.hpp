/// Integration points, normals and shape functions on a face of a hexahedron.
#pragma once

#include <array>

#include "mesh/hex_mesh.hpp"

namespace fbi::fluid {

/// The 2 x 2 Gauss points of a face: int N_a n is exact on every face, warped ones included.
struct FacePoints {
  std::array<std::array<double, 4>, 4> shape;  ///< N_a, shape=(points,4)
  std::array<Vec3, 4> position;                ///< [length]
  std::array<Vec3, 4> normal;                  ///< unit normals, outwards
  std::array<double, 4> weight;                ///< [length^2]

  /// int N_a n [length^2].
  Vec3 area_vector(int a) const {
    Vec3 sum = Vec3::Zero();
    for (int q = 0; q < 4; ++q) sum += weight[q] * shape[q][a] * normal[q];
    return sum;
  }
};

/// Local node at corner a of a face.
Index face_node(const mesh::HexMesh& mesh, const mesh::HexMesh::LocalFace& face, int a);
FacePoints face_points(const mesh::HexMesh& mesh, const mesh::HexMesh::LocalFace& face);

/// Axis of a unit normal, or -1 when it is not along one.
int axis_of(const Vec3& normal);

}  // namespace fbi::fluid
