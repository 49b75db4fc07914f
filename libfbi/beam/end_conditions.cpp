#include "beam/end_conditions.hpp"

#include "beam/formulation.hpp"

namespace fbi::beam {

NodeConstraint::NodeConstraint(EndCondition condition, const Vec3& tangent)
    : position(condition != EndCondition::free),
      direction(condition == EndCondition::clamped),
      axis(tangent.normalized()) {}

void NodeConstraint::project(double* x) const {
  if (position) x[0] = x[1] = x[2] = 0.0;
  if (direction) {
    const double along = axis[0] * x[3] + axis[1] * x[4] + axis[2] * x[5];
    for (int k = 0; k < 3; ++k) x[3 + k] = along * axis[k];
  }
}

void NodeConstraint::project_element(double* matrix, int local) const {
  if (!active()) return;
  for (int i = 0; i < element_dofs; ++i) project(matrix + element_dofs * i + 6 * local);
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
    if (!direction) continue;
    for (int l = 0; l < 3; ++l)
      matrix[element_dofs * (6 * local + 3 + k) + 6 * local + 3 + l] +=
          tangent_scale * ((k == l ? 1.0 : 0.0) - axis[k] * axis[l]);
  }
}

}  // namespace fbi::beam
