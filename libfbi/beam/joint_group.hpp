/// What a group of joined fibers keeps (for the parts of Joints).
#pragma once

#include <Eigen/LU>

#include "beam/joints.hpp"

namespace fbi::beam {

/// One node of a joint. The unknowns of a fiber are its DoFs and, with triads, their turns behind them.
struct Place {
  Index fiber = 0;     // of the group
  Index node = 0;      // of this rank
  Index dof = 0;       // of the fiber: its position; the tangent follows
  Index turn = -1;     // unknown of the fiber: first turn of its triad; -1 without
  bool fixed = false;  // of a fiber that does not move
  std::size_t triad() const { return 2 * static_cast<std::size_t>(node); }
};

/// Linear: part of a minus sign times part of b stays what it was at rest.
struct Pair {
  Place a, b;
  int part = 0;  // 0 position, 1 tangent
  double sign = 1.0;
  Vec3 rest = Vec3::Zero();
};

/// One node of a rigid joint: its tangent, or all of its section where there are triads in the joint.
struct Member {
  Place place;
  Vec3 axis, normal[2];             // reference tangent and two normals
  Mat3 section = Mat3::Identity();  // reference triad
  bool whole = false;               // the section is held, not just the tangent
  Index rows() const { return whole ? 3 : 2; }
};

struct RigidJoint {
  std::vector<Member> members;
  int second = -1;  // a member that is not parallel to the first one; -1: none
  int whole = -1;   // a member with a section; -1: none
  Mat3 turn = Mat3::Identity(), turn_n = Mat3::Identity();
  Index rows() const;  // of all members; the turn follows
};

/// R of a joint with the section of a member at rest becomes its triad: the gap log((R G)^T Lambda).
Vec3 section_gap(const RigidJoint& joint, const Member& member, const Quaternion& triad);

/// Entry of L and F: constraint y by unknown `dof` of fiber `fiber` of the group.
struct Term {
  Index fiber, dof, y;
  double left, right;
};

using GroupMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct Joints::State {
  Eigen::VectorXd multiplier;
  std::vector<Mat3> turns;
};

struct Joints::Group {
  std::vector<Index> fibers;           // of this rank
  std::vector<Index> offset;           // first DoF of each in the group's vectors, shape=(fibers+1)
  std::vector<Index> begin;            // first unknown of each in vectors of all unknowns, shape=(fibers+1)
  std::vector<std::size_t> first_dof;  // of each in nodal fields
  std::vector<Pair> pairs;
  std::vector<RigidJoint> rigid;
  std::vector<Place> springs[3];  // positions, tangents and triads that get springs in statics
  Eigen::VectorXd multiplier, found;
  // of the last factorisation
  std::vector<Term> terms;  // by fiber
  Eigen::MatrixXd q;
  Eigen::VectorXd gap;
  std::vector<std::vector<Index>> touched;  // y of each fiber
  std::vector<GroupMatrix> x;               // K^-1 F of each fiber, columns `touched`
  Eigen::PartialPivLU<Eigen::MatrixXd> schur;
  std::vector<double> found_turns;  // of the last solve for center lines, shape=(unknowns)

  Index size() const { return static_cast<Index>(multiplier.size()); }
  Index first_rigid() const { return 3 * static_cast<Index>(pairs.size()); }
  void count();
  void fit(const FiberEquations& equations, bool at_start);
  void linearize(const FiberEquations& equations, bool with_springs);
  Eigen::VectorXd joint_forces(const FiberEquations& equations) const;
  void share_initial_rates(FiberEquations& equations) const;
  void close_gaps(std::vector<double>& x, const Eigen::VectorXd& gaps);
  static Index unknown(const Place& place, int part) { return part < 2 ? place.dof + 3 * part : place.turn; }
};

/// Position (part 0) or tangent (part 1) of a node in a nodal field.
inline Vec3 nodal_vector(const NodalField& field, Index node, int part) {
  return Eigen::Map<const Vec3>(&field[6 * static_cast<std::size_t>(node) + 3 * part]);
}

}  // namespace fbi::beam
