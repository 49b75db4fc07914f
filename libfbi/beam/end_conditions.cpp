#include "beam/end_conditions.hpp"

namespace fbi::beam {

NodeConstraint::NodeConstraint(EndCondition condition, const Vec3& tangent)
    : position(condition == EndCondition::pinned || condition == EndCondition::clamped),
      along(condition == EndCondition::guided),
      direction(condition == EndCondition::guided || condition == EndCondition::clamped),
      axis(tangent.normalized()),
      force_axis(axis) {}

void NodeConstraint::project(double* x) const { project_node(*this, axis.data(), force_axis.data(), x); }
void NodeConstraint::project_increment(double* x) const { project_node(*this, axis.data(), axis.data(), x); }

void NodeConstraint::project_element(double* matrix, int local) const {
  beam::project_element(*this, axis.data(), force_axis.data(), matrix, local);
}

void NodeConstraint::fill_element(double* matrix, int local, double position_scale, double tangent_scale) const {
  beam::fill_element(*this, axis.data(), matrix, local, position_scale, tangent_scale);
}

}  // namespace fbi::beam
