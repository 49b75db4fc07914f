/// External loads of the fibers of this rank: dead nodal forces, and forces and moments that follow the fiber.
#pragma once

#include <vector>

#include "base/types.hpp"
#include "beam/parameters.hpp"
#include "mesh/fiber_mesh.hpp"

namespace fbi::beam {

/// A force or moment at one point of an element whose generalised force depends on the configuration.
struct PointLoad {
  Index element = 0;  ///< of the fiber
  double x = 0.0;     ///< place in the element, in [-1, 1]
  Vec3 value = Vec3::Zero();
  bool moment = false;
  bool follower = false;
};

/// Loads at one time.
struct LoadValues {
  std::vector<double> dead;                   ///< generalised forces that do not follow the fiber, shape=(nodes,6)
  std::vector<std::vector<PointLoad>> point;  ///< of each fiber: every moment, and follower forces
};

/// Directions that follower loads have turned to: of each node a unit normal e and the unit tangent t, both carried
/// along by the smallest rotations step after step, shape=(nodes,6).
struct Frames {
  std::vector<double> reference, last;
  /// Sets both to the reference tangents.
  void initialize(const mesh::FiberMesh& fibers);
  /// The rotation that carried the frame of `node` from the reference to t_n, applied to v.
  Vec3 carry(Index node, const Vec3& v) const;
  Vec3 tangent(Index node) const { return Vec3(&last[6 * static_cast<std::size_t>(node) + 3]); }
  /// Turns the frame of `node` to the direction of `tangent`.
  void advance(Index node, const Vec3& tangent);
};

/// Weight, line loads, point forces and moments of all fibers that have equations.
class Loads {
 public:
  /// Loads that depend neither on time nor on a load factor are integrated here once. The weight of a fiber is
  /// (rho_b - rho_f) A g per length with rho_f = FiberParameters::displaced_density.
  Loads(const mesh::FiberMesh& fibers, const std::vector<FiberParameters>& groups, const Vec3& gravity);

  /// Loads at time `t`, all multiplied by `factor`. Line loads are integrated against the Hermite functions with five
  /// Gauss points an element; all expressions see the reference position.
  void evaluate(double t, double factor, LoadValues& values) const;
  /// Some group of the case has follower loads: the same on every rank.
  bool has_followers() const;

 private:
  struct Place {
    Index element;
    double x;
    Vec3 position;
  };
  Place place_of(Index fiber, const Load& load) const;
  void add_load(Index fiber, const Load& load, double t, LoadValues& values) const;

  const mesh::FiberMesh& fibers_;
  const std::vector<FiberParameters>& groups_;
  LoadValues constant_;  // loads without time
};

/// Generalised force of a moment m on the tangent t: m x t/|t|^2, so that its work is m . (t x delta t)/|t|^2, m times
/// the rotation of the tangent.
Vec3 moment_force(const Vec3& moment, const Vec3& tangent);
/// Derivative of `moment_force` by t, not symmetric.
Mat3 moment_force_tangent(const Vec3& moment, const Vec3& tangent);

/// Generalised force of a point load on an element of length `length` with nodes `node` and node+1 of this rank:
/// force, shape=(12), and its derivative by the DoFs q, shape=(12,12) row-major, or null. `frames` is used by
/// followers.
void point_load_force(const PointLoad& load, double length, const Frames& frames, Index node, const double* q,
                      double* force, double* derivative);

}  // namespace fbi::beam
