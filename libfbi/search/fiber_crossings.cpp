#include "search/fiber_crossings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "search/tree.hpp"

namespace fbi::search {
namespace {

constexpr double straight = 0.01;  ///< part of the sum of radii by which a chord may miss the curve
constexpr double smallest = 1e-9;  ///< of an element's size: what counts as meeting where there are no radii
constexpr int most_halvings = 40;

/// Cubic by its Bezier points. Trivially copyable.
struct Bezier {
  double point[4][3];

  Vec3 at(int i) const { return {point[i][0], point[i][1], point[i][2]}; }
  Aabb box() const {
    Aabb box;
    for (const auto& x : point) box.include(x);
    return box;
  }
  /// The curve is nowhere farther from its chord than this [length].
  double bend() const {
    const Vec3 a = at(0), chord = at(3) - a;
    return std::max((at(1) - a - chord / 3).norm(), (at(2) - a - 2 * chord / 3).norm());
  }
  void halve(Bezier& left, Bezier& right) const {
    for (int i = 0; i < 3; ++i) {
      const double a = point[0][i], b = point[1][i], c = point[2][i], d = point[3][i];
      const double ab = 0.5 * (a + b), bc = 0.5 * (b + c), cd = 0.5 * (c + d);
      const double abc = 0.5 * (ab + bc), bcd = 0.5 * (bc + cd), middle = 0.5 * (abc + bcd);
      const double to_left[4] = {a, ab, abc, middle}, to_right[4] = {middle, bcd, cd, d};
      for (int k = 0; k < 4; ++k) {
        left.point[k][i] = to_left[k];
        right.point[k][i] = to_right[k];
      }
    }
  }
};

/// One element of a fiber. Trivially copyable: it travels between ranks.
struct Element {
  GlobalIndex fiber;  ///< in the file
  double radius;
  Bezier curve;
  Aabb box;  ///< of the curve, enlarged by the radius
};

Element element_of(const double* dofs, double length, GlobalIndex fiber, double radius) {
  Element e{fiber, radius, {}, {}};
  for (int i = 0; i < 3; ++i) {
    e.curve.point[0][i] = dofs[i];
    e.curve.point[1][i] = dofs[i] + length / 3 * dofs[3 + i];
    e.curve.point[2][i] = dofs[6 + i] - length / 3 * dofs[9 + i];
    e.curve.point[3][i] = dofs[6 + i];
  }
  e.box = e.curve.box();
  e.box.inflate(radius + smallest * e.box.size());
  return e;
}

/// Two curves come nearer to each other than `reach`.
bool is_near(const Bezier& a, const Bezier& b, double reach, double tolerance, int depth) {
  Aabb box = a.box();
  box.inflate(reach);
  if (!box.overlaps(b.box())) return false;
  const double bend_a = a.bend(), bend_b = b.bend(), bends = bend_a + bend_b;
  const double distance = segment_distance(a.at(0), a.at(3) - a.at(0), b.at(0), b.at(3) - b.at(0));
  // What bends cannot change.
  if (distance >= reach + bends) return false;
  if (distance < reach - bends) return true;
  if ((bend_a <= tolerance && bend_b <= tolerance) || depth == most_halvings) return distance < reach;
  Bezier left, right;
  if (bend_a >= bend_b) {
    a.halve(left, right);
    return is_near(left, b, reach, tolerance, depth + 1) || is_near(right, b, reach, tolerance, depth + 1);
  }
  b.halve(left, right);
  return is_near(a, left, reach, tolerance, depth + 1) || is_near(a, right, reach, tolerance, depth + 1);
}

bool is_near(const Element& a, const Element& b) {
  const double reach = a.radius + b.radius + smallest * std::max(a.box.size(), b.box.size());
  return is_near(a.curve, b.curve, reach, straight * reach, 0);
}

}  // namespace

double segment_distance(const Vec3& a, const Vec3& along_a, const Vec3& b, const Vec3& along_b) {
  const double aa = along_a.squaredNorm(), bb = along_b.squaredNorm(), ab = along_a.dot(along_b);
  const Vec3 gap = a - b;
  const double to_a = along_a.dot(gap), to_b = along_b.dot(gap), determinant = aa * bb - ab * ab;
  const auto within = [](double x) { return std::clamp(x, 0.0, 1.0); };
  double s = determinant > 1e-14 * aa * bb ? within((ab * to_b - bb * to_a) / determinant) : 0.0;
  double t = bb > 0.0 ? (ab * s + to_b) / bb : 0.0;
  if (t != within(t) || !(determinant > 1e-14 * aa * bb)) {
    t = within(t);
    s = aa > 0.0 ? within((ab * t - to_a) / aa) : 0.0;
  }
  double least = (gap + s * along_a - t * along_b).norm();
  // parallel segments: ends that lie beside the other one
  for (const double end : {0.0, 1.0}) {
    const double beside_b = bb > 0.0 ? within((ab * end + to_b) / bb) : 0.0;
    const double beside_a = aa > 0.0 ? within((ab * end - to_a) / aa) : 0.0;
    least = std::min(
        {least, (gap + end * along_a - beside_b * along_b).norm(), (gap + beside_a * along_a - end * along_b).norm()});
  }
  return least;
}

FiberCrossings::FiberCrossings(const mesh::FiberMesh& fibers, std::vector<double> radius)
    : fibers_(fibers), radius_(std::move(radius)), exchange_(fibers.comm) {
  const auto fiber_of = [&](Index node) {
    const auto after = std::upper_bound(fibers.first_node.begin(), fibers.first_node.end(), node);
    return fibers.fiber_id[static_cast<std::size_t>(after - fibers.first_node.begin()) - 1];
  };
  for (const mesh::FiberMesh::LocalJoint& joint : fibers.joints) {
    const GlobalIndex a = fiber_of(joint.a), b = fiber_of(joint.b);
    joined_.emplace_back(std::min(a, b), std::max(a, b));
  }
  std::sort(joined_.begin(), joined_.end());
}

FiberPairs FiberCrossings::find(const std::vector<double>& dofs) {
  const Comm& comm = exchange_.comm();
  std::vector<Element> elements;
  std::vector<Aabb> boxes;
  Aabb mine;
  elements.reserve(static_cast<std::size_t>(fibers_.elements()));
  for (Index f = 0; f < fibers_.fibers(); ++f)
    for (Index e = fibers_.first_element(f); e < fibers_.first_element(f + 1); ++e) {
      elements.push_back(element_of(&dofs[6 * static_cast<std::size_t>(e + f)], fibers_.element_length[e],
                                    fibers_.fiber_id[f], radius_[f]));
      boxes.push_back(elements.back().box);
      mine.include(boxes.back());
    }
  std::set<std::pair<GlobalIndex, GlobalIndex>> pairs;
  const Tree tree(boxes);
  const auto compare = [&](const Element& a, const Element& b) {
    if (a.fiber == b.fiber) return;
    const std::pair<GlobalIndex, GlobalIndex> pair = std::minmax(a.fiber, b.fiber);
    if (pairs.count(pair) > 0 || std::binary_search(joined_.begin(), joined_.end(), pair)) return;
    if (a.fiber < b.fiber ? is_near(a, b) : is_near(b, a)) pairs.insert(pair);
  };
  std::vector<std::pair<Index, Index>> overlaps;
  tree.pairs(overlaps);
  for (const auto& [e, other] : overlaps) compare(elements[e], elements[other]);
  if (comm.size() > 1) {
    // a pair on two ranks is found by the higher one
    std::vector<Aabb> all(static_cast<std::size_t>(comm.size()));
    MPI_Allgather(&mine, static_cast<int>(sizeof(Aabb)), MPI_BYTE, all.data(), static_cast<int>(sizeof(Aabb)), MPI_BYTE,
                  comm.get());
    std::map<int, std::vector<Element>> out;
    std::vector<Index> found;
    for (int rank = comm.rank() + 1; rank < comm.size(); ++rank) {
      if (!mine.overlaps(all[static_cast<std::size_t>(rank)])) continue;
      for (const Element& element : elements)
        if (element.box.overlaps(all[static_cast<std::size_t>(rank)])) out[rank].push_back(element);
    }
    for (const auto& [rank, list] : exchange_.exchange(std::move(out)))
      for (const Element& element : list) {
        found.clear();
        tree.overlapping(element.box, found);
        for (const Index other : found) compare(element, elements[other]);
      }
  }
  FiberPairs result;
  result.count = comm.sum(static_cast<GlobalIndex>(pairs.size()));
  if (result.count == 0) return result;
  const GlobalIndex none = fibers_.global_fibers * fibers_.global_fibers;
  const GlobalIndex lowest =
      pairs.empty() ? none : pairs.begin()->first * fibers_.global_fibers + pairs.begin()->second;
  const GlobalIndex first = -comm.max(-lowest);
  result.first[0] = first / fibers_.global_fibers;
  result.first[1] = first % fibers_.global_fibers;
  return result;
}

}  // namespace fbi::search
