#include "beam/supports.hpp"

#include <cmath>

#include "base/error.hpp"
#include "base/log.hpp"

namespace fbi::beam {
namespace {

// g = f/|f| with its derivatives.
Motion unit(const Motion& f) {
  const double length = f.value.norm();
  Motion g;
  g.value = f.value / length;
  const double rate = g.value.dot(f.rate);  // of the length
  g.rate = (f.rate - rate * g.value) / length;
  const double acceleration = g.value.dot(f.acceleration) + g.rate.dot(f.rate);
  g.acceleration = (f.acceleration - acceleration * g.value - 2 * rate * g.rate) / length;
  return g;
}

struct Stretch {
  double value, rate, acceleration;
};

// C = 2 s' g' + s g''
Vec3 convected(const Motion& g, double s, double rate) { return 2 * rate * g.rate + s * g.acceleration; }

Vec3 load3(const double* x) { return {x[0], x[1], x[2]}; }
void store3(const Vec3& value, double* x) {
  for (int k = 0; k < 3; ++k) x[k] = value[k];
}

// The node at the reference arc length s, or -1.
Index node_at(const mesh::FiberMesh& mesh, Index f, double s, double& nearest) {
  double at = 0.0, length = 0.0;
  for (Index e = mesh.first_element(f); e < mesh.first_element(f + 1); ++e) length += mesh.element_length[e];
  const Index nodes = mesh.first_node[f + 1] - mesh.first_node[f];
  nearest = 0.0;
  Index found = 0;
  for (Index node = 0; node < nodes; ++node) {
    if (std::abs(at - s) < std::abs(nearest - s)) {
      nearest = at;
      found = node;
    }
    if (node + 1 < nodes) at += mesh.element_length[mesh.first_element(f) + node];
  }
  return std::abs(nearest - s) <= 1e-6 * length ? found : -1;
}

}  // namespace

void NodeSupport::begin_step(double time, double dt, double alpha_f) {
  const double spacing = 0.25 * dt;
  if (motion) {
    position = motion_in_time(*motion, reference, time, spacing);
    position_n = dt > 0.0 ? motion_in_time(*motion, reference, time - dt, spacing) : position;
  }
  if (direction) {
    axis = unit(motion_in_time(*direction, reference, time, spacing));
    axis_n = dt > 0.0 ? unit(motion_in_time(*direction, reference, time - dt, spacing)) : axis;
    constraint.axis = axis.value;
    constraint.force_axis = ((1 - alpha_f) * axis.value + alpha_f * axis_n.value).normalized();
  }
}

void NodeSupport::place(double* q) const {
  if (motion) store3(reference + position.value, q);
  if (direction) store3(load3(q + 3).norm() * axis.value, q + 3);
}

void NodeSupport::set_rates(const GeneralizedAlpha& scheme, double dt, const double* q_n, const double* v_n,
                            const double* a_n, const double* q, double* v, double* a) const {
  if (motion) {
    store3(position.rate, v);
    store3(position.acceleration, a);
  }
  if (!direction) return;
  Stretch s_n{load3(q_n + 3).norm(), load3(v_n + 3).dot(axis_n.value), 0.0};
  s_n.acceleration = (load3(a_n + 3) - convected(axis_n, s_n.value, s_n.rate)).dot(axis_n.value);
  const double value = load3(q + 3).norm(), change = value - s_n.value;
  const double rate = scheme.velocity(change, s_n.rate, s_n.acceleration, dt);
  const double acceleration = scheme.acceleration(change, s_n.rate, s_n.acceleration, dt);
  store3(rate * axis.value + value * axis.rate, v + 3);
  store3(acceleration * axis.value + convected(axis, value, rate), a + 3);
}

void NodeSupport::shift(const GeneralizedAlpha& scheme, const double* q_n, const double* v_n, const double* a_n,
                        const double* q, const double* v, const double* a, double* out) const {
  const double alpha_m = scheme.alpha_m, alpha_f = scheme.alpha_f;
  std::fill_n(out, 6, 0.0);
  if (motion) store3((alpha_m - alpha_f) * (position.acceleration - position_n.acceleration), out);
  if (!direction) return;
  const Vec3 last = convected(axis_n, load3(q_n + 3).norm(), load3(v_n + 3).dot(axis_n.value));
  const Vec3 next = convected(axis, load3(q + 3).norm(), load3(v + 3).dot(axis.value));
  // s'' g at the level: the mean of s'' of the scheme along the mean of g
  const double s_n = (load3(a_n + 3) - last).dot(axis_n.value), s = (load3(a + 3) - next).dot(axis.value);
  const Vec3 along = ((1 - alpha_m) * s + alpha_m * s_n) * ((1 - alpha_f) * axis.value + alpha_f * axis_n.value) -
                     (1 - alpha_m) * s * axis.value - alpha_m * s_n * axis_n.value;
  store3((alpha_m - alpha_f) * (next - last) + along, out + 3);
}

void NodeSupport::initial_rates(const double* q, double* v, double* a) const {
  if (motion) {
    store3(position_n.rate, v);
    store3(position_n.acceleration, a);
  }
  if (!direction) return;
  const double s = load3(q + 3).norm(), rate = load3(v + 3).dot(axis_n.value);
  store3(rate * axis_n.value + s * axis_n.rate, v + 3);
  store3(convected(axis_n, s, rate), a + 3);
}

std::vector<NodeSupport> supports_of(const FiberParameters& group, const mesh::FiberMesh& mesh, Index f, bool dynamic) {
  std::vector<NodeSupport> all;
  const Index first = mesh.first_node[f], nodes = mesh.first_node[f + 1] - first;
  const auto fail = [&](const std::string& what) {
    throw Error(ExitCode::geometry, "fiber \"" + mesh.name[f] + "\": " + what);
  };
  const auto add = [&](Index node, const Support& support) {
    if (support.type == EndCondition::free) return;
    for (const NodeSupport& other : all)
      if (other.node == node) fail(log::format("node %d is supported twice; remove one of the supports", node));
    NodeSupport s;
    s.node = node;
    s.reference = Vec3(&mesh.position[3 * static_cast<std::size_t>(first + node)]);
    const Vec3 tangent(&mesh.tangent[3 * static_cast<std::size_t>(first + node)]);
    s.constraint = NodeConstraint(support.type, tangent);
    s.motion = support.motion;
    s.direction = support.direction;
    if (s.motion && !(value_of(*s.motion, s.reference, 0.0).norm() <= 1e-9 * (1 + s.reference.norm())))
      fail("the motion of a support must be zero at t = 0; subtract its initial value");
    if (s.direction && !((value_of(*s.direction, s.reference, 0.0).normalized() - tangent).norm() <= 1e-6))
      fail("the direction of a support must be that of the fiber at t = 0");
    s.begin_step(0.0, 0.0, 0.0);
    if (!dynamic) s.position.rate = s.position.acceleration = Vec3::Zero();
    all.push_back(s);
  };
  Support end;
  end.type = group.start;
  add(0, end);
  end.type = group.end;
  add(nodes - 1, end);
  for (const Support& support : group.supports) {
    Index node = support.at == End::start ? 0 : nodes - 1;
    if (support.arc_length) {
      double nearest = 0.0;
      node = node_at(mesh, f, *support.arc_length, nearest);
      if (node < 0)
        fail(
            log::format("a support at arc length %g lies between nodes, the nearest one is at %g; choose \"elements\" "
                        "such that a node lies there",
                        *support.arc_length, nearest));
    }
    add(node, support);
  }
  return all;
}

}  // namespace fbi::beam
