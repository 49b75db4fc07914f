/// Points in trilinear cells: the inverse of the map x(xi) = sum_a N_a(xi) x_a.
#pragma once

#include "base/types.hpp"
#include "mesh/hex_mesh.hpp"

namespace fbi::coupling {

/// Half the reference edge (2) times "1e-9 cell sizes" (SPEC section 3): a point with |xi_i| <= 1 + this is inside.
inline constexpr double inside_tolerance = 2e-9;

/// One cell by its corners. `aligned`: its edges are exactly parallel to the axes, so that the inverse map is closed
/// form.
struct Cell {
  Eigen::Matrix<double, 3, 8> corners;  ///< VTK order [length]
  bool aligned = false;
  double size = 0.0;  ///< largest extent along an axis [length]
};

Cell make_cell(const Eigen::Matrix<double, 3, 8>& corners);
Cell make_cell(const mesh::HexMesh& mesh, Index cell);

/// Finds xi with x(xi) = point: closed form for aligned cells, else Newton with limited steps from the xi passed in
/// (pass zero when nothing better is known).
/// @param jacobian_inverse  dxi_i/dx_j at the result, shape=(3,3) [1/length]; may be null
/// Returns false when Newton does not converge or leaves [-8, 8]^3: the point is far from the cell.
bool project(const Cell& cell, const Vec3& point, Vec3& xi, Mat3* jacobian_inverse = nullptr);

/// True when max |xi_i| <= 1 + inside_tolerance.
bool is_inside(const Vec3& xi);

}  // namespace fbi::coupling
