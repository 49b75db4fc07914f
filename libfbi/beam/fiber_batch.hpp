/// Torsion-free fibers several at a time: one fiber in each lane of a vector.
#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "beam/end_conditions.hpp"
#include "beam/formulation.hpp"
#include "fem/simd.hpp"

namespace fbi::beam {

struct FiberEquations;

/// Fibers of as many nodes that hold the same at the same nodes. Lanes beyond `lanes` repeat the last fiber.
struct FiberBatch {
  using Lanes = fem::Batch;
  struct Support {
    Index node = 0;
    NodeConstraint held;  // its axes are those of one fiber only
    Lanes axis[3];
  };
  int lanes = 0;
  Index nodes = 0;
  std::array<Index, fem::batch_size> fiber{};
  std::array<std::size_t, fem::batch_size> first_dof{};
  ElementPropertiesOf<Lanes> section;
  Lanes shortest;             // element
  std::vector<Lanes> length;  // of the elements
  std::vector<Support> supports;
  /// K_b, then its factors L diag(1/d) L^T: of each row the entries of its own node and of the next one, of which those
  /// right of the diagonal are used; shape=(6 nodes,12).
  std::vector<Lanes> matrix;
  std::array<bool, fem::batch_size> factorized{};  // lanes whose factors may be used
};

/// Residuals, tangents and solves of the fibers for which they can be had in batches: torsion_free without damping,
/// joints, moved supports, moments and follower loads, in the schemes static and generalized_alpha. K_b of these is
/// symmetric, and positive definite but for strong compression: it is factorised without interchanges, and a fiber with
/// a pivot that is not positive is left to FiberEquations (with FiberEquations::downhill: one next to zero).
class FiberBatches {
 public:
  explicit FiberBatches(const FiberEquations& equations);

  /// True for a fiber that belongs to a batch.
  bool has(Index fiber) const { return batch_of_[fiber] >= 0; }
  /// True when the last factors of a fiber are those of its batch.
  bool is_factorized(Index fiber) const {
    return has(fiber) && batches_[batch_of_[fiber]].factorized[static_cast<std::size_t>(lane_of_[fiber])];
  }
  /// Marks the factors of a fiber as made elsewhere.
  void leave(Index fiber) {
    if (has(fiber)) batches_[batch_of_[fiber]].factorized[static_cast<std::size_t>(lane_of_[fiber])] = false;
  }

  /// FiberEquations::evaluate of every fiber that has(); with tangents their factors as well, where is_factorized().
  void evaluate(FiberEquations& equations, bool with_tangent);
  /// FiberEquations::solve of one right-hand side, shape=(nodes,6), for the fibers with is_factorized().
  void solve(double* b) const;
  /// The same for one of them, b of shape=(dofs,columns) row-major.
  void solve(Index fiber, double* b, Index columns) const;
  /// BeamField::compliance of the fibers with is_factorized(): `d` and `rows` of each fiber, shape=(fibers); `take` is
  /// called with the fiber and the block, shape=(3 rows,3 rows) row-major, symmetric.
  void compliance(const std::vector<const double*>& d, const std::vector<Index>& rows,
                  const std::function<void(Index, const double*)>& take) const;

 private:
  std::vector<FiberBatch> batches_;
  std::vector<Index> batch_of_, lane_of_;  // of each fiber, -1: none
};

}  // namespace fbi::beam
