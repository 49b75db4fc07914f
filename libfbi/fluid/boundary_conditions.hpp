/// Boundary conditions of the fluid on one rank: given velocities, slip walls, tractions and backflow stabilisation.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "fluid/face_points.hpp"
#include "fluid/parameters.hpp"
#include "fluid/wall_normals.hpp"
#include "mesh/hex_mesh.hpp"

namespace fbi::fluid {

/// Nodal arrays hold four unknowns a local node (owned, then ghosts), shape=(nodes,4).
class Boundaries {
 public:
  /// On shared nodes no_slip beats inflow beats mixed beats slip, component by component; among equals the name that
  /// sorts first wins. Slip walls along the axes give a component; on others the velocity along the normals of the
  /// node is zero, one normal for each smooth piece of wall that meets there. Throws Error(usage) for a name the mesh
  /// does not have or an incomplete inflow. Collective.
  Boundaries(const mesh::HexMesh& mesh, const BoundaryConditions& conditions, double density);
  Boundaries(const Boundaries&) = delete;
  Boundaries& operator=(const Boundaries&) = delete;

  /// 1 for given unknowns, shape=(nodes,4).
  const std::vector<char>& is_dirichlet() const { return is_dirichlet_; }
  /// Given unknowns of owned nodes, ascending.
  const std::vector<std::size_t>& fixed() const { return fixed_; }
  /// Zero normal velocities that are not single components, ascending local nodes.
  const std::vector<NormalConstraint>& constraints() const { return constraints_; }
  /// Some given velocity depends on time, on some rank.
  bool has_timed_velocity() const { return has_timed_velocity_; }
  /// Some condition resists backflow, on whatever rank its faces are.
  bool has_backflow() const;
  /// Evaluates velocities and tractions at time t; formulas without t only once. Throws Error(diverged) for a value
  /// that is not finite. Collective.
  void set_time(double t);
  /// u = given values in Dirichlet unknowns, no velocity along the normals of slip walls.
  void apply(double* u) const;
  /// Takes the parts along the constrained normals out of the first `nodes` local nodes, shape=(nodes,4).
  void remove_normal(double* values, Index nodes) const;
  /// Parts of `to` along the constrained normals = those of `from`, both shape=(nodes,4).
  void set_normal(const double* from, double* to, Index nodes) const;
  /// Largest |u - given value| over Dirichlet unknowns of this rank [length/time].
  double largest_mismatch(const double* u) const;
  /// Some traction of this rank is not zero at the time set.
  bool has_load() const;

  /// r += -int w.h + backflow terms at u.
  void add_residual(const double* u, double* r) const;
  /// Tangents without the derivative of min(v.n, 0).
  void set_frozen(bool frozen) { frozen_ = frozen; }
  /// y += derivative of the backflow terms in direction x.
  void add_tangent(const double* u, const double* x, double* y) const;
  /// Calls visit(cell, corners, m) with the derivative of the backflow terms of each face: m[3 a + i][3 b + j] for the
  /// face's nodes a, b, which are corners[a], corners[b] of the cell.
  using FaceMatrix = std::array<std::array<double, 12>, 12>;
  using Corners = std::array<int, 4>;
  void visit_tangents(const double* u,
                      const std::function<void(Index, const Corners&, const FaceMatrix&)>& visit) const;

  /// A face that carries a condition (a number known to this class).
  struct ConditionedFace {
    mesh::HexMesh::LocalFace face;
    Index condition;
  };
  /// All of them; a face of two sets appears once for each.
  const std::vector<ConditionedFace>& faces() const { return faces_; }
  /// Flow out of this rank's faces sum_a v_a . int N_a n, and its measure sum_a |v_a| |int N_a n| over nodes of given
  /// velocity and over all nodes of faces, each face once [length^3/time]; u of shape=(nodes,4).
  std::array<double, 3> flow(const double* u) const;
  /// Projector on the velocities that this condition holds at corner a of the face: those along which the face can
  /// exert a force that is not known beforehand.
  Mat3 held_directions(const ConditionedFace& face, const FacePoints& at, int a) const;
  /// Calls visit(face, force) with the force of the fluid on what is outside of a face with traction, pressure or
  /// backflow, at each corner [force].
  using FaceForce = std::array<Vec3, 4>;
  void visit_open_forces(const double* u,
                         const std::function<void(const mesh::HexMesh::LocalFace&, const FaceForce&)>& visit) const;

  /// Calls visit(cell, corners, m, area) with m = int N_a N_b for every face whose normal velocity is not given.
  using FaceMass = std::array<std::array<double, 4>, 4>;
  void visit_open_faces(const std::function<void(Index, const Corners&, const FaceMass&, double)>& visit) const;

 private:
  struct Condition {
    std::string name;
    BoundaryCondition data;
  };
  struct LoadedFace {
    mesh::HexMesh::LocalFace face;
    Index condition;
    std::array<std::array<double, 3>, 4> load{};  // int N_a h
  };
  bool leaves_normal_open(const BoundaryCondition& data, const mesh::HexMesh::LocalFace& face) const;
  void take_values_of_masters();
  void evaluate_traction(LoadedFace& face, double t, std::string& error) const;
  template <class T>
  void backflow_face(const FacePoints& points, double beta_density, const T* u, T* r) const;

  const mesh::HexMesh& mesh_;
  double density_;
  std::vector<Condition> conditions_;
  std::vector<char> is_dirichlet_;
  std::vector<std::size_t> fixed_;
  struct Given {
    std::size_t unknown;
    const input::Expression* formula;  // null: zero
    const std::string* name;
  };
  std::vector<Given> given_;  // ascending unknowns
  std::vector<double> given_value_;
  std::vector<NodeNormals> slip_normals_;  // empty when all slip walls lie along the axes
  std::vector<NormalConstraint> constraints_;
  std::vector<ConditionedFace> faces_;
  std::vector<LoadedFace> loaded_;
  std::vector<LoadedFace> backflow_;
  std::vector<mesh::HexMesh::LocalFace> open_;
  bool has_timed_velocity_ = false;
  bool evaluated_ = false;
  bool frozen_ = false;
};

}  // namespace fbi::fluid
