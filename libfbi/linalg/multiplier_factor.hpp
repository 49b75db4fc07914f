/// Approximate inverse of a velocity block with multipliers, (W^-1 + M^T S^-1 M)^-1, by the Woodbury identity.
#pragma once

#include <memory>
#include <vector>

#include "linalg/multiplier_blocks.hpp"
#include "linalg/multiplier_rows.hpp"
#include "linalg/row_overlap.hpp"

namespace fbi::linalg {

/// T = S + M W M^T restricted to this rank's rows, inverted: (W^-1 + M^T S^-1 M)^-1 = W - W M^T T^-1 M W.
///
/// Where all fibers move and no entry of M is negative, T is new with every M, and MultiplierBlocks approximate T^-1.
/// Elsewhere T is symmetrised and factorised by CHOLMOD; a T that is not positive definite is factorised by UMFPACK as
/// it is. With a RowOverlap the factors are those of all its rows. Other coupling between rows of different ranks is
/// added to the diagonal (but to that of blocks for a preconditioner): forces of one direction, which several rows
/// share, are then neither counted once for each rank nor lost. It changes iteration counts and not answers.
class MultiplierFactor {
 public:
  /// What a factor is for: solves, or an iteration with T that it preconditions. `exact`: sparse factors in any case.
  enum class Use { solves, preconditioner, exact };

  MultiplierFactor();
  ~MultiplierFactor();

  /// Returns false when T is singular or not finite.
  bool factorize(MultiplierRows m, const std::vector<InterfaceBlock>& s, Use use = Use::solves);
  /// Frees what there is, so that it is not there beside what comes next.
  void clear();
  /// The same with sparse factors for the rows of an overlap.
  bool factorize(std::unique_ptr<RowOverlap> overlap);
  /// b <- T^-1 b, exact for sparse factors, shape=(rows,3); not after Use::preconditioner. With an overlap for the T of
  /// all ranks, to 1e-3 or as far as 16 steps go: not a linear operation, for flexible methods. Collective then.
  void solve(double* b) const;
  /// The same for an iteration with T: inverses of blocks alone where they stand for factors (Use::preconditioner).
  /// Collective with an overlap.
  void precondition(double* b) const;
  /// Whether MultiplierBlocks stand for the factors and rows of different blocks meet.
  bool is_approximate() const;
  /// Non-zeros of the factors or inverses, for reports.
  GlobalIndex factor_entries() const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace fbi::linalg
