/// Approximate inverse of T = S + M W M^T by its dense blocks, one for each fiber.
#pragma once

#include <vector>

#include "linalg/block_inverses.hpp"
#include "linalg/multiplier_rows.hpp"

namespace fbi::linalg {

/// T = D - (L - E): E couples rows of different blocks, L is the diagonal of its row sums, D = blocks + L. Two steps of
///   y <- D^-1 (b + (L - E) y),  y = D^-1 b to begin with,
/// are as good as factors of T where rows do not cancel each other, and what they cost does not grow when fibers come
/// to lie across each other. Motion that the rows of all blocks share is exact in every step, since (L - E) takes it to
/// zero; the entries of M are not negative, so L - E is positive semi-definite and the steps converge. Coupling to rows
/// of other ranks is in D alone. As a preconditioner the blocks do better without L and rows of other ranks.
class MultiplierBlocks {
 public:
  /// True where every row has its dense block of S and no entry of M is negative beyond round-off.
  static bool suits(const MultiplierRows& m, const std::vector<InterfaceBlock>& s);
  /// Returns false when a block is singular or not finite. `m` and `s` must suit. Cost: the inverses of the blocks.
  /// @param alone  D without L and rows of other ranks, for solve() without steps: the better preconditioner
  bool factorize(MultiplierRows m, const std::vector<InterfaceBlock>& s, bool alone = false);
  /// b <- about T^-1 b, shape=(rows,3), by `steps` of the iteration after b <- D^-1 b.
  void solve(double* b, int steps = 2);
  /// True where no column has rows of different blocks.
  bool is_exact() const { return !couples_; }
  /// Entries of the inverses.
  GlobalIndex entries() const { return static_cast<GlobalIndex>(inverses_.size()); }

 private:
  struct Block {
    Index count = 0;          // of rows
    Index first = 0;          // row, where `rows` is empty
    std::vector<Index> rows;  // rows that do not follow each other
    Index row(Index i) const { return rows.empty() ? first + i : rows[i]; }
  };
  void couple_own(const std::vector<Index>& column_begin, const std::vector<Index>& column_row,
                  const std::vector<double>& column_value, const std::vector<Index>& block_of);
  /// L, and what rows of other ranks add to the diagonal, shape=(rows,3).
  std::vector<double> lump(const std::vector<double>& column_total);
  bool invert_blocks(const std::vector<InterfaceBlock>& s, const std::vector<double>& others);
  void apply_inverses(const double* b, double* x);
  void add_others(const double* y, double* r);

  MultiplierRows m_;
  std::vector<Block> blocks_;
  std::vector<double> inverses_;  // columns of one block's D^-1 after the other
  bool couples_ = false;          // rows of different blocks meet in some column
  // M W M^T between rows of one block: row p holds [own_begin_[p], own_begin_[p+1]).
  std::vector<Index> own_begin_, own_row_;
  std::vector<double> own_value_;           // shape=(entries,3)
  std::vector<double> lumped_;              // L, shape=(rows,3)
  std::vector<double> right_, sum_, part_;  // work
  // What rows tell each other through the columns, in single precision: shape=(entries), (columns,4), (columns,4).
  std::vector<float> value_, weight_, spread_;
};

}  // namespace fbi::linalg
