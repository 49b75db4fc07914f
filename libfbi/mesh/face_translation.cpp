#include "mesh/face_translation.hpp"

#include "fem/hex8.hpp"

namespace fbi::mesh {

Vec3 face_translation(const HexMesh& mesh, const std::string& from, const std::string& to) {
  double sums[8] = {};
  const std::string* names[2] = {&from, &to};
  for (int side = 0; side < 2; ++side)
    for (const HexMesh::LocalFace& face : mesh.faces.at(*names[side]))
      for (const int corner : fem::hex8_faces[face.face]) {
        const double* x = mesh.node(mesh.cells[8 * static_cast<std::size_t>(face.cell) + corner]);
        for (int i = 0; i < 3; ++i) sums[4 * side + i] += x[i];
        sums[4 * side + 3] += 1.0;
      }
  mesh.comm.sum(sums, 8);
  Vec3 result;
  for (int i = 0; i < 3; ++i) result[i] = sums[4 + i] / sums[7] - sums[i] / sums[3];
  return result;
}

}  // namespace fbi::mesh
