/// The interface operator S of S lambda = M v - g (SPEC section 4): one small block for each row, fiber or group.
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <vector>

#include "base/types.hpp"
#include "coupling/coupling.hpp"
#include "mesh/fiber_mesh.hpp"

namespace fbi::coupling {

/// S of every fiber of this rank: S_p = int Phi_p E^-1 ds of the interface law (kappa/epsilon for a number epsilon), a
/// 3 x 3 matrix for each row, plus, where fibers move within the same solve, the fiber's own compliance
/// c w D K_b^-1 D^T. Fibers that joints hold together share one block. Entries are ordered (row, direction). Rows
/// without coverage (kappa <= 0, or S_p not positive definite, at the ends of partly covered elements) are switched
/// off: their multiplier is zero.
class InterfaceOperator {
 public:
  using Block = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  explicit InterfaceOperator(const mesh::FiberMesh& fibers);

  /// S of the interface law for the present coverage.
  void reset(const Coupling& coupling);
  /// S += factor * compliance for one fiber; compliance has shape=(3*rows,3*rows).
  void add(Index fiber, double factor, const Eigen::Ref<const Block>& compliance);
  /// The same for a group of joined fibers, rows of its fibers one after the other.
  void add_joined(Index group, double factor, const Block& compliance);
  /// Factorises the blocks that join rows. Returns false when a block is singular or not finite.
  bool factorize();

  /// b <- S^-1 b, shape=(rows,3), switched-off rows to zero.
  void solve(double* b) const;
  /// out = S lambda, shape=(rows,3).
  void apply(const double* lambda, double* out) const;

  /// Rows that are switched off to zero, shape=(rows,3).
  void clear_inactive(double* b) const;
  bool is_active(Index row) const { return active_[row] != 0; }
  /// out = S lambda of the interface law alone, shape=(rows,3).
  void apply_law(const double* lambda, double* out) const;
  /// True for a fiber without a block of its own: only the law, or part of the block of its group.
  bool is_local(Index fiber) const { return is_dense_[fiber] == 0; }
  /// Dense block of a fiber that is not local.
  const Block& block(Index fiber) const { return blocks_[fiber]; }
  /// True for a fiber whose rows belong to the block of its group.
  bool is_joined(Index fiber) const { return group_[fiber] >= 0 && groups_[group_[fiber]].block.size() > 0; }
  Index groups() const { return static_cast<Index>(groups_.size()); }
  /// Dense block of a group of joined fibers, empty when its fibers do not move, and the rows it belongs to.
  const Block& joined_block(Index group) const { return groups_[group].block; }
  const std::vector<Index>& joined_rows(Index group) const { return groups_[group].rows; }
  /// S_p of the law, row-major; identity for a row that is switched off, shape=(rows,3,3).
  const std::vector<double>& law() const { return law_; }
  Index first_row_of(Index fiber) const { return first_row_[fiber]; }
  Index fibers() const { return static_cast<Index>(first_row_.size()) - 1; }
  Index rows() const { return first_row_.back(); }

 private:
  using Law = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  Eigen::Map<const Law> law(Index row) const { return Eigen::Map<const Law>(&law_[9 * static_cast<std::size_t>(row)]); }
  /// Adds the law to a dense block of `rows`, and switches rows off.
  void add_law(const Index* rows, Index count, Block& block) const;
  void switch_off(const Index* rows, Index count, Block& block) const;

  std::vector<Index> first_row_;
  std::vector<Index> row_;             ///< 0, 1, ...: rows of one fiber are a part of it
  std::vector<double> law_, inverse_;  ///< shape=(rows,3,3)
  std::vector<char> active_;
  std::vector<char> is_dense_;  ///< of fibers: they have a block since the last reset
  std::vector<Block> blocks_;
  std::vector<Block> inverses_;  ///< of the blocks: products with them are many, and they are small
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
