#include "meshgen/joints.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <set>
#include <unordered_map>

#include "base/error.hpp"
#include "base/log.hpp"
#include "base/types.hpp"
#include "input/suggest.hpp"

namespace fbi::meshgen {
namespace {

constexpr double apart = 1e-6;  // of the element length: farther nodes do not lie at one place

struct Places {
  const mesh::FiberMeshData& fibers;

  Vec3 position(GlobalIndex node) const { return Eigen::Map<const Vec3>(&fibers.position[3 * node]); }
  GlobalIndex fiber_of(GlobalIndex node) const {
    return std::upper_bound(fibers.first_node.begin(), fibers.first_node.end(), node) - fibers.first_node.begin() - 1;
  }
  double element(GlobalIndex fiber) const { return fibers.element_length[fibers.first_node[fiber] - fiber]; }

  /// Number of the fiber with this name; -1 with a text in `error`.
  GlobalIndex find(const std::string& name, std::string& error) const {
    const auto found = std::find(fibers.name.begin(), fibers.name.end(), name);
    if (found != fibers.name.end()) return found - fibers.name.begin();
    error = "there is no fiber \"" + name + "\"" + input::did_you_mean(name, fibers.name);
    return -1;
  }
  /// The node at the end, the start or the arc length; -1 with a text in `error` where there is none.
  GlobalIndex node(GlobalIndex fiber, bool at_end, const std::optional<double>& arc_length, std::string& error) const {
    const GlobalIndex first = fibers.first_node[fiber], last = fibers.first_node[fiber + 1] - 1;
    if (!arc_length) return at_end ? last : first;
    GlobalIndex nearest = first;
    double s = 0.0, nearest_s = 0.0;
    for (GlobalIndex n = first + 1; n <= last; ++n) {
      s += fibers.element_length[n - 1 - fiber];
      if (std::abs(s - *arc_length) < std::abs(nearest_s - *arc_length)) {
        nearest = n;
        nearest_s = s;
      }
    }
    if (std::abs(nearest_s - *arc_length) <= 1e-6 * s) return nearest;
    error = log::format(
        "fiber \"%s\" has no node at the arc length %g, the nearest one is at %.10g; give that, or choose "
        "\"elements\" such that a node lies there",
        fibers.name[fiber].c_str(), *arc_length, nearest_s);
    return -1;
  }
  bool has_name(GlobalIndex fiber, const std::string& name) const {
    const std::string& own = fibers.name[fiber];
    return own == name ||
           (own.size() > name.size() && own.compare(0, name.size(), name) == 0 && own[name.size()] == '/');
  }
};

/// All pairs of nodes nearer than `distance` of fibers that carry the names, in ascending order.
std::vector<std::pair<GlobalIndex, GlobalIndex>> touching(const Places& places, const mesh::JointParameters& joint) {
  const double distance = *joint.touching, bin = 2 * distance;
  const bool any[2] = {joint.fiber[0].empty(), joint.fiber[1].empty()};
  std::map<std::array<std::int64_t, 3>, std::vector<GlobalIndex>> bins;
  std::vector<std::pair<GlobalIndex, GlobalIndex>> pairs;
  for (GlobalIndex fiber = 0; fiber < places.fibers.fiber_count(); ++fiber) {
    const bool is_a = any[0] || places.has_name(fiber, joint.fiber[0]);
    const bool is_b = any[1] ? is_a || !any[0] : places.has_name(fiber, joint.fiber[1]);
    if (!is_a && !is_b) continue;
    for (GlobalIndex node = places.fibers.first_node[fiber]; node < places.fibers.first_node[fiber + 1]; ++node) {
      const Vec3 x = places.position(node);
      std::array<std::int64_t, 3> home;
      for (int i = 0; i < 3; ++i) home[i] = static_cast<std::int64_t>(std::floor(x[i] / bin));
      for (std::int64_t i = home[0] - 1; i <= home[0] + 1; ++i)
        for (std::int64_t j = home[1] - 1; j <= home[1] + 1; ++j)
          for (std::int64_t k = home[2] - 1; k <= home[2] + 1; ++k) {
            const auto found = bins.find({i, j, k});
            if (found == bins.end()) continue;
            for (const GlobalIndex other : found->second) {
              if ((places.position(other) - x).norm() >= distance) continue;
              const GlobalIndex from = places.fiber_of(other);
              const bool other_a = any[0] || places.has_name(from, joint.fiber[0]);
              const bool other_b = any[1] ? other_a || !any[0] : places.has_name(from, joint.fiber[1]);
              if (!((is_a && other_b) || (is_b && other_a))) continue;
              if (from == fiber && node - other == 1) continue;
              pairs.emplace_back(other, node);
            }
          }
      bins[home].push_back(node);
    }
  }
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

/// Which fibers hang together, and the middle of each body: the mean of its nodes.
void find_bodies(const Places& places, mesh::FiberMeshData& fibers) {
  const std::size_t count = fibers.name.size();
  std::vector<GlobalIndex>& body = fibers.body;
  body.resize(count);
  std::iota(body.begin(), body.end(), 0);
  const auto root = [&body](GlobalIndex f) {
    while (body[f] != f) f = body[f] = body[body[f]];
    return f;
  };
  for (const mesh::Joint& joint : fibers.joints) {
    const GlobalIndex a = root(places.fiber_of(joint.a)), b = root(places.fiber_of(joint.b));
    body[std::max(a, b)] = std::min(a, b);
  }
  std::vector<Vec3> sum(count, Vec3::Zero());
  std::vector<double> nodes(count, 0.0);
  for (std::size_t f = 0; f < count; ++f) {
    body[f] = root(static_cast<GlobalIndex>(f));
    for (GlobalIndex n = fibers.first_node[f]; n < fibers.first_node[f + 1]; ++n) {
      sum[body[f]] += places.position(n);
      nodes[body[f]] += 1.0;
    }
  }
  for (std::size_t f = 0; f < count; ++f) {
    const Vec3 middle = sum[body[f]] / nodes[body[f]];
    fibers.anchor.insert(fibers.anchor.end(), middle.begin(), middle.end());
  }
}

}  // namespace

void add_joints(const std::vector<mesh::JointParameters>& joints, mesh::FiberMeshData& fibers) {
  if (joints.empty() || fibers.name.empty()) return;
  const Places places{fibers};
  std::string usage, geometry;
  const auto complain = [](std::string& all, std::size_t i, const std::string& text) {
    all += (all.empty() ? "joints[" : "\njoints[") + std::to_string(i) + "]: " + text;
  };
  std::set<std::pair<GlobalIndex, GlobalIndex>> known;
  const auto add = [&](GlobalIndex a, GlobalIndex b, mesh::JointType type) {
    if (known.insert({std::min(a, b), std::max(a, b)}).second) fibers.joints.push_back({a, b, type});
  };
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const mesh::JointParameters& joint = joints[i];
    if (joint.touching) {
      bool good = true;
      for (const std::string& name : joint.fiber) {
        bool found = name.empty();
        for (GlobalIndex f = 0; f < fibers.fiber_count() && !found; ++f) found = places.has_name(f, name);
        if (found) continue;
        complain(usage, i, "there is no fiber or array \"" + name + "\"" + input::did_you_mean(name, fibers.name));
        good = false;
      }
      const auto pairs = touching(places, joint);
      if (good && pairs.empty())
        complain(geometry, i,
                 log::format("no two nodes are nearer to each other than %g; raise \"touching\", or choose "
                             "\"elements\" such that nodes meet",
                             *joint.touching));
      for (const auto& [a, b] : pairs) add(a, b, joint.type);
      continue;
    }
    GlobalIndex node[2] = {-1, -1};
    for (int side = 0; side < 2; ++side) {
      std::string error;
      const GlobalIndex fiber = places.find(joint.fiber[side], error);
      if (fiber < 0) {
        complain(usage, i, error);
        continue;
      }
      node[side] = places.node(fiber, joint.at_end[side], joint.arc_length[side], error);
      if (node[side] < 0) complain(geometry, i, error);
    }
    if (node[0] < 0 || node[1] < 0) continue;
    if (node[0] == node[1]) {
      complain(geometry, i, "joins a node to itself");
      continue;
    }
    const double distance = (places.position(node[0]) - places.position(node[1])).norm();
    const double size = std::min(places.element(places.fiber_of(node[0])), places.element(places.fiber_of(node[1])));
    if (distance > apart * size) {
      complain(geometry, i,
               log::format("the nodes of \"%s\" and \"%s\" lie %.6g apart; a joint holds nodes that are at one "
                           "place",
                           joint.fiber[0].c_str(), joint.fiber[1].c_str(), distance));
      continue;
    }
    add(node[0], node[1], joint.type);
  }
  if (!usage.empty()) throw Error(ExitCode::usage, usage);
  if (!geometry.empty()) throw Error(ExitCode::geometry, geometry);
  std::stable_sort(fibers.joints.begin(), fibers.joints.end(), [&](const mesh::Joint& a, const mesh::Joint& b) {
    return places.fiber_of(a.a) < places.fiber_of(b.a);
  });
  fibers.first_joint.assign(fibers.name.size() + 1, 0);
  for (const mesh::Joint& joint : fibers.joints) ++fibers.first_joint[places.fiber_of(joint.a) + 1];
  std::partial_sum(fibers.first_joint.begin(), fibers.first_joint.end(), fibers.first_joint.begin());
  find_bodies(places, fibers);
}

}  // namespace fbi::meshgen
