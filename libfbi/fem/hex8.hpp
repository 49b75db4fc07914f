/// Trilinear hexahedron: shape functions on the reference cube [-1,1]^3.
#pragma once

#include <array>

#include "base/types.hpp"

namespace fbi::fem {

/// Reference corner signs (xi, eta, zeta) of the eight nodes, VTK order.
inline constexpr std::array<std::array<double, 3>, 8> hex8_corners = {{{-1, -1, -1},
                                                                       {1, -1, -1},
                                                                       {1, 1, -1},
                                                                       {-1, 1, -1},
                                                                       {-1, -1, 1},
                                                                       {1, -1, 1},
                                                                       {1, 1, 1},
                                                                       {-1, 1, 1}}};

/// Nodes of the six faces (0 xi=-1, 1 xi=+1, 2 eta=-1, 3 eta=+1, 4 zeta=-1, 5 zeta=+1), ordered so that the normal given by the
/// right-hand rule points outwards.
inline constexpr std::array<std::array<int, 4>, 6> hex8_faces = {
    {{0, 4, 7, 3}, {1, 2, 6, 5}, {0, 1, 5, 4}, {3, 7, 6, 2}, {0, 3, 2, 1}, {4, 5, 6, 7}}};

/// N_a(xi), shape=(8).
inline std::array<double, 8> hex8_shape(const Vec3& xi) {
  std::array<double, 8> n;
  for (int a = 0; a < 8; ++a)
    n[a] = 0.125 * (1 + hex8_corners[a][0] * xi[0]) * (1 + hex8_corners[a][1] * xi[1]) * (1 + hex8_corners[a][2] * xi[2]);
  return n;
}

/// dN_a/dxi_i, shape=(8,3).
inline Eigen::Matrix<double, 8, 3> hex8_gradient(const Vec3& xi) {
  Eigen::Matrix<double, 8, 3> g;
  for (int a = 0; a < 8; ++a) {
    const double x = 1 + hex8_corners[a][0] * xi[0], y = 1 + hex8_corners[a][1] * xi[1], z = 1 + hex8_corners[a][2] * xi[2];
    g(a, 0) = 0.125 * hex8_corners[a][0] * y * z;
    g(a, 1) = 0.125 * hex8_corners[a][1] * x * z;
    g(a, 2) = 0.125 * hex8_corners[a][2] * x * y;
  }
  return g;
}

}  // namespace fbi::fem
