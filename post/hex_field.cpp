#include "post/hex_field.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "fem/hex8.hpp"
#include "fem/quadrature.hpp"
#include "io/format.hpp"

namespace fbi::post {
namespace {

constexpr double slack = 1e-7;  // of a reference coordinate
constexpr std::array<std::array<int, 3>, 8> box_corner = {
    {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}};

}  // namespace

Grid Grid::read(const Run& run) {
  const io::File file = io::open_kind(run.paths.mesh(), io::FileKind::mesh);
  if (!file.has("/fluid/nodes"))
    throw Error(ExitCode::usage,
                "run \"" + run.name + "\" has no fluid; l2 compares its fibers with --field centerline");
  Grid grid;
  grid.node_count_ = file.shape("/fluid/nodes")[0];
  grid.cells_ = static_cast<Index>(file.shape("/fluid/cells")[0]);
  if (file.has("/fluid/box")) {
    grid.box_ = {file.read<double>("/fluid/box/x"), file.read<double>("/fluid/box/y"),
                 file.read<double>("/fluid/box/z")};
    grid.volume_ = 1.0;
    for (const std::vector<double>& x : *grid.box_) grid.volume_ *= x.back() - x.front();
    return grid;
  }
  grid.coordinates_ = file.read<double>("/fluid/nodes");
  grid.cell_nodes_ = file.read<std::int32_t>("/fluid/cells");
  const fem::QuadratureRule rule = fem::gauss_legendre(2);
  for (Index c = 0; c < grid.cells_; ++c) {
    const Corners x = grid.corners(c);
    for (const double a : rule.points)
      for (const double b : rule.points)
        for (const double d : rule.points) grid.volume_ += Mat3(x * fem::hex8_gradient(Vec3(a, b, d))).determinant();
  }
  return grid;
}

std::array<Index, 8> Grid::cell_nodes(Index cell) const {
  std::array<Index, 8> nodes;
  if (!box_) {
    std::copy_n(&cell_nodes_[8 * static_cast<std::size_t>(cell)], 8, nodes.begin());
    return nodes;
  }
  const Index nx = static_cast<Index>((*box_)[0].size()), ny = static_cast<Index>((*box_)[1].size());
  const Index i = cell % (nx - 1), j = cell / (nx - 1) % (ny - 1), k = cell / (nx - 1) / (ny - 1);
  const Index first = i + nx * (j + ny * k);
  for (int a = 0; a < 8; ++a) nodes[a] = first + box_corner[a][0] + nx * (box_corner[a][1] + ny * box_corner[a][2]);
  return nodes;
}

Grid::Corners Grid::corners(Index cell) const {
  Corners x;
  if (!box_) {
    const std::array<Index, 8> nodes = cell_nodes(cell);
    for (int a = 0; a < 8; ++a)
      for (int d = 0; d < 3; ++d) x(d, a) = coordinates_[3 * static_cast<std::size_t>(nodes[a]) + d];
    return x;
  }
  const Index nx = static_cast<Index>((*box_)[0].size()) - 1, ny = static_cast<Index>((*box_)[1].size()) - 1;
  const std::array<Index, 3> place = {cell % nx, cell / nx % ny, cell / nx / ny};
  for (int a = 0; a < 8; ++a)
    for (int d = 0; d < 3; ++d) x(d, a) = (*box_)[d][place[d] + box_corner[a][d]];
  return x;
}

bool Grid::operator==(const Grid& other) const {
  return box_ == other.box_ && coordinates_ == other.coordinates_ && cell_nodes_ == other.cell_nodes_;
}

Locator::Locator(const Grid& grid) : grid_(grid) {
  if (grid.is_box()) return;
  std::vector<search::Aabb> boxes(static_cast<std::size_t>(grid.cells()));
  for (Index c = 0; c < grid.cells(); ++c) {
    const Grid::Corners x = grid.corners(c);
    search::Aabb& box = boxes[c];
    for (int a = 0; a < 8; ++a) box.include(x.col(a).data());
    box.inflate(slack * box.size());
  }
  tree_ = search::Tree(boxes);
}

// Newton's method for x = sum N_a(xi) x_a; points far outside leave the cell at once.
bool Locator::inside(Index cell, const Vec3& x, Vec3& xi) const {
  const Grid::Corners corners = grid_.corners(cell);
  const double size = (corners.col(6) - corners.col(0)).norm();
  xi.setZero();
  for (int iteration = 0; iteration < 20; ++iteration) {
    const std::array<double, 8> shape = fem::hex8_shape(xi);
    const Vec3 residual = x - corners * Eigen::Map<const Eigen::Matrix<double, 8, 1>>(shape.data());
    if (residual.squaredNorm() <= 1e-28 * size * size) break;
    const Mat3 jacobian = corners * fem::hex8_gradient(xi);
    const Vec3 step = jacobian.inverse() * residual;
    xi += step;
    if (!(xi.cwiseAbs().maxCoeff() < 3.0)) return false;
    if (step.squaredNorm() <= 1e-30) break;
  }
  return xi.cwiseAbs().maxCoeff() <= 1.0 + slack;
}

Index Locator::find_in_box(const Vec3& x, Vec3& xi) {
  for (int d = 0; d < 3; ++d) {
    const std::vector<double>& nodes = grid_.box()[d];
    const Index last = static_cast<Index>(nodes.size()) - 2;
    Index& at = place_[d];
    if (x[d] < nodes[at] || x[d] > nodes[at + 1])
      at = std::clamp<Index>(static_cast<Index>(std::upper_bound(nodes.begin(), nodes.end(), x[d]) - nodes.begin()) - 1,
                             0, last);
    xi[d] = (2.0 * x[d] - nodes[at] - nodes[at + 1]) / (nodes[at + 1] - nodes[at]);
    if (std::abs(xi[d]) > 1.0 + slack) return -1;
  }
  const Index nx = static_cast<Index>(grid_.box()[0].size()) - 1, ny = static_cast<Index>(grid_.box()[1].size()) - 1;
  return place_[0] + nx * (place_[1] + ny * place_[2]);
}

Index Locator::find(const Vec3& x, Vec3& xi) {
  if (grid_.is_box()) return find_in_box(x, xi);
  if (last_ >= 0 && inside(last_, x, xi)) return last_;
  found_.clear();
  search::Aabb point;
  point.include(x.data());
  tree_.overlapping(point, found_);
  for (const Index cell : found_)
    if (cell != last_ && inside(cell, x, xi)) return last_ = cell;
  return -1;
}

}  // namespace fbi::post
