/// Exact solution of the Laplacian of trilinear elements on a tensor-product box, by fast diagonalisation.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "linalg/pressure_solver.hpp"
#include "mesh/hex_mesh.hpp"

namespace fbi::linalg {

/// Solves L x = b with L = K1 x M2 x M3 + M1 x K2 x M3 + M1 x M2 x K3 (Kronecker products of one-dimensional stiffness
/// and mass matrices of linear elements), the hex8 Laplacian on a box (Lynch, Rice, Thomas 1964).
///
/// The two directions that no rank boundary cuts are diagonalised (Q^T M Q = I, Q^T K Q = diag), the remaining
/// direction is one tridiagonal system per pair of modes. Ranks own slabs of whole planes; modes are exchanged so that
/// each rank solves whole lines: two messages to every other rank and solve, no rank holds more than its share.
class TensorPoisson : public PressureSolver {
 public:
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// `robin[d][e]` is added to K_d at the low (e = 0) or high end [1/length], 0 = natural condition. All zero: the
  /// constant is in the kernel; right-hand sides are made compatible and solutions get an arbitrary level. Collective.
  /// `factor[d][i]` multiplies the stiffness of interval i along direction d; empty: 1.
  TensorPoisson(const mesh::HexMesh& mesh, const std::array<std::array<double, 2>, 3>& robin,
                const std::array<std::vector<double>, 3>& factor = {});

  /// True when the mesh is a box without periodic faces and every rank owns whole planes of nodes. The same on all
  /// ranks. Collective.
  static bool supports(const mesh::HexMesh& mesh);

  /// x = L^-1 b; vectors hold one number per owned node. Collective.
  using PressureSolver::apply;
  void apply(Vec b, Vec x) override;

 protected:
  std::pair<VecHandle, VecHandle> create_vectors() const override;

 private:
  struct Line {  // one direction: tridiagonal stiffness and mass
    std::vector<double> k_diagonal, k_off, m_diagonal, m_off;
  };
  static Line make_line(const std::vector<double>& coordinates, const std::array<double, 2>& robin,
                        const std::vector<double>& factor);

  Comm comm_;
  int axis_ = 0;           // direction of the tridiagonal systems
  Index planes_ = 0;       // of this rank along axis_
  Index n1_ = 0, n2_ = 0;  // nodes along the other two
  GlobalIndex nodes_ = 0;
  bool singular_ = false;
  std::vector<Index> position_;  // of each owned node in the (plane, 1, 2) order
  Matrix q1_, q2_;
  std::vector<int> send_count_, send_begin_, receive_count_, receive_begin_;
  Index first_mode_ = 0, modes_ = 0;  // this rank's
  Line line_;
  std::vector<double> eigenvalue_;     // of this rank's modes
  std::vector<double> inverse_pivot_;  // shape=(nodes along axis_,modes)
  std::vector<double> field_, lines_, sent_;
};

}  // namespace fbi::linalg
