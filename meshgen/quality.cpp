#include "meshgen/quality.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <unordered_map>

#include "base/types.hpp"
#include "fem/hex8.hpp"
#include "fem/line_shapes.hpp"
#include "search/tree.hpp"

namespace fbi::meshgen {
namespace {

Vec3 node(const std::vector<double>& values, GlobalIndex n) { return Eigen::Map<const Vec3>(&values[3 * n]); }

/// Point of the element between two nodes at xi.
Vec3 point_at(const mesh::FiberMeshData& fibers, GlobalIndex first, double length, double xi) {
  const std::array<double, 4> h = fem::hermite(xi);
  return h[0] * node(fibers.position, first) + 0.5 * length * h[1] * node(fibers.tangent, first) +
         h[2] * node(fibers.position, first + 1) + 0.5 * length * h[3] * node(fibers.tangent, first + 1);
}

/// True when a cell holds the point, by Newton's method on x(xi) = point from the middle of the cell.
bool holds(const mesh::HexMeshData& mesh, GlobalIndex cell, const Vec3& point) {
  Eigen::Matrix<double, 3, 8> corners;
  for (int a = 0; a < 8; ++a) corners.col(a) = node(mesh.nodes, mesh.cells[8 * cell + a]);
  Vec3 xi = Vec3::Zero();
  for (int iteration = 0; iteration < 40; ++iteration) {
    const std::array<double, 8> shape = fem::hex8_shape(xi);
    const Vec3 residual = point - corners * Eigen::Map<const Eigen::Matrix<double, 8, 1>>(shape.data());
    const Mat3 jacobian = corners * fem::hex8_gradient(xi);
    if (!(jacobian.determinant() > 0.0)) return false;
    Vec3 step = jacobian.inverse() * residual;
    const double length = step.cwiseAbs().maxCoeff();
    if (length > 1.0) step /= length;
    xi += step;
    if (xi.cwiseAbs().maxCoeff() > 4.0) return false;
    if (length < 1e-10) return xi.cwiseAbs().maxCoeff() <= 1.0 + 2e-9;
  }
  return false;
}

/// Squared distance of the segments p + s u and q + t v, s and t in [0, 1].
double squared_distance(const Vec3& p, const Vec3& u, const Vec3& q, const Vec3& v) {
  const Vec3 w = p - q;
  const double a = u.dot(u), b = u.dot(v), c = v.dot(v), d = u.dot(w), e = v.dot(w);
  const auto clamp = [](double x) { return std::clamp(x, 0.0, 1.0); };
  const double determinant = a * c - b * b;
  double s = determinant > 1e-14 * a * c ? clamp((b * e - c * d) / determinant) : 0.0;
  double t = clamp((b * s + e) / c);
  s = clamp((b * t - d) / a);
  t = clamp((b * s + e) / c);
  double best = (w + s * u - t * v).squaredNorm();
  // Parallel segments are nearest at an end, too.
  for (const double end : {0.0, 1.0}) {
    best = std::min(best, (w + end * u - clamp((b * end + e) / c) * v).squaredNorm());
    best = std::min(best, (w + clamp((b * end - d) / a) * u - end * v).squaredNorm());
  }
  return best;
}

bool same_nodes(const mesh::FiberMeshData& fibers, GlobalIndex a, GlobalIndex b) {
  const GlobalIndex nodes = fibers.first_node[a + 1] - fibers.first_node[a];
  if (nodes != fibers.first_node[b + 1] - fibers.first_node[b]) return false;
  const double tolerance = 1e-9 * fibers.element_length[fibers.first_node[a] - a];
  for (GlobalIndex n = 0; n < nodes; ++n) {
    const Vec3 x = node(fibers.position, fibers.first_node[a] + n);
    if ((x - node(fibers.position, fibers.first_node[b] + n)).norm() > tolerance) return false;
  }
  return true;
}

}  // namespace

double smallest_jacobian(const mesh::HexMeshData& mesh) {
  std::array<Eigen::Matrix<double, 8, 3>, 8> gradients;
  for (int a = 0; a < 8; ++a) {
    gradients[a] = fem::hex8_gradient(Vec3(fem::hex8_corners[a][0], fem::hex8_corners[a][1], fem::hex8_corners[a][2]));
  }
  double smallest = 1.0;
  for (GlobalIndex cell = 0; cell < mesh.cell_count(); ++cell) {
    Eigen::Matrix<double, 3, 8> x;
    for (int a = 0; a < 8; ++a) x.col(a) = node(mesh.nodes, mesh.cells[8 * cell + a]);
    const Mat3 center = x * fem::hex8_gradient(Vec3::Zero());
    const double scale = center.col(0).norm() * center.col(1).norm() * center.col(2).norm();
    if (!(scale > 0.0)) return 0.0;
    for (int a = 0; a < 8; ++a) {
      const Mat3 jacobian = x * gradients[a];
      smallest = std::min(smallest, jacobian.determinant() / scale);
    }
  }
  return smallest;
}

std::vector<OutsideFiber> fibers_outside(const mesh::FiberMeshData& fibers, const mesh::Box& box) {
  constexpr int samples = 16;
  const char* names[3][2] = {{"xmin", "xmax"}, {"ymin", "ymax"}, {"zmin", "zmax"}};
  double low[3], high[3], low_tolerance[3], high_tolerance[3];
  for (int a = 0; a < 3; ++a) {
    const std::vector<double>& x = box.coordinates[a];
    low[a] = x.front();
    high[a] = x.back();
    low_tolerance[a] = 1e-9 * (x[1] - x[0]);
    high_tolerance[a] = 1e-9 * (x[x.size() - 1] - x[x.size() - 2]);
  }
  std::vector<OutsideFiber> result;
  for (GlobalIndex fiber = 0; fiber < fibers.fiber_count(); ++fiber) {
    OutsideFiber found;
    found.fiber = fiber;
    double outside = 0.0, total = 0.0;
    for (GlobalIndex n = fibers.first_node[fiber]; n + 1 < fibers.first_node[fiber + 1]; ++n) {
      const double length = fibers.element_length[n - fiber];
      double excess_before = 0.0;  // > 0 outside
      Vec3 before = Vec3::Zero();
      for (int i = 0; i <= samples; ++i) {
        const Vec3 x = point_at(fibers, n, length, 2.0 * i / samples - 1.0);
        double excess = -std::numeric_limits<double>::infinity();
        for (int a = 0; a < 3; ++a) {
          const double beyond[2] = {low[a] - x[a], x[a] - high[a]};
          const double tolerance[2] = {low_tolerance[a], high_tolerance[a]};
          for (int side = 0; side < 2; ++side) {
            excess = std::max(excess, beyond[side] - tolerance[side]);
            if (beyond[side] > tolerance[side] && beyond[side] > found.distance) {
              found.distance = beyond[side];
              found.face = names[a][side];
            }
          }
        }
        if (i > 0) {
          const double piece = (x - before).norm();
          const double larger = std::max(excess, excess_before), smaller = std::min(excess, excess_before);
          total += piece;
          if (larger > 0.0) outside += smaller >= 0.0 ? piece : piece * larger / (larger - smaller);
        }
        excess_before = excess;
        before = x;
      }
    }
    if (found.face.empty()) continue;
    found.share = outside / total;
    result.push_back(found);
  }
  return result;
}

std::vector<OutsideFiber> fibers_outside(const mesh::FiberMeshData& fibers, const mesh::HexMeshData& mesh) {
  constexpr int samples = 16;
  std::vector<OutsideFiber> result;
  if (fibers.fiber_count() == 0) return result;
  std::vector<search::Aabb> boxes(mesh.cell_count());
  for (GlobalIndex cell = 0; cell < mesh.cell_count(); ++cell) {
    for (int a = 0; a < 8; ++a) boxes[cell].include(&mesh.nodes[3 * mesh.cells[8 * cell + a]]);
    boxes[cell].inflate(1e-8 * boxes[cell].size());
  }
  const search::Tree tree(boxes);
  std::vector<Index> near;
  const auto inside = [&](const Vec3& x) {
    search::Aabb point;
    point.include(x.data());
    near.clear();
    tree.overlapping(point, near);
    return std::any_of(near.begin(), near.end(), [&](Index cell) { return holds(mesh, cell, x); });
  };
  for (GlobalIndex fiber = 0; fiber < fibers.fiber_count(); ++fiber) {
    OutsideFiber found;
    found.fiber = fiber;
    GlobalIndex out = 0, all = 0;
    for (GlobalIndex n = fibers.first_node[fiber]; n + 1 < fibers.first_node[fiber + 1]; ++n) {
      for (int i = 0; i <= samples; ++i) {
        const Vec3 x = point_at(fibers, n, fibers.element_length[n - fiber], 2.0 * i / samples - 1.0);
        ++all;
        if (inside(x)) continue;
        if (out++ == 0) found.place = x;
      }
    }
    found.share = static_cast<double>(out) / static_cast<double>(all);
    if (out > 0) result.push_back(found);
  }
  return result;
}

Crossings crossing_fibers(const mesh::FiberMeshData& fibers, const std::vector<double>& radius) {
  struct Segment {
    GlobalIndex fiber;
    Vec3 start, direction;
  };
  std::vector<Segment> segments;
  double bin = 0.0;
  for (GlobalIndex fiber = 0; fiber < fibers.fiber_count(); ++fiber) {
    for (GlobalIndex n = fibers.first_node[fiber]; n + 1 < fibers.first_node[fiber + 1]; ++n) {
      const Vec3 start = node(fibers.position, n);
      segments.push_back({fiber, start, node(fibers.position, n + 1) - start});
      bin = std::max(bin, segments.back().direction.norm() / 4 + 2 * radius[fiber]);
    }
  }
  // Every segment is entered into the bins its box touches, grown by its radius; only those in a common bin are
  // compared.
  const auto key = [](std::int64_t x, std::int64_t y, std::int64_t z) {
    return (x * 73856093) ^ (y * 19349663) ^ (z * 83492791);
  };
  std::unordered_map<std::int64_t, std::vector<Index>> bins;
  Crossings result;
  std::set<std::pair<GlobalIndex, GlobalIndex>> seen;
  const auto fiber_of = [&](GlobalIndex n) {
    return std::upper_bound(fibers.first_node.begin(), fibers.first_node.end(), n) - fibers.first_node.begin() - 1;
  };
  for (const mesh::Joint& joint : fibers.joints) {  // joined fibers are meant to meet
    seen.insert({fiber_of(joint.a), fiber_of(joint.b)});
    seen.insert({fiber_of(joint.b), fiber_of(joint.a)});
  }
  for (std::size_t i = 0; i < segments.size(); ++i) {
    const Segment& segment = segments[i];
    const Vec3 end = segment.start + segment.direction;
    const double margin = radius[segment.fiber] + 1e-9 * bin;
    std::int64_t low[3], high[3];
    for (int a = 0; a < 3; ++a) {
      low[a] = static_cast<std::int64_t>(std::floor((std::min(segment.start[a], end[a]) - margin) / bin));
      high[a] = static_cast<std::int64_t>(std::floor((std::max(segment.start[a], end[a]) + margin) / bin));
    }
    for (std::int64_t x = low[0]; x <= high[0]; ++x) {
      for (std::int64_t y = low[1]; y <= high[1]; ++y) {
        for (std::int64_t z = low[2]; z <= high[2]; ++z) {
          std::vector<Index>& members = bins[key(x, y, z)];
          for (const Index other_index : members) {
            const Segment& other = segments[other_index];
            if (other.fiber == segment.fiber) continue;
            const double reach = radius[segment.fiber] + radius[other.fiber] + 1e-9 * bin;
            if (squared_distance(segment.start, segment.direction, other.start, other.direction) >= reach * reach)
              continue;
            if (!seen.insert({other.fiber, segment.fiber}).second) continue;
            result.example[0] = other.fiber;
            result.example[1] = segment.fiber;
            (same_nodes(fibers, other.fiber, segment.fiber) ? result.coincident : result.pairs) += 1;
          }
          if (members.empty() || members.back() != static_cast<Index>(i)) members.push_back(static_cast<Index>(i));
        }
      }
    }
  }
  return result;
}

}  // namespace fbi::meshgen
