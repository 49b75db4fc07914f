/// Rows of M and blocks of S that belong to a rank.
#pragma once

#include <vector>

#include "base/types.hpp"

namespace fbi::linalg {

/// Rows of M that belong to this rank, complete: row p holds entries [begin[p], begin[p+1]) of `column` and `value`;
/// columns are local to this structure, numbered 0 ... columns-1.
struct MultiplierRows {
  std::vector<Index> begin;  ///< shape=(rows+1)
  std::vector<Index> column;
  std::vector<double> value;
  std::vector<double> weight;  ///< W of every column and direction, shape=(columns,3); zero where the velocity is given
  /// Sum of the entries in a column that belong to rows of other ranks, shape=(columns); empty: there are none.
  std::vector<double> others;
  std::vector<GlobalIndex> name;  ///< the same for a column on all ranks, shape=(columns); empty on one rank
  Index rows() const { return static_cast<Index>(begin.size()) - 1; }
  Index columns() const { return static_cast<Index>(weight.size() / 3); }
};

/// A block of S: rows [first, first + rows), or those listed in `index`, dense with entries ordered (row, direction),
/// or one 3 x 3 matrix for each row when `dense` is null.
struct InterfaceBlock {
  Index first = 0;
  Index rows = 0;
  const double* dense = nullptr;  ///< row-major, shape=(3*rows,3*rows)
  const double* local = nullptr;  ///< row-major, shape=(rows,3,3)
  const Index* index = nullptr;   ///< shape=(rows), rows of a dense block that do not follow each other
};

}  // namespace fbi::linalg
