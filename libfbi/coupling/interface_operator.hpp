/// The interface operator S of S lambda = M v - g (SPEC section 4): one small block per fiber or group.
#pragma once

#include <Eigen/LU>
#include <vector>

#include "base/types.hpp"
#include "coupling/coupling.hpp"
#include "mesh/fiber_mesh.hpp"

namespace fbi::coupling {

/// S of every fiber of this rank: kappa/epsilon on the diagonal plus, where fibers move within the same solve, the
/// fiber's own compliance c w D K_b^-1 D^T. Fibers that joints hold together share one block. Entries are ordered (row, direction). Rows without coverage (kappa <= 0)
/// are switched off: their multiplier is zero.
class InterfaceOperator {
 public:
  using Block = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// `penalty` epsilon [force/(length velocity)] per length.
  InterfaceOperator(const mesh::FiberMesh& fibers, double penalty);

  /// S = kappa/epsilon for the present coverage.
  void reset(const Coupling& coupling);
  /// S += factor * compliance for one fiber; compliance has shape=(3*rows,3*rows).
  void add(Index fiber, double factor, const Block& compliance);
  /// The same for a group of joined fibers, rows of its fibers one after the other.
  void add_joined(Index group, double factor, const Block& compliance);
  /// Factorises the blocks that are not diagonal. Returns false when a block is singular or not finite.
  bool factorize();

  /// b <- S^-1 b, shape=(rows,3), switched-off rows to zero.
  void solve(double* b) const;
  /// out = S lambda, shape=(rows,3).
  void apply(const double* lambda, double* out) const;

  bool is_active(Index row) const { return active_[row] != 0; }
  /// True for a fiber without a block of its own: kappa/epsilon, or part of the block of its group.
  bool is_diagonal(Index fiber) const { return blocks_[fiber].size() == 0; }
  /// Dense block of a fiber, empty when diagonal.
  const Block& block(Index fiber) const { return blocks_[fiber]; }
  /// True for a fiber whose rows belong to the block of its group.
  bool is_joined(Index fiber) const { return group_[fiber] >= 0 && groups_[group_[fiber]].block.size() > 0; }
  Index groups() const { return static_cast<Index>(groups_.size()); }
  /// Dense block of a group of joined fibers, empty when its fibers do not move, and the rows it belongs to.
  const Block& joined_block(Index group) const { return groups_[group].block; }
  const std::vector<Index>& joined_rows(Index group) const { return groups_[group].rows; }
  /// Diagonal of a fiber without compliance: kappa/epsilon, shape=(rows).
  const std::vector<double>& diagonal() const { return diagonal_; }
  Index first_row_of(Index fiber) const { return first_row_[fiber]; }
  Index fibers() const { return static_cast<Index>(first_row_.size()) - 1; }
  Index rows() const { return first_row_.back(); }
  double penalty() const { return penalty_; }

 private:
  double penalty_;
  std::vector<Index> first_row_;
  std::vector<double> diagonal_;
  std::vector<char> active_;
  std::vector<Block> blocks_;
  std::vector<Eigen::PartialPivLU<Block>> factors_;
  struct Group {
    std::vector<Index> fibers, rows;
    Block block;
    Eigen::PartialPivLU<Block> factor;
  };
  std::vector<Group> groups_;
  std::vector<Index> group_;  // of each fiber, -1: none
  void solve_joined(double* b) const;
  void apply_joined(const double* lambda, double* out) const;
};

}  // namespace fbi::coupling
