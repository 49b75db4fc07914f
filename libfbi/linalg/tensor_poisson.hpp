/// Exact solution of the Laplacian of trilinear elements on a tensor-product box, by fast diagonalisation.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "linalg/block_exchange.hpp"
#include "linalg/line_solver.hpp"
#include "linalg/line_transform.hpp"
#include "linalg/pressure_solver.hpp"
#include "mesh/hex_mesh.hpp"

namespace fbi::linalg {

/// Solves L x = b with L = K1 x M2 x M3 + M1 x K2 x M3 + M1 x M2 x K3 (Kronecker products of one-dimensional stiffness
/// and mass matrices of linear elements), the hex8 Laplacian on a box (Lynch, Rice, Thomas 1964).
///
/// Two directions are diagonalised (Q^T M Q = I, Q^T K Q = diag), the remaining one, the axis, is one tridiagonal
/// system per pair of modes. Ranks that own slabs along the axis exchange separator planes only. Other blocks are
/// first sent to a grid of ranks, planes along the axis times lines of one other direction, and once more between the
/// two transforms. No rank holds more than its share; messages go to the ranks of one row or column of that grid and
/// to those whose blocks intersect.
class TensorPoisson : public PressureSolver {
 public:
  /// `robin[d][e]` is added to K_d at the low (e = 0) or high end [1/length], 0 = natural condition. All zero: the
  /// constant is in the kernel; right-hand sides are made compatible and solutions get an arbitrary level. Collective.
  /// `factor[d][i]` multiplies the stiffness of interval i along direction d; empty: 1.
  TensorPoisson(const mesh::HexMesh& mesh, const std::array<std::array<double, 2>, 3>& robin,
                const std::array<std::vector<double>, 3>& factor = {});

  /// True when the mesh is a box without periodic faces, every rank owns a block of nodes, and the box is not so wide
  /// that multigrid is faster. The same on all ranks. Collective.
  static bool supports(const mesh::HexMesh& mesh);

  /// x = L^-1 b; vectors hold one number per owned node. Collective.
  void apply(Vec b, Vec x) override;
  /// The same on arrays, shape=(owned nodes), which must differ; in single precision all of the work is done in it.
  /// The tables of each precision are made when it is first used. Collective.
  void apply(const double* b, double* x);
  void apply(const float* b, float* x) override;

 private:
  template <class Real>
  struct Tables {
    LineTransform<Real> first, second;  // along the second and the first of the other two directions
    BlockExchange<Real> gather, turn;
    std::unique_ptr<LineSolver<Real>> lines;
    std::vector<Real> field, turned;
  };
  template <class Real>
  void make(std::unique_ptr<Tables<Real>>& tables) const;
  template <class Real>
  void solve(std::unique_ptr<Tables<Real>>& tables, const Real* b, Real* x);
  void choose_grid(const std::vector<IndexBlock>& owned);

  Comm comm_;
  GlobalIndex nodes_ = 0;
  Index owned_ = 0;
  bool singular_ = false;
  int axis_ = 0;              // direction of the tridiagonal systems
  int d1_ = 1, d2_ = 2;       // the other two
  std::array<Index, 3> n_{};  // nodes of the box
  LineMatrices line_;         // along the axis
  struct Modes {              // of one direction
    LineTransform<double>::Matrix q;
    std::vector<double> eigenvalue;
    bool mirrored = false;
  };
  static Modes diagonalise(const LineMatrices& line);
  Modes modes1_, modes2_;
  // Owned nodes; whole lines along d2_; the same with whole lines along d1_ and modes in place of d2_.
  BlockLayout owned_layout_, first_layout_, second_layout_;
  PlaneGroup group_;
  std::unique_ptr<Tables<double>> double_;
  std::unique_ptr<Tables<float>> float_;
};

}  // namespace fbi::linalg
