/// Rows of multipliers of other ranks that meet this rank's rows, for factors that know both.
#pragma once

#include <vector>

#include "base/comm.hpp"
#include "linalg/multiplier_rows.hpp"

namespace fbi::linalg {

/// This rank's rows of M and blocks of S, followed by those blocks of other ranks whose rows share a column of M with
/// them: restricted additive Schwarz with one layer of blocks (Cai, Sarkis 1999). Values go to ranks that share columns
/// alone, in messages whose sizes do not depend on the number of ranks; to begin with five exchanges of all ranks.
class RowOverlap {
 public:
  /// Brings the blocks of other ranks. Dense blocks of more than 256 rows stay where they are and are in `others`
  /// there. Collective.
  /// @param own     with the names of its columns
  /// @param s       one block for each own row, at most
  /// @param begins  names [begins[r], begins[r+1]) are those for which rank r knows who has the column,
  ///                shape=(ranks+1)
  RowOverlap(const Comm& comm, const MultiplierRows& own, const std::vector<InterfaceBlock>& s,
             const std::vector<GlobalIndex>& begins);

  /// Own rows, then those of other ranks in the order of ranks; `others` is what is in neither.
  const MultiplierRows& rows() const { return rows_; }
  /// Blocks of S of these rows.
  const std::vector<InterfaceBlock>& blocks() const { return blocks_; }
  /// Frees rows and blocks, which bring() does not need.
  void release();
  const Comm& comm() const { return comm_; }
  Index own_rows() const { return own_rows_; }
  /// Values of all rows, shape=(rows,3), from those of own rows, shape=(own rows,3); there until the next call, to be
  /// overwritten. Collective.
  std::vector<double>& bring(const double* own);

 private:
  struct Neighbor {
    int rank = 0;
    std::vector<Index> leaving;     // own rows
    Index first = 0, arriving = 0;  // rows that come from there
  };
  /// The ranks that share columns with this one and the blocks that each of them gets. Collective.
  void find_neighbors(const MultiplierRows& own, const std::vector<InterfaceBlock>& s,
                      const std::vector<GlobalIndex>& begins, std::vector<std::vector<Index>>& blocks_for);
  Neighbor& neighbor(int rank);

  Comm comm_;
  Index own_rows_ = 0;
  MultiplierRows rows_;
  std::vector<InterfaceBlock> blocks_;
  std::vector<double> numbers_;  // of S in arrived blocks
  std::vector<Neighbor> neighbors_;
  std::vector<double> values_;
  std::vector<std::vector<double>> sent_;
};

}  // namespace fbi::linalg
