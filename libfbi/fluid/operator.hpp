/// The element terms of the fluid on one rank: matrix-free residual and tangent on local nodal arrays, in batches of
/// cells.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "fluid/hex8_kernel.hpp"
#include "fluid/linear_cells.hpp"
#include "fluid/parameters.hpp"
#include "fluid/stabilization.hpp"
#include "mesh/hex_mesh.hpp"

namespace fbi::fluid {

/// Sums over the cells of this rank. Nodal arrays hold four unknowns a local node (owned, then ghosts),
/// shape=(nodes,4); results are added to the output, so that ghost rows must be sent to their owners afterwards. Cells
/// are visited in a fixed order, so that sums are reproducible. Nothing here communicates.
class Operator {
 public:
  Operator(const mesh::HexMesh& mesh, const FluidParameters& parameters);

  /// 1/(theta dt) of the step [1/time], and dt [time] (0: steady).
  void set_step(double sigma, double dt) {
    constants_.sigma = sigma;
    dt_ = dt;
  }
  /// Tangents without the derivative of the convecting velocity.
  void set_frozen(bool frozen) { constants_.follow = frozen ? 0.0 : 1.0; }
  /// tau at every cell (or point) from the velocity there (SPEC section 1).
  /// @param u          nodal values
  /// @param max_speed  largest nodal |v| of the whole mesh: cells below 1e-8 of it take e_x as streamline [length/time]
  void update_tau(const double* u, double max_speed);

  /// r += R_cells(u).
  /// @param u     nodal values (v, p)
  /// @param rest  nodal dv/dt - b - sigma v (fourth entry of a node not used)
  void add_residual(const double* u, const double* rest, double* r) const;
  /// y += dR_cells/du (u) x at fixed tau.
  void add_tangent(const double* u, const double* rest, const double* x, double* y) const;
  /// Some option needs terms that LinearCells does not have.
  bool is_extended() const { return extended_; }
  /// Cells and geometry for products in single precision; without a state.
  LinearCells linear_cells() const;
  /// The state of the tangent at u with the present tau and step.
  void linearize(const double* u, const double* rest, LinearCells& linear) const;
  /// add_residual and linearize at the same u, in less time than one after the other.
  void add_residual_and_linearize(const double* u, const double* rest, double* r, LinearCells& linear) const;
  /// Calls visit(cell, m) with the 32 x 32 element tangent of each local cell: m[4 a + i][4 b + j], a, b in hex8 order.
  using ElementMatrix = std::array<std::array<double, 32>, 32>;
  void visit_tangents(const double* u, const double* rest,
                      const std::function<void(Index, const ElementMatrix&)>& visit) const;
  /// Calls visit(cell, m) with int grad N_a . grad N_b of each local cell, m[a][b] in hex8 order.
  using ScalarMatrix = std::array<std::array<double, 8>, 8>;
  void visit_laplacians(const std::function<void(Index, const ScalarMatrix&)>& visit) const;

  /// volume[node] += int N_a over this rank's cells, shape=(nodes).
  void add_lumped_volume(double* volume) const;
  /// int |v|^2 over this rank's cells.
  double velocity_squared(const double* u) const;
  /// int N_a div v and int |grad v|^2 over this rank's cells; the first is added to the fourth entry of each node.
  double add_divergence(const double* u, double* divergence) const;
  /// Largest sum_d |K_d . v|/2 at a cell center of this rank (on boxes sum_i |v_i|/h_i) [1/time].
  double largest_rate(const double* u) const;

  /// tau_M of PSPG at the cell centers, shape=(cells) [time/density].
  const std::vector<double>& tau_pressure() const { return tau_pressure_; }
  /// tau_M of SUPG of a cell (of its first point where tau is taken at the points) [time/density].
  double tau_convection(Index cell) const { return tau(cell / fem::batch_size)->convection[cell % fem::batch_size]; }
  /// tau_C of a cell (of its first point where tau is taken at the points) [viscosity].
  double tau_divergence(Index cell) const { return tau(cell / fem::batch_size)->divergence[cell % fem::batch_size]; }
  /// Coefficient of the pressure projection in a cell, 0 with PSPG [1/viscosity].
  double projection(Index cell) const {
    return constants_.projection ? tau(cell / fem::batch_size)->pressure[cell % fem::batch_size] : 0.0;
  }
  /// Cell volumes, shape=(cells) [length^3].
  const std::vector<double>& volume() const { return volume_; }
  bool is_box() const { return !box_.empty(); }

 private:
  struct CellBatch {
    std::array<std::array<Index, 8>, 8> node;  // [corner bits][lane]; spare lanes repeat the last cell
    int lanes;
  };
  template <class Action>
  void dispatch(const Action& action) const;
  template <class Geometry>
  const std::vector<typename Geometry::Cells>& geometry() const;
  /// What the tangent needs of a batch.
  struct HalfState {
    Batch modes[4][8];     // of v and p
    Batch momentum[3][8];  // r_M at the points
  };
  /// Keeps the state of a batch and of the one before, halves[batch % 2] and the other one, once both are known.
  void keep_state(std::size_t batch, const HalfState* halves, LinearCells& linear) const;
  void gather(const CellBatch& batch, const double* array, Batch (*out)[8]) const;
  void scatter(const CellBatch& batch, const Batch (*in)[8], double* array) const;
  void center_velocity(Index cell, const double* u, double* velocity) const;
  bool convection() const { return parameters_.convective_form != ConvectiveForm::none; }
  int taus_of_batch() const { return constants_.tau_stride > 0 ? 8 : 1; }
  const BatchTau* tau(std::size_t batch) const { return &tau_[batch * taus_of_batch()]; }
  BatchTau* tau(std::size_t batch) { return &tau_[batch * taus_of_batch()]; }
  CellTau tau_of(const double* k, const double* v, double max_speed, const double* xi, double length) const;
  CellTau tau_at_point(Index cell, int q, const double* u, double max_speed) const;

  const mesh::HexMesh& mesh_;
  FluidParameters parameters_;
  KernelConstants constants_;
  bool extended_ = false;  // some option needs Equations::extended
  double dt_ = 0.0;
  std::vector<CellBatch> batches_;
  std::vector<BoxCells> box_;
  std::vector<GeneralCells> general_;
  std::vector<BatchTau> tau_;
  std::vector<double> tau_pressure_;
  std::vector<double> volume_, length_;   // length: V^(1/3)
  std::vector<double> inverse_jacobian_;  // dxi_d/dx_i at the cell center, shape=(cells,3,3)
};

}  // namespace fbi::fluid
