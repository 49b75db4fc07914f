/// The coupling operators D, M and kappa between fibers and fluid (SPEC section 3), for the current fiber positions.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "base/types.hpp"
#include "coupling/parameters.hpp"
#include "coupling/ring.hpp"
#include "mesh/fiber_mesh.hpp"
#include "mesh/hex_mesh.hpp"

namespace fbi::coupling {

/// xx, xy, xz, yy, yz, zz.
using Symmetric = std::array<double, 6>;

/// How well the fibers are covered by fluid cells; sums and extremes over all ranks.
struct Coverage {
  double covered = 0.0;            ///< arc length inside the fluid [length]
  double outside = 0.0;            ///< arc length outside the fluid [length]
  double worst_fraction = 0.0;     ///< largest outside fraction of one fiber
  std::string worst_fiber;         ///< its name
  GlobalIndex fibers_outside = 0;  ///< fibers with an outside part
  GlobalIndex segments = 0;        ///< pieces of fiber elements within one cell
  double identity_error = 0.0;     ///< max over rows of |M.1 - kappa| and |D.1 - kappa|, relative to the largest kappa
};

/// The sparse part of M that this rank's cells contribute: row i of it belongs to multiplier row `row[i]` (global
/// number).
struct LocalM {
  std::vector<GlobalIndex> row;  ///< global multiplier rows touched by cells of this rank, ascending
  std::vector<Index> begin;      ///< shape=(row.size()+1)
  std::vector<Index> node;       ///< local fluid node (owned or ghost)
  std::vector<double> value;     ///< int Phi_p N_r ds
};

/// D, M, kappa and the exchange of multiplier values between the fibers' ranks and the ranks of the cells they cross.
///
/// A multiplier *row* is one scalar basis function Phi_p; the multiplier has three components per row. Rows of a fiber
/// live on the fiber's rank, numbered along it. Lagrange bases have order * elements + 1 rows on a fiber; with
/// Multiplier::gauss_point the rows are the integration points inside the fluid: their number may change with every
/// update.
class Coupling {
 public:
  /// Collective.
  Coupling(const mesh::HexMesh& fluid, const mesh::FiberMesh& fibers, const CouplingParameters& parameters);
  ~Coupling();

  /// Searches, cuts segments and integrates D, M, kappa at positions `dofs`, shape=(fiber nodes,6): x, y, z, tx, ty,
  /// tz. The same dofs give bitwise the same operators, whatever was computed before. Throws Error(geometry) on all
  /// ranks when more of a fiber lies outside than allowed, naming the fiber. Collective.
  void update(const std::vector<double>& dofs);

  /// True when the interface law depends on the stabilisation of the fluid, which set_stabilization must give before
  /// interface_rows is called.
  bool needs_stabilization() const;
  /// tau_M mu/h^2 and tau_C/mu of every local cell; renews the interface law. Collective.
  void set_stabilization(std::vector<CellViscosity> cells);
  /// S_p = int Phi_p E^-1 ds of the interface law, shape=(rows); kappa/epsilon times identity for a number epsilon
  /// [length^2/(force time) length].
  const std::vector<Symmetric>& interface_rows() const;
  bool has_fixed_rows() const;    ///< the number of rows never changes
  Index rows() const;             ///< rows of this rank's fibers
  GlobalIndex first_row() const;  ///< global number of its first row
  GlobalIndex global_rows() const;
  Index first_row_of(Index fiber) const;     ///< local; valid for fiber = fibers() too
  const std::vector<double>& kappa() const;  ///< shape=(rows) [length]
  /// Dense D of one fiber, row-major, shape=(rows of the fiber, 2*nodes of the fiber): columns d_1, t_1, d_2, t_2, ...
  /// with the factor l_ele/2 of the tangent functions included; the same for each direction.
  const std::vector<double>& d_block(Index fiber) const;
  const LocalM& local_m() const;
  const Coverage& coverage() const;

  /// out = M v: nodal holds four values per *local* fluid node (ghosts up to date), the first three being the
  /// velocity; out has shape=(rows,3). T: double or float. Collective.
  template <class T>
  void interpolate(const T* nodal, double* out) const;
  /// nodal += scale * M^T lambda on local nodes, ghosts included (the caller adds ghosts to their owners),
  /// shape=(nodes,4) with nothing added to the fourth entries; lambda has shape=(rows,3). T: double or float.
  /// Collective.
  template <class T>
  void spread(const double* lambda, T* nodal, double scale) const;
  /// out = D q for per-node values q, shape=(fiber nodes,6); out has shape=(rows,3).
  void apply_d(const std::vector<double>& q, double* out) const;
  /// q += scale * D^T lambda, shape=(fiber nodes,6).
  void add_d_transposed(const double* lambda, std::vector<double>& q, double scale) const;
  /// The multiplier field at the nodes of the fibers, shape=(fiber nodes,3), from lambda, shape=(rows,3).
  std::vector<double> at_nodes(const std::vector<double>& lambda) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace fbi::coupling
