/// Forces and moments of the fluid on named parts of its boundary, from the nodal balances.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "fluid/face_points.hpp"
#include "fluid/fluid_field.hpp"

namespace fbi::fluid {

/// Faces whose forces are summed.
struct ForceSet {
  std::vector<std::string> faces;  ///< names of face sets
  Vec3 about = Vec3::Zero();       ///< point that the moment is taken about [length]
};

/// What the fluid exerts on a set of faces.
struct BoundaryForce {
  Vec3 force = Vec3::Zero();   ///< [force]
  Vec3 moment = Vec3::Zero();  ///< [force length]
};

/// Consistent forces: F_a = -(R_a + (M^T lambda)_a), with R_a the cells' part of the momentum equations tested with the
/// shape function of boundary node a. This is the force that makes the discrete balances of momentum and angular
/// momentum exact, and it converges faster than stresses integrated over the wall (Gresho, Lee, Sani, Leone 1987).
///
/// At a node of several faces each face gets what is known of it - traction, pressure boundary value and backflow on
/// open faces, int N_a p n along the directions it holds on walls - and the rest is split among the faces that hold
/// the velocity there, by area and direction. So the forces of all faces add up to the total, the tangential force on
/// a slip wall is zero, and a no-slip wall that ends at a slip plane keeps its own friction.
class BoundaryForces {
 public:
  /// Throws Error(usage) for a name the mesh does not have. Collective.
  BoundaryForces(const FluidField& field, std::vector<ForceSet> sets);

  /// Forces on each set.
  /// @param u        velocity and pressure, ghosts up to date
  /// @param balance  FluidField::internal_forces plus M^T lambda in all rows, ghosted; its ghosts are renewed
  /// Collective.
  std::vector<BoundaryForce> evaluate(Vec u, Vec balance) const;

 private:
  /// Index of each set that holds this face.
  std::vector<std::size_t> sets_of(const mesh::HexMesh::LocalFace& face) const;

  const FluidField& field_;
  std::vector<ForceSet> sets_;
  std::vector<std::vector<std::pair<Index, Index>>> members_;  // of each set: (cell, face), sorted
  std::vector<Mat3>
      share_;  // inverse of sum int N_a (held directions), shape=(local nodes); zero where nothing is held
};

}  // namespace fbi::fluid
