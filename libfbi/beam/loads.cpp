#include "beam/loads.hpp"

#include <Eigen/Geometry>
#include <algorithm>

#include "fem/line_shapes.hpp"
#include "fem/quadrature.hpp"

namespace fbi::beam {
namespace {

bool depends_on_time(const Load& load) {
  return std::any_of(load.value.begin(), load.value.end(),
                     [](const input::Expression& component) { return component.depends_on_time(); });
}

Vec3 evaluate_at(const input::VectorExpression& value, const Vec3& x, double t) {
  return {value[0](x, t), value[1](x, t), value[2](x, t)};
}

bool has_equations(const FiberParameters& group) { return group.formulation != Formulation::fixed; }

}  // namespace

Loads::Loads(const mesh::FiberMesh& fibers, const std::vector<FiberParameters>& groups, const Vec3& gravity)
    : fibers_(fibers), groups_(groups), constant_(6 * static_cast<std::size_t>(fibers.nodes()), 0.0) {
  for (Index f = 0; f < fibers.fibers(); ++f) {
    const FiberParameters& group = groups[fibers.group[f]];
    if (!has_equations(group)) continue;
    if (gravity.squaredNorm() > 0) {
      const Vec3 weight = group.material.density * group.section.area * gravity;
      Load load;
      load.type = LoadType::line;
      load.value = {weight[0], weight[1], weight[2]};
      add_load(f, load, 0.0, constant_);
    }
    for (const Load& load : group.loads)
      if (!depends_on_time(load)) add_load(f, load, 0.0, constant_);
  }
}

void Loads::add_load(Index fiber, const Load& load, double t, std::vector<double>& dead) const {
  const auto reference = [this](Index node) { return Vec3(&fibers_.position[3 * static_cast<std::size_t>(node)]); };
  if (load.type == LoadType::moment) return;
  if (load.type == LoadType::force) {
    const Index node = load.at == End::start ? fibers_.first_node[fiber] : fibers_.first_node[fiber + 1] - 1;
    const Vec3 force = evaluate_at(load.value, reference(node), t);
    for (int k = 0; k < 3; ++k) dead[6 * static_cast<std::size_t>(node) + k] += force[k];
    return;
  }
  static const fem::QuadratureRule rule = fem::gauss_legendre(5);
  for (Index node = fibers_.first_node[fiber]; node + 1 < fibers_.first_node[fiber + 1]; ++node) {
    const double length = fibers_.element_length[node - fiber];
    const Vec3 x1 = reference(node), x2 = reference(node + 1);
    for (std::size_t p = 0; p < rule.points.size(); ++p) {
      const Vec3 x = 0.5 * (1 - rule.points[p]) * x1 + 0.5 * (1 + rule.points[p]) * x2;
      const Vec3 force = evaluate_at(load.value, x, t) * (rule.weights[p] * 0.5 * length);
      const std::array<double, 4> h = fem::hermite(rule.points[p]);
      double* out = &dead[6 * static_cast<std::size_t>(node)];
      for (int i = 0; i < 4; ++i)
        for (int k = 0; k < 3; ++k) out[3 * i + k] += h[i] * (i % 2 == 0 ? 1.0 : 0.5 * length) * force[k];
    }
  }
}

void Loads::evaluate(double t, double factor, LoadValues& values) const {
  values.dead = constant_;
  values.moment.assign(fibers_.fibers(), {Vec3::Zero(), Vec3::Zero()});
  for (Index f = 0; f < fibers_.fibers(); ++f) {
    const FiberParameters& group = groups_[fibers_.group[f]];
    if (!has_equations(group)) continue;
    for (const Load& load : group.loads) {
      if (load.type == LoadType::moment) {
        const bool start = load.at == End::start;
        const Index node = start ? fibers_.first_node[f] : fibers_.first_node[f + 1] - 1;
        const Vec3 x(&fibers_.position[3 * static_cast<std::size_t>(node)]);
        values.moment[f][start ? 0 : 1] += factor * evaluate_at(load.value, x, t);
      } else if (depends_on_time(load)) {
        add_load(f, load, t, values.dead);
      }
    }
  }
  if (factor != 1.0)
    for (double& value : values.dead) value *= factor;
}

Vec3 moment_force(const Vec3& moment, const Vec3& tangent) { return moment.cross(tangent) / tangent.squaredNorm(); }

Mat3 moment_force_tangent(const Vec3& moment, const Vec3& tangent) {
  const double squared = tangent.squaredNorm();
  Mat3 cross;
  cross << 0, -moment[2], moment[1], moment[2], 0, -moment[0], -moment[1], moment[0], 0;
  return (cross - 2.0 / squared * moment.cross(tangent) * tangent.transpose()) / squared;
}

}  // namespace fbi::beam
