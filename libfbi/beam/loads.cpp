#include "beam/loads.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "beam/differences.hpp"
#include "beam/turning.hpp"
#include "fem/line_shapes.hpp"
#include "fem/quadrature.hpp"

namespace fbi::beam {
namespace {

bool depends_on_time(const Load& load) {
  return std::any_of(load.value.begin(), load.value.end(),
                     [](const input::Expression& component) { return component.depends_on_time(); });
}

bool has_equations(const FiberParameters& group) {
  return group.formulation != Formulation::fixed && group.formulation != Formulation::prescribed;
}

Vec3 any_normal(const Vec3& tangent) {
  int least = 0;
  tangent.cwiseAbs().minCoeff(&least);
  return tangent.cross(Vec3::Unit(least)).normalized();
}

std::array<double, 4> position_weights(double x, double length) {
  std::array<double, 4> h = fem::hermite(x);
  h[1] *= 0.5 * length;
  h[3] *= 0.5 * length;
  return h;
}

// Weights of r' = dr/ds.
std::array<double, 4> tangent_weights(double x, double length) {
  std::array<double, 4> h = fem::hermite_first(x);
  h[0] *= 2.0 / length;
  h[2] *= 2.0 / length;
  return h;
}

}  // namespace

void Frames::initialize(const mesh::FiberMesh& fibers) {
  reference.resize(6 * static_cast<std::size_t>(fibers.nodes()));
  for (std::size_t node = 0; node < reference.size() / 6; ++node) {
    const Vec3 tangent(&fibers.tangent[3 * node]), normal = any_normal(tangent);
    for (int k = 0; k < 3; ++k) {
      reference[6 * node + k] = normal[k];
      reference[6 * node + 3 + k] = tangent[k];
    }
  }
  last = reference;
}

Vec3 Frames::carry(Index node, const Vec3& v) const {
  const double* from = &reference[6 * static_cast<std::size_t>(node)];
  const double* to = &last[6 * static_cast<std::size_t>(node)];
  const Vec3 e0(from), t0(from + 3), e(to), t(to + 3);
  return v.dot(e0) * e + v.dot(t0) * t + v.dot(t0.cross(e0)) * t.cross(e);
}

void Frames::advance(Index node, const Vec3& tangent) {
  double* frame = &last[6 * static_cast<std::size_t>(node)];
  const Vec3 t = tangent.normalized();
  Vec3 e = turn(Vec3(frame + 3), t, Vec3(frame));
  e = (e - e.dot(t) * t).normalized();
  for (int k = 0; k < 3; ++k) {
    frame[k] = e[k];
    frame[3 + k] = t[k];
  }
}

Loads::Loads(const mesh::FiberMesh& fibers, const std::vector<FiberParameters>& groups, const Vec3& gravity)
    : fibers_(fibers), groups_(groups) {
  constant_.dead.assign(6 * static_cast<std::size_t>(fibers.nodes()), 0.0);
  constant_.point.resize(fibers.fibers());
  for (Index f = 0; f < fibers.fibers(); ++f) {
    const FiberParameters& group = groups[fibers.group[f]];
    if (!has_equations(group)) continue;
    if (gravity.squaredNorm() > 0) {
      const Vec3 weight = (group.material.density - group.displaced_density) * group.section.area * gravity;
      Load load;
      load.type = LoadType::line;
      load.value = {weight[0], weight[1], weight[2]};
      add_load(f, load, 0.0, constant_);
    }
    for (const Load& load : group.loads)
      if (!depends_on_time(load)) add_load(f, load, 0.0, constant_);
  }
}

bool Loads::has_followers() const {
  return std::any_of(groups_.begin(), groups_.end(), [](const FiberParameters& group) {
    return std::any_of(group.loads.begin(), group.loads.end(), [](const Load& load) { return load.follower; });
  });
}

Loads::Place Loads::place_of(Index fiber, const Load& load) const {
  const Index first = fibers_.first_node[fiber], elements = fibers_.first_node[fiber + 1] - first - 1;
  const double* length = &fibers_.element_length[fibers_.first_element(fiber)];
  Place place{load.at == End::start ? 0 : elements - 1, load.at == End::start ? -1.0 : 1.0, Vec3::Zero()};
  if (load.arc_length) {
    double left = *load.arc_length;
    for (place.element = 0; place.element + 1 < elements && left > length[place.element]; ++place.element)
      left -= length[place.element];
    place.x = std::clamp(2 * left / length[place.element] - 1, -1.0, 1.0);
  }
  const std::array<double, 4> h = position_weights(place.x, length[place.element]);
  for (int i = 0; i < 2; ++i) {
    const std::size_t node = static_cast<std::size_t>(first + place.element + i);
    place.position += h[2 * i] * Vec3(&fibers_.position[3 * node]) + h[2 * i + 1] * Vec3(&fibers_.tangent[3 * node]);
  }
  return place;
}

void Loads::add_load(Index fiber, const Load& load, double t, LoadValues& values) const {
  const Index first = fibers_.first_node[fiber];
  const auto add_dead = [&](Index element, double x, const Vec3& force) {
    const std::array<double, 4> h = position_weights(x, fibers_.element_length[first + element - fiber]);
    double* out = &values.dead[6 * static_cast<std::size_t>(first + element)];
    for (int i = 0; i < 4; ++i)
      for (int k = 0; k < 3; ++k) out[3 * i + k] += h[i] * force[k];
  };
  if (load.type != LoadType::line) {
    const Place place = place_of(fiber, load);
    const Vec3 value = value_of(load.value, place.position, t);
    if (load.type == LoadType::moment || load.follower)
      values.point[fiber].push_back({place.element, place.x, value, load.type == LoadType::moment, load.follower});
    else
      add_dead(place.element, place.x, value);
    return;
  }
  static const fem::QuadratureRule rule = fem::gauss_legendre(5);
  const auto reference = [this](Index node) { return Vec3(&fibers_.position[3 * static_cast<std::size_t>(node)]); };
  for (Index node = first; node + 1 < fibers_.first_node[fiber + 1]; ++node) {
    const double length = fibers_.element_length[node - fiber];
    const Vec3 x1 = reference(node), x2 = reference(node + 1);
    for (std::size_t p = 0; p < rule.points.size(); ++p) {
      const Vec3 x = 0.5 * (1 - rule.points[p]) * x1 + 0.5 * (1 + rule.points[p]) * x2;
      const Vec3 force = value_of(load.value, x, t) * (rule.weights[p] * 0.5 * length);
      if (load.follower)
        values.point[fiber].push_back({node - first, rule.points[p], force, false, true});
      else
        add_dead(node - first, rule.points[p], force);
    }
  }
}

void Loads::evaluate(double t, double factor, LoadValues& values) const {
  values = constant_;
  for (Index f = 0; f < fibers_.fibers(); ++f) {
    const FiberParameters& group = groups_[fibers_.group[f]];
    if (!has_equations(group)) continue;
    for (const Load& load : group.loads)
      if (depends_on_time(load)) add_load(f, load, t, values);
  }
  if (factor == 1.0) return;
  for (double& value : values.dead) value *= factor;
  for (std::vector<PointLoad>& loads : values.point)
    for (PointLoad& load : loads) load.value *= factor;
}

Vec3 moment_force(const Vec3& moment, const Vec3& tangent) { return moment.cross(tangent) / tangent.squaredNorm(); }

Mat3 moment_force_tangent(const Vec3& moment, const Vec3& tangent) {
  const double squared = tangent.squaredNorm();
  return (skew_matrix(moment) - 2.0 / squared * moment.cross(tangent) * tangent.transpose()) / squared;
}

void point_load_force(const PointLoad& load, double length, const Frames& frames, Index node, const double* q,
                      double* force, double* derivative) {
  const std::array<double, 4> b = tangent_weights(load.x, length);
  Vec3 tangent = Vec3::Zero();
  for (int i = 0; i < 4; ++i) tangent += b[i] * Vec3(q + 3 * i);
  Vec3 value = load.value;
  Mat3 by_tangent = Mat3::Zero();
  if (load.follower) {
    const Index nearest = load.x > 0 ? node + 1 : node;
    const Vec3 carried = frames.carry(nearest, load.value), last = frames.tangent(nearest);
    const double stretch = tangent.norm();
    const Vec3 unit = tangent / stretch;
    value = turn(last, unit, carried);
    if (derivative != nullptr)
      by_tangent = turn_derivative(last, unit, carried) * (Mat3::Identity() - unit * unit.transpose()) / stretch;
  }
  std::array<double, 4> test = b;
  if (load.moment) {
    const Vec3 moment = value;
    value = moment_force(moment, tangent);
    if (derivative != nullptr) {
      const Mat3 by_moment = -skew_matrix(tangent) / tangent.squaredNorm();
      by_tangent = (by_moment * by_tangent + moment_force_tangent(moment, tangent)).eval();
    }
  } else {
    test = position_weights(load.x, length);
  }
  for (int i = 0; i < 4; ++i)
    for (int k = 0; k < 3; ++k) {
      force[3 * i + k] = test[i] * value[k];
      if (derivative == nullptr) continue;
      for (int j = 0; j < 4; ++j)
        for (int l = 0; l < 3; ++l) derivative[12 * (3 * i + k) + 3 * j + l] = test[i] * b[j] * by_tangent(k, l);
    }
}

}  // namespace fbi::beam
