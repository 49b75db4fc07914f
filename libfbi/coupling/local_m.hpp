/// Assembly of the part of M that belongs to the cells of this rank.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "coupling/coupling.hpp"
#include "coupling/cutting.hpp"

namespace fbi::coupling {

/// Collects M by groups of rows that follow each other: the rows of a fiber element, or the row of an integration
/// point. The last row of a group may be the first row of the next one.
class RowAssembly {
 public:
  /// Starts an empty `m`.
  explicit RowAssembly(LocalM& m);
  /// Starts the group of `count` rows from global row `first` on; firsts must not decrease.
  void begin_group(GlobalIndex first, Index count);
  /// Adds the numbers of a local fluid node, value[p * stride] to row `p` of the group. Sums run in the order of calls.
  void add(Index node, const double* value, Index stride);
  /// Completes the last group.
  void finish();

 private:
  void end_group();
  void write_row(GlobalIndex row, const double* values);

  LocalM& m_;
  GlobalIndex first_ = -1;
  Index count_ = 0;
  // Of the group: a node and the order of its call in one number, values of the rows for each call; sums for each node.
  std::vector<std::uint64_t> calls_;
  std::vector<double> values_, sums_;  ///< shape=(calls,count), (count,nodes)
  std::vector<Index> nodes_;           ///< ascending
  std::vector<std::pair<Index, double>> merged_;
};

/// M by the trace on the center line, over `pieces`, which are sorted by (row, begin): the sums run in that order,
/// whatever the order of arrival. Returns the number of pieces that could not be projected into their cells (0 unless
/// a cell is inverted).
Index assemble_m(const mesh::HexMesh& mesh, const Pieces& pieces, const fem::QuadratureRule& rule, const Basis& basis,
                 LocalM& m);

/// M by the mean over rings around the integration points of `pieces`; the points of a ring may lie in cells of other
/// ranks, those outside the fluid are dropped and the others weigh more. Returns as above. Collective.
Index assemble_ring_m(const mesh::HexMesh& mesh, const Pieces& pieces, const fem::QuadratureRule& rule,
                      const Basis& basis, Cutting& cutting, search::SparseExchange& exchange, LocalM& m);

}  // namespace fbi::coupling
