#include "coupling/face_crossings.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "fem/hex8.hpp"

namespace fbi::coupling {

namespace {

/// phi(x) = 1 - sign xi_k(r(x)): positive on the inner side of the face.
class Distance {
 public:
  Distance(const Curve& curve, const Cell& cell, int face)
      : curve_(curve), cell_(cell), direction_(face / 2), sign_(face % 2 == 0 ? -1.0 : 1.0) {}

  struct Sample {
    double x, value, slope;
    bool valid;
  };
  Sample at(double x) const {
    Vec3 xi = Vec3::Zero();
    Mat3 inverse;
    if (!project(cell_, curve_.point(x), xi, &inverse)) return {x, 0.0, 0.0, false};
    return {x, 1.0 - sign_ * xi[direction_], -sign_ * inverse.row(direction_).dot(curve_.slope(x)), true};
  }

 private:
  const Curve& curve_;
  const Cell& cell_;
  int direction_;
  double sign_;
};

using Sample = Distance::Sample;
constexpr double on_face = 0.1 * inside_tolerance;
constexpr double smallest_interval = 1e-6;

/// Root between samples of opposite sign: Newton inside a shrinking bracket.
double bracketed_root(const Distance& distance, Sample a, Sample b) {
  const bool rising = b.value > a.value;
  double low = a.x, high = b.x;
  double root = low + (high - low) * (a.value / (a.value - b.value));
  for (int iteration = 0; iteration < 100; ++iteration) {
    const Sample s = distance.at(root);
    if (!s.valid || s.value == 0.0) break;
    ((s.value < 0.0) == rising ? low : high) = root;
    double next = 0.5 * (low + high);
    if (std::abs(s.value) < std::abs(s.slope) * (high - low)) {
      const double newton = root - s.value / s.slope;
      if (newton > low && newton < high) next = newton;
    }
    const double step = std::abs(next - root);
    root = next;
    if (step <= 1e-15) break;
  }
  return root;
}

void search_interval(const Distance& distance, const Sample& a, const Sample& b, std::vector<double>& roots) {
  const double width = b.x - a.x;
  const bool valid = a.valid && b.valid, crosses = valid && (a.value < 0.0) != (b.value < 0.0);
  if (width < smallest_interval) {
    if (crosses) roots.push_back(bracketed_root(distance, a, b));
    return;
  }
  const Sample middle = distance.at(0.5 * (a.x + b.x));
  if (!valid && !middle.valid && width < 1e-2) return;  // far from the cell, where the map has no inverse
  if (valid && middle.valid) {
    const double p[4] = {a.value, a.value + width / 3.0 * a.slope, b.value - width / 3.0 * b.slope, b.value};
    // The interpolation error is largest at the middle, up to higher derivatives: twice that is the margin.
    const double margin = 2.0 * std::abs(0.125 * (p[0] + 3.0 * p[1] + 3.0 * p[2] + p[3]) - middle.value) + 1e-14;
    const double low = *std::min_element(p, p + 4), high = *std::max_element(p, p + 4);
    if (low > margin || high < -margin) return;
    if (high < on_face - margin && low > margin - on_face) return;
    const double d[3] = {p[1] - p[0], p[2] - p[1], p[3] - p[2]};
    const double slowest = std::min({std::abs(d[0]), std::abs(d[1]), std::abs(d[2])});
    if ((d[0] > 0.0) == (d[1] > 0.0) && (d[1] > 0.0) == (d[2] > 0.0) && slowest > 4.0 * margin) {  // monotone
      if (crosses) roots.push_back(bracketed_root(distance, a, b));
      return;
    }
  }
  search_interval(distance, a, middle, roots);
  search_interval(distance, middle, b, roots);
}

}  // namespace

FacePlanes face_planes(const Cell& cell, int face) {
  const std::array<int, 4>& nodes = fem::hex8_faces[face];
  const Vec3 first = cell.corners.col(nodes[2]) - cell.corners.col(nodes[0]);
  const Vec3 second = cell.corners.col(nodes[3]) - cell.corners.col(nodes[1]);
  FacePlanes planes;
  planes.normal = first.cross(second).normalized();
  const Eigen::Matrix<double, 1, 8> level = planes.normal.transpose() * cell.corners;
  planes.low = planes.high = level[nodes[0]];
  for (const int node : nodes) {
    planes.low = std::min(planes.low, level[node]);
    planes.high = std::max(planes.high, level[node]);
  }
  planes.outermost = level.maxCoeff();
  planes.margin = inside_tolerance * cell.size;
  planes.warped = planes.high - planes.low > 1e-14 * (cell.size + level.cwiseAbs().maxCoeff());
  return planes;
}

void warped_face_crossings(const Curve& curve, const Cell& cell, int face, double begin, double end,
                           std::vector<double>& roots) {
  const Distance distance(curve, cell, face);
  search_interval(distance, distance.at(begin), distance.at(end), roots);
}

}  // namespace fbi::coupling
