/// Boundary conditions of the fluid on one rank: given velocities, tractions and backflow stabilisation.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <vector>

#include "fluid/parameters.hpp"
#include "mesh/hex_mesh.hpp"

namespace fbi::fluid {

/// Nodal arrays hold four unknowns a local node (owned, then ghosts), shape=(nodes,4).
class Boundaries {
 public:
  /// On shared nodes no_slip beats inflow beats mixed beats slip, component by component; among equals the name that
  /// sorts first wins. Throws Error(usage) for a name the mesh does not have or an incomplete inflow, Error(geometry)
  /// for a slip set with a face that is not normal to an axis. Collective.
  Boundaries(const mesh::HexMesh& mesh, const BoundaryConditions& conditions, double density);
  Boundaries(const Boundaries&) = delete;
  Boundaries& operator=(const Boundaries&) = delete;

  /// 1 for given unknowns, shape=(nodes,4).
  const std::vector<char>& is_dirichlet() const { return is_dirichlet_; }
  /// Some given velocity depends on time, on some rank.
  bool has_timed_velocity() const { return has_timed_velocity_; }
  /// Evaluates velocities and tractions at time t; formulas without t only once. Throws Error(diverged) for a value
  /// that is not finite. Collective.
  void set_time(double t);
  /// u = given values in Dirichlet unknowns.
  void apply(double* u) const;
  /// Largest |u - given value| over Dirichlet unknowns of this rank [length/time].
  double largest_mismatch(const double* u) const;
  /// Some traction of this rank is not zero at the time set.
  bool has_load() const;

  /// r += -int w.h + backflow terms at u.
  void add_residual(const double* u, double* r) const;
  /// y += derivative of the backflow terms in direction x.
  void add_tangent(const double* u, const double* x, double* y) const;
  /// Calls visit(cell, corners, m) with the derivative of the backflow terms of each face: m[3 a + i][3 b + j] for the
  /// face's nodes a, b, which are corners[a], corners[b] of the cell.
  using FaceMatrix = std::array<std::array<double, 12>, 12>;
  using Corners = std::array<int, 4>;
  void visit_tangents(const double* u,
                      const std::function<void(Index, const Corners&, const FaceMatrix&)>& visit) const;

  /// Calls visit(cell, corners, m, area) with m = int N_a N_b for every face whose normal velocity is not given.
  using FaceMass = std::array<std::array<double, 4>, 4>;
  void visit_open_faces(const std::function<void(Index, const Corners&, const FaceMass&, double)>& visit) const;

 private:
  struct Condition {
    std::string name;
    BoundaryCondition data;
  };
  struct FacePoints {  // at the 2 x 2 Gauss points
    std::array<std::array<double, 4>, 4> shape;
    std::array<Vec3, 4> position, normal;  // unit normals, outwards
    std::array<double, 4> weight;
  };
  struct LoadedFace {
    mesh::HexMesh::LocalFace face;
    Index condition;
    std::array<std::array<double, 3>, 4> load{};  // int N_a h
  };
  FacePoints points(const mesh::HexMesh::LocalFace& face) const;
  Index face_node(const mesh::HexMesh::LocalFace& face, int a) const;
  bool leaves_normal_open(const BoundaryCondition& data, const mesh::HexMesh::LocalFace& face) const;
  void evaluate_traction(LoadedFace& face, double t, std::string& error) const;
  template <class T>
  void backflow_face(const FacePoints& points, double beta_density, const T* u, T* r) const;

  const mesh::HexMesh& mesh_;
  double density_;
  std::vector<Condition> conditions_;
  std::vector<char> is_dirichlet_;
  struct Given {
    std::size_t unknown;
    const input::Expression* formula;  // null: zero
    const std::string* name;
  };
  std::vector<Given> given_;  // ascending unknowns
  std::vector<double> given_value_;
  std::vector<LoadedFace> loaded_;
  std::vector<LoadedFace> backflow_;
  std::vector<mesh::HexMesh::LocalFace> open_;
  bool has_timed_velocity_ = false;
  bool evaluated_ = false;
};

}  // namespace fbi::fluid
