/// Assembly of the part of M that belongs to the cells of this rank.
#pragma once

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
  /// Adds value to the entry (row `p` of the group, local fluid node). Sums run in the order of calls.
  void add(Index p, Index node, double value);
  /// Completes the last group.
  void finish();

 private:
  struct Entry {
    Index row, node;
    double value;
  };
  void end_group();
  void write_row(GlobalIndex row, std::size_t begin, std::size_t end);

  LocalM& m_;
  GlobalIndex first_ = -1;
  Index count_ = 0;
  std::vector<Entry> entries_;  ///< of the group
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
