#include "coupling/segmentation.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "coupling/face_crossings.hpp"

namespace fbi::coupling {

namespace {

/// Cuts of one element: collected, then sorted with near copies dropped.
class Cuts {
 public:
  Cuts() { x_ = {-1.0, 1.0}; }
  void add(double x) {
    if (x > -1.0 && x < 1.0) x_.push_back(x);
  }
  void add(const MonotonePieces& pieces, double level) {
    double roots[3];
    const int found = pieces.crossings(level, roots);
    for (int i = 0; i < found; ++i) add(roots[i]);
  }
  /// Ascending from exactly -1 to exactly 1, neighbors more than cut_tolerance apart.
  const std::vector<double>& sorted() {
    std::sort(x_.begin(), x_.end());
    std::size_t kept = 1;
    for (std::size_t i = 1; i + 1 < x_.size(); ++i)
      if (x_[i] - x_[kept - 1] > cut_tolerance && 1.0 - x_[i] > cut_tolerance) x_[kept++] = x_[i];
    x_.resize(kept);
    x_.push_back(1.0);
    return x_;
  }

 private:
  std::vector<double> x_;
};

bool holds(const Curve& curve, const Cell& cell, double x) {
  Vec3 xi = Vec3::Zero();
  return project(cell, curve.point(x), xi) && is_inside(xi);
}

/// The farthest x beyond `end` in `direction` that is still inside, by steps that grow from 1e-11 to 1e-3.
double reach(const Curve& curve, const Cell& cell, double end, double direction) {
  double reached = end;
  for (double step = 1e-11; step < 1e-3; step *= 10.0) {
    const double x = std::clamp(end + direction * step, -1.0, 1.0);
    if (!holds(curve, cell, x)) break;
    reached = x;
    if (std::abs(x) == 1.0) break;
  }
  return reached;
}

void append(std::vector<Segment>& segments, GlobalIndex cell, double begin, double end) {
  if (!segments.empty() && segments.back().cell == cell)
    segments.back().end = end;
  else
    segments.push_back({cell, begin, end});
}

/// std::upper_bound of ascending planes: a few steps from where it would be were they even, then bisection.
std::vector<double>::const_iterator first_above(const std::vector<double>& planes, double x) {
  constexpr int most_steps = 3;
  const double last = static_cast<double>(planes.size() - 1);
  const double guess = last * (x - planes.front()) / (planes.back() - planes.front());
  auto at = planes.begin() + (guess > 0.0 ? static_cast<std::ptrdiff_t>(std::min(guess, last)) : 0);
  for (int step = 0; step < most_steps; ++step) {
    if (at != planes.begin() && *(at - 1) > x)
      --at;
    else if (at != planes.end() && *at <= x)
      ++at;
    else
      return at;
  }
  return std::upper_bound(planes.begin(), planes.end(), x);
}

}  // namespace

void claim_parts(const Curve& curve, const Cell& cell, GlobalIndex id, std::vector<Claim>& claims) {
  // 1. Crossings with planes that bound the cell and with those that bound each warped face.
  std::array<FacePlanes, 6> planes;
  Cuts cuts;
  for (int face = 0; face < 6; ++face) {
    planes[face] = face_planes(cell, face);
    const MonotonePieces along(curve.along(planes[face].normal));
    if (along.low() > planes[face].outermost + planes[face].margin) return;
    cuts.add(along, planes[face].outermost);
    if (planes[face].high < planes[face].outermost) cuts.add(along, planes[face].high);
    if (planes[face].warped) cuts.add(along, planes[face].low);
  }
  // 2. Crossings with warped faces, only where the curve is between the planes of such a face and near the cell.
  const std::vector<double> coarse = cuts.sorted();
  Cuts fine;
  for (std::size_t i = 0; i + 1 < coarse.size(); ++i) {
    fine.add(coarse[i]);
    const Vec3 middle = curve.point(0.5 * (coarse[i] + coarse[i + 1]));
    bool near = true;
    for (int face = 0; face < 6 && near; ++face)
      near = planes[face].normal.dot(middle) <= planes[face].outermost + planes[face].margin;
    if (!near) continue;
    for (int face = 0; face < 6; ++face) {
      const double level = planes[face].normal.dot(middle);
      if (!planes[face].warped || level < planes[face].low || level > planes[face].high) continue;
      std::vector<double> roots;
      warped_face_crossings(curve, cell, face, coarse[i], coarse[i + 1], roots);
      for (const double x : roots) fine.add(x);
    }
  }
  // 3. Inside or not, by midpoints; neighbors join.
  const std::vector<double>& x = fine.sorted();
  bool open = false;
  Claim claim{id, 0, 0, 0, 0};
  for (std::size_t i = 0; i + 1 < x.size(); ++i) {
    if (holds(curve, cell, 0.5 * (x[i] + x[i + 1]))) {
      if (!open) claim.begin = x[i];
      claim.end = x[i + 1];
      open = true;
    } else if (open) {
      claims.push_back(claim);
      open = false;
    }
    if (open && i + 2 == x.size()) claims.push_back(claim);
  }
  for (auto c = claims.rbegin(); c != claims.rend() && c->cell == id; ++c) {
    c->reach_begin = c->begin > -1.0 ? reach(curve, cell, c->begin, -1.0) : -1.0;
    c->reach_end = c->end < 1.0 ? reach(curve, cell, c->end, 1.0) : 1.0;
  }
}

void resolve(const std::vector<Claim>& claims, std::vector<Segment>& segments) {
  Cuts cuts;
  for (const Claim& claim : claims) {
    cuts.add(claim.begin);
    cuts.add(claim.end);
  }
  const std::vector<double>& x = cuts.sorted();
  segments.clear();
  for (std::size_t i = 0; i + 1 < x.size(); ++i) {
    const double middle = 0.5 * (x[i] + x[i + 1]);
    GlobalIndex holder = -1, neighbor = -1;
    for (const Claim& claim : claims) {
      if (claim.begin <= middle && middle <= claim.end && (holder < 0 || claim.cell < holder)) holder = claim.cell;
      if (claim.reach_begin <= x[i] + cut_tolerance && claim.reach_end >= x[i + 1] - cut_tolerance &&
          (neighbor < 0 || claim.cell < neighbor))
        neighbor = claim.cell;
    }
    append(segments, holder >= 0 ? holder : neighbor, x[i], x[i + 1]);
  }
}

void cut_in_box(const Curve& curve, const mesh::Box& box, std::vector<Segment>& segments) {
  Cuts cuts;
  for (int i = 0; i < 3; ++i) {
    const std::vector<double>& planes = box.coordinates[i];
    const MonotonePieces pieces(curve.component[i]);
    const auto last = first_above(planes, pieces.high());
    auto plane = first_above(planes, pieces.low());
    while (plane != planes.begin() && *(plane - 1) == pieces.low()) --plane;
    for (; plane < last; ++plane) cuts.add(pieces, *plane);
  }
  const std::vector<double>& x = cuts.sorted();
  segments.clear();
  for (std::size_t s = 0; s + 1 < x.size(); ++s)
    append(segments, cell_in_box(box, curve.point(0.5 * (x[s] + x[s + 1]))), x[s], x[s + 1]);
}

GlobalIndex cell_in_box(const mesh::Box& box, const Vec3& point) {
  const std::array<Index, 3> cells = box.cells();
  std::array<GlobalIndex, 3> at;
  bool inside = true;
  for (int i = 0; i < 3; ++i) {
    const std::vector<double>& planes = box.coordinates[i];
    const auto above = first_above(planes, point[i]);
    const GlobalIndex cell = std::clamp<GlobalIndex>(above - planes.begin() - 1, 0, cells[i] - 1);
    const auto position = [&](GlobalIndex c) {  // xi in cell c
      return 2.0 * ((point[i] - planes[c]) / (planes[c + 1] - planes[c])) - 1.0;
    };
    inside = inside && std::abs(position(cell)) <= 1.0 + inside_tolerance;
    at[i] = cell > 0 && std::abs(position(cell - 1)) <= 1.0 + inside_tolerance ? cell - 1 : cell;
  }
  return inside ? at[0] + cells[0] * (at[1] + cells[1] * at[2]) : -1;
}

}  // namespace fbi::coupling
