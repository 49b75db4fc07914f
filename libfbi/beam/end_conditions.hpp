/// End conditions as projections of the six DoFs of an end node.
#pragma once

#include "base/types.hpp"
#include "beam/formulation.hpp"
#include "beam/parameters.hpp"

namespace fbi::beam {

/// What is held at one node: P x removes it, P = diag(0, I - g g^T or I, I or g g^T) with g the reference tangent.
///
/// Guided ends hold the direction and the position along it (0, a sliding clamp across the fiber). Clamped ends keep
/// the direction of the tangent: its components normal to g are zero, the stretch along g stays free.
struct NodeConstraint {
  bool position = false;
  bool along = false;  ///< of the position only the part along g
  bool direction = false;
  Vec3 axis = Vec3::Zero();  ///< g, unit vector
  /// Where g turns during a step: that of the level at which forces balance. Forces are tested with it, increments lie
  /// along `axis`; reactions of the mean of both ends have no part along it up to the second order of the step.
  Vec3 force_axis = Vec3::Zero();

  NodeConstraint() = default;
  NodeConstraint(EndCondition condition, const Vec3& tangent);

  bool active() const { return position || along || direction; }
  /// P x in place for a force, x of shape=(6).
  void project(double* x) const;
  /// P x in place for an increment.
  void project_increment(double* x) const;
  /// Replaces the rows and columns of node `local` (0 or 1) of an element matrix, shape=(12,12) row-major, by P K P.
  void project_element(double* matrix, int local) const;
  /// Adds s (I - P) to them, s the largest diagonal entry of each kind before projection, so that the matrix stays
  /// regular.
  void fill_element(double* matrix, int local, double position_scale, double tangent_scale) const;
};

/// NodeConstraint::project(x) by what `c` holds, with g = `axis` and the axis `test` that the stretch is taken along,
/// shape=(3) each. T: double, or a batch of nodes that hold the same.
template <class T>
void project_node(const NodeConstraint& c, const T* axis, const T* test, T* x) {
  if (c.position) x[0] = x[1] = x[2] = 0.0;
  if (c.along) {
    const T held = axis[0] * x[0] + axis[1] * x[1] + axis[2] * x[2];
    for (int k = 0; k < 3; ++k) x[k] -= held * axis[k];
  }
  if (c.direction) {
    const T stretch = test[0] * x[3] + test[1] * x[4] + test[2] * x[5];
    for (int k = 0; k < 3; ++k) x[3 + k] = stretch * axis[k];
  }
}

/// NodeConstraint::project_element in the same way, `test` for forces.
template <class T>
void project_element(const NodeConstraint& c, const T* axis, const T* test, T* matrix, int local) {
  if (!c.active()) return;
  for (int i = 0; i < element_dofs; ++i) project_node(c, axis, axis, matrix + element_dofs * i + 6 * local);
  for (int i = 0; i < element_dofs; ++i) {
    T column[6];
    for (int k = 0; k < 6; ++k) column[k] = matrix[element_dofs * (6 * local + k) + i];
    project_node(c, axis, test, column);
    for (int k = 0; k < 6; ++k) matrix[element_dofs * (6 * local + k) + i] = column[k];
  }
}

/// NodeConstraint::fill_element in the same way.
template <class T>
void fill_element(const NodeConstraint& c, const T* axis, T* matrix, int local, const T& position_scale,
                  const T& tangent_scale) {
  for (int k = 0; k < 3; ++k) {
    if (c.position) matrix[(element_dofs + 1) * (6 * local + k)] += position_scale;
    for (int l = 0; l < 3; ++l) {
      if (c.along) matrix[element_dofs * (6 * local + k) + 6 * local + l] += position_scale * axis[k] * axis[l];
      if (!c.direction) continue;
      matrix[element_dofs * (6 * local + 3 + k) + 6 * local + 3 + l] +=
          tangent_scale * ((k == l ? 1.0 : 0.0) - axis[k] * axis[l]);
    }
  }
}

}  // namespace fbi::beam
