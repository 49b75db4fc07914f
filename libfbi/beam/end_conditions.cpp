#include "beam/end_conditions.hpp"

#include "beam/formulation.hpp"

namespace fbi::beam {

NodeConstraint::NodeConstraint(EndCondition condition, const Vec3& tangent)
    : position(condition == EndCondition::pinned || condition == EndCondition::clamped),
      along(condition == EndCondition::guided),
      direction(condition == EndCondition::guided || condition == EndCondition::clamped),
      axis(tangent.normalized()),
      force_axis(axis) {}

namespace {

void project_by(const NodeConstraint& c, const Vec3& test, double* x) {
  if (c.position) x[0] = x[1] = x[2] = 0.0;
  if (c.along) {
    const double held = c.axis[0] * x[0] + c.axis[1] * x[1] + c.axis[2] * x[2];
    for (int k = 0; k < 3; ++k) x[k] -= held * c.axis[k];
  }
  if (c.direction) {
    const double stretch = test[0] * x[3] + test[1] * x[4] + test[2] * x[5];
    for (int k = 0; k < 3; ++k) x[3 + k] = stretch * c.axis[k];
  }
}

}  // namespace

void NodeConstraint::project(double* x) const { project_by(*this, force_axis, x); }
void NodeConstraint::project_increment(double* x) const { project_by(*this, axis, x); }

void NodeConstraint::project_element(double* matrix, int local) const {
  if (!active()) return;
  for (int i = 0; i < element_dofs; ++i) project_increment(matrix + element_dofs * i + 6 * local);
  for (int i = 0; i < element_dofs; ++i) {
    double column[6];
    for (int k = 0; k < 6; ++k) column[k] = matrix[element_dofs * (6 * local + k) + i];
    project(column);
    for (int k = 0; k < 6; ++k) matrix[element_dofs * (6 * local + k) + i] = column[k];
  }
}

void NodeConstraint::fill_element(double* matrix, int local, double position_scale, double tangent_scale) const {
  for (int k = 0; k < 3; ++k) {
    if (position) matrix[(element_dofs + 1) * (6 * local + k)] += position_scale;
    for (int l = 0; l < 3; ++l) {
      if (along) matrix[element_dofs * (6 * local + k) + 6 * local + l] += position_scale * axis[k] * axis[l];
      if (!direction) continue;
      matrix[element_dofs * (6 * local + 3 + k) + 6 * local + 3 + l] +=
          tangent_scale * ((k == l ? 1.0 : 0.0) - axis[k] * axis[l]);
    }
  }
}

}  // namespace fbi::beam
