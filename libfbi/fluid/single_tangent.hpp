/// The tangent of the fluid in single precision, for the many products of one linear solve.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "fluid/boundary_conditions.hpp"
#include "fluid/halo.hpp"
#include "fluid/linear_cells.hpp"
#include "fluid/operator.hpp"

namespace fbi::fluid {

/// Products with the tangent of FluidField, restricted to free unknowns: entries of x in Dirichlet unknowns and along
/// the normals of slip walls are taken for zero, those of the result are zero. Sixteen cells at once, with velocity
/// modes and momentum residual at the points kept from the linearisation (192 bytes a cell). Arrays hold all local
/// nodes, shape=(nodes,4).
///
/// Not for equations with `extended` terms: see Operator::is_extended.
class SingleTangent {
 public:
  /// Everything passed must outlive this object. Collective.
  SingleTangent(const mesh::HexMesh& mesh, const Operator& cells, const Boundaries& boundaries);

  /// Takes the tangent at u (nodal values, ghosts up to date) with the tau and the step of `cells`.
  void linearize(const double* u, const double* rest);
  /// The same with the residual of the cells, r += R_cells(u), which costs less together.
  void linearize_with_residual(const double* u, const double* rest, double* r);
  /// Factor of the continuity rows of all results; 1 if never called.
  void set_continuity_scale(double scale) { linear_.continuity_scale = static_cast<float>(scale); }

  const Halo& halo() const { return halo_; }
  /// Takes the parts along the normals of slip walls out of the first `nodes` nodes.
  void remove_normal(float* values, Index nodes) const;

  /// y = pressure columns times the fourth entries of x, complete on owned nodes; x has its ghosts. Collective.
  void apply_to_pressure(const float* x, float* y) const;
  /// y += velocity columns times the first three entries of x, and what `add` adds to local nodes; otherwise the same,
  /// with zeros in x where it is not free. Collective.
  void add_velocity(const float* x, float* y, const std::function<void(float*)>& add) const;

 private:
  struct FaceTangent {
    std::array<Index, 4> node;
    std::array<std::array<float, 12>, 12> matrix;
  };
  void finish(float* y) const;
  void linearize_faces(const double* u);

  const mesh::HexMesh& mesh_;
  const Operator& operator_;
  const Boundaries& boundaries_;
  Halo halo_;
  LinearCells linear_;
  std::vector<FaceTangent> faces_;
};

}  // namespace fbi::fluid
