/// External loads of the fibers of this rank: dead nodal forces and end moments.
#pragma once

#include <vector>

#include "base/types.hpp"
#include "beam/parameters.hpp"
#include "mesh/fiber_mesh.hpp"

namespace fbi::beam {

/// Loads at one time.
struct LoadValues {
  std::vector<double> dead;                 ///< generalised forces that do not follow the fiber, shape=(nodes,6)
  std::vector<std::array<Vec3, 2>> moment;  ///< at start and end of each fiber [force length]
};

/// Gravity rho_b A g, line loads, end forces and end moments of all fibers that have equations.
class Loads {
 public:
  /// Loads that depend neither on time nor on a load factor are integrated here once.
  Loads(const mesh::FiberMesh& fibers, const std::vector<FiberParameters>& groups, const Vec3& gravity);

  /// Loads at time `t`, all multiplied by `factor`. Line loads are integrated against the Hermite functions with five
  /// Gauss points an element; all expressions see the reference position.
  void evaluate(double t, double factor, LoadValues& values) const;

 private:
  void add_load(Index fiber, const Load& load, double t, std::vector<double>& dead) const;

  const mesh::FiberMesh& fibers_;
  const std::vector<FiberParameters>& groups_;
  std::vector<double> constant_;  // dead loads without time, shape=(nodes,6)
};

/// Generalised force of an end moment m on the tangent DoF t: m x t/|t|^2, so that its work is m . (t x delta t)/|t|^2,
/// m times the rotation of the tangent.
Vec3 moment_force(const Vec3& moment, const Vec3& tangent);
/// Derivative of `moment_force` by t, not symmetric.
Mat3 moment_force_tangent(const Vec3& moment, const Vec3& tangent);

}  // namespace fbi::beam
