/// End conditions as projections of the six DoFs of an end node.
#pragma once

#include "base/types.hpp"
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

}  // namespace fbi::beam
