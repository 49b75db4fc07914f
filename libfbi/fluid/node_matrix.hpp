/// Sparse matrices over pairs of nodes that share a cell: pattern, local sums and the PETSc matrix.
#pragma once

#include <cstddef>
#include <vector>

#include "fluid/wall_normals.hpp"
#include "linalg/petsc.hpp"
#include "mesh/hex_mesh.hpp"

namespace fbi::fluid {

/// An AIJ matrix with b x b blocks on the node pairs of a mesh. Element contributions are summed on this rank first
/// (rows of ghosts included) and sent to their owners by `finish`; the order of all sums is fixed.
class NodeMatrix {
 public:
  NodeMatrix(const mesh::HexMesh& mesh, int block);

  /// Sets all entries to zero.
  void clear();
  /// Entry (i, j) of the block of corners a, b of a local cell, to add to.
  double& entry(Index cell, int a, int b, int i, int j) {
    return values_[block_ * block_ * position_[64 * static_cast<std::size_t>(cell) + 8 * a + b] + block_ * i + j];
  }
  /// Identity in the rows, zero in the columns of the unknowns with is_dirichlet = 1, shape=(local nodes, block).
  void set_dirichlet(const std::vector<char>& is_dirichlet);
  /// Takes the constrained normals out of rows and columns of these nodes and puts the identity there; block >= 3.
  /// Before set_dirichlet.
  void set_normals(const std::vector<NormalConstraint>& constraints);
  /// The matrix with the values summed so far. Every call returns the same PETSc object with new values. Collective.
  linalg::MatHandle finish();

 private:
  const mesh::HexMesh& mesh_;
  std::size_t block_;
  std::vector<std::size_t> row_start_;  // by local node
  std::vector<Index> column_;           // local node
  std::vector<std::size_t> position_;   // of the pair (a, b) of each cell, shape=(cells,8,8)
  std::vector<double> values_;          // shape=(pairs, block, block)
  linalg::MatHandle matrix_;
};

}  // namespace fbi::fluid
