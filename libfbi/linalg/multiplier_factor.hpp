/// Approximate inverse of a velocity block with multipliers, (W^-1 + M^T S^-1 M)^-1, by the Woodbury identity.
#pragma once

#include <Eigen/Core>
#include <memory>
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

/// Sparse factors of T = S + M W M^T restricted to this rank's rows: (W^-1 + M^T S^-1 M)^-1 = W - W M^T T^-1 M W.
///
/// T is symmetrised and factorised by CHOLMOD; a T that is not positive definite is factorised by UMFPACK as it is.
/// Coupling between rows of different ranks is added to the diagonal: forces of one direction, which several rows
/// share, are then neither counted once for each rank nor lost. It changes iteration counts and not answers.
class MultiplierFactor {
 public:
  MultiplierFactor();
  ~MultiplierFactor();

  /// Returns false when T is singular or not finite. Cost: one sparse product per direction and one factorisation.
  bool factorize(const MultiplierRows& m, const std::vector<InterfaceBlock>& s);
  /// b <- T^-1 b, shape=(rows,3).
  void solve(double* b) const;
  /// Non-zeros of the factors, for reports.
  GlobalIndex factor_entries() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace fbi::linalg
