/// Values of multiplier rows between the ranks of the fibers and the ranks of the cells they cross.
#pragma once

#include <vector>

#include "search/sparse_exchange.hpp"

namespace fbi::coupling {

/// A plan of messages for a fixed set of rows touched by each rank's cells. Rows are numbered by fiber rank.
class RowExchange {
 public:
  /// @param offsets  first global row of each rank, shape=(ranks+1)
  /// @param touched  global rows that this rank's cells touch, ascending
  /// Collective.
  RowExchange(search::SparseExchange& exchange, const std::vector<GlobalIndex>& offsets,
              const std::vector<GlobalIndex>& touched);

  /// owned += the values of all ranks that touch a row, in the order of ranks.
  /// @param touched  shape=(touched rows,components)
  /// @param owned    shape=(rows of this rank,components)
  /// Collective.
  void add_to_owners(const double* touched, int components, double* owned) const;

  /// touched = values of the owners; shapes as above. Collective.
  void copy_from_owners(const double* owned, int components, double* touched) const;

 private:
  struct Owner {
    int rank;
    Index begin, end;  ///< part of the touched rows
  };
  struct Toucher {
    int rank;
    std::vector<Index> rows;  ///< of this rank, ascending
  };
  Comm comm_;
  std::vector<Owner> owners_;      ///< by rank; this rank too
  std::vector<Toucher> touchers_;  ///< by rank; this rank too
};

}  // namespace fbi::coupling
