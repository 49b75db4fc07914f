#include "coupling/projection.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "fem/hex8.hpp"

namespace fbi::coupling {

namespace {

bool is_aligned(const Eigen::Matrix<double, 3, 8>& corners) {
  for (int a = 0; a < 8; ++a)
    for (int i = 0; i < 3; ++i)
      if (corners(i, a) != corners(i, fem::hex8_corners[a][i] < 0 ? 0 : 6)) return false;
  return true;
}

}  // namespace

Cell make_cell(const Eigen::Matrix<double, 3, 8>& corners) {
  Cell cell;
  cell.corners = corners;
  cell.aligned = is_aligned(corners);
  cell.size = (corners.rowwise().maxCoeff() - corners.rowwise().minCoeff()).maxCoeff();
  return cell;
}

Cell make_cell(const mesh::HexMesh& mesh, Index cell) {
  if (mesh.box) {
    const std::array<Index, 3> cells = mesh.box->cells();
    GlobalIndex rest = mesh.cell_id[cell];
    Cell result;
    result.aligned = true;
    for (int i = 0; i < 3; ++i) {
      const double* ends = &mesh.box->coordinates[i][static_cast<std::size_t>(rest % cells[i])];
      rest /= cells[i];
      for (int a = 0; a < 8; ++a) result.corners(i, a) = ends[fem::hex8_corners[a][i] < 0 ? 0 : 1];
      result.size = std::max(result.size, ends[1] - ends[0]);
    }
    return result;
  }
  Eigen::Matrix<double, 3, 8> corners;
  for (int a = 0; a < 8; ++a) {
    const double* node = mesh.node(mesh.cells[8 * static_cast<std::size_t>(cell) + a]);
    for (int i = 0; i < 3; ++i) corners(i, a) = node[i];
  }
  return make_cell(corners);
}

bool project(const Cell& cell, const Vec3& point, Vec3& xi, Mat3* jacobian_inverse) {
  if (cell.aligned) {
    const Vec3 low = cell.corners.col(0), edge = cell.corners.col(6) - low;
    for (int i = 0; i < 3; ++i) xi[i] = 2.0 * ((point[i] - low[i]) / edge[i]) - 1.0;
    if (jacobian_inverse) *jacobian_inverse = Vec3(2.0 / edge[0], 2.0 / edge[1], 2.0 / edge[2]).asDiagonal();
    return true;
  }
  for (int iteration = 0; iteration < 40; ++iteration) {
    const std::array<double, 8> shape = fem::hex8_shape(xi);
    const Vec3 residual = point - cell.corners * Eigen::Map<const Eigen::Matrix<double, 8, 1>>(shape.data());
    const Mat3 jacobian = cell.corners * fem::hex8_gradient(xi);
    const double determinant = jacobian.determinant();
    if (!(determinant > 1e-12 * cell.size * cell.size * cell.size)) return false;
    const Mat3 inverse = jacobian.inverse();
    Vec3 step = inverse * residual;
    const double length = step.cwiseAbs().maxCoeff();
    if (length > 2.0) step *= 2.0 / length;
    xi += step;
    if (xi.cwiseAbs().maxCoeff() > 8.0) return false;
    if (length < 1e-8) {  // quadratic: what is left is below round-off
      if (jacobian_inverse) *jacobian_inverse = inverse;
      return true;
    }
  }
  return false;
}

bool is_inside(const Vec3& xi) { return xi.cwiseAbs().maxCoeff() <= 1.0 + inside_tolerance; }

}  // namespace fbi::coupling
