/// Normals of slip walls at nodes, and the constraints they make.
#pragma once

#include <vector>

#include "mesh/hex_mesh.hpp"

namespace fbi::fluid {

/// The normals of the smooth pieces of wall that meet at a node: one on a wall, two on an edge, three in a corner.
struct NodeNormals {
  Index node = 0;  ///< local, owned or ghost
  std::vector<Vec3> normals{};
};

/// Unit normals int N_a n / |int N_a n| at every local node of these faces, summed over the faces of each smooth piece
/// of wall around the node: with v_a . n_a = 0 no fluid passes the wall, whatever the other velocities are (Engelman,
/// Sani, Gresho 1982). Faces at a node that meet at less than 45 degrees are one piece; at most three pieces are kept.
/// Ascending nodes; the same on every rank that has the node. Collective.
std::vector<NodeNormals> wall_normals(const mesh::HexMesh& mesh, const std::vector<mesh::HexMesh::LocalFace>& faces);

/// Zero normal velocities of a node that are not along an axis: full_k . v = 0 for each k.
struct NormalConstraint {
  Index node = 0;
  std::vector<Vec3> direction{};  ///< orthonormal, zero in the components that are given
  std::vector<Vec3> full{};       ///< the same with the given components

  /// v without its part along the directions.
  Vec3 without(const Vec3& v) const {
    Vec3 result = v;
    for (const Vec3& d : direction) result -= d.dot(v) * d;
    return result;
  }
};

/// The constraint of these unit normals where the components with given[i] != 0 have values of their own; without
/// directions when nothing is left to constrain.
NormalConstraint make_constraint(const NodeNormals& at, const char* given);

}  // namespace fbi::fluid
