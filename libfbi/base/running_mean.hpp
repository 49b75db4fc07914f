/// Weighted mean and covariance of velocity and pressure at nodes, renewed sample by sample.
#pragma once

#include <vector>

#include "base/types.hpp"

namespace fbi {

/// Of samples (v, p)_k with weights w_k, W = sum_k w_k: the means sum_k w_k v_k/W and sum_k w_k p_k/W, and the
/// covariance of the velocity R = sum_k w_k v'_k v'_k^T/W with v'_k = v_k - mean (the Reynolds stress over the density,
/// with the opposite sign).
///
/// The update is that of Welford (Technometrics 4, 1962) with weights (West, Comm. ACM 22, 1979): no difference of
/// large numbers is taken, however small the fluctuations are.
struct RunningMean {
  static constexpr int components = 10;                         ///< of a row of `values`
  static constexpr int velocity = 0, pressure = 3, stress = 4;  ///< first components of each quantity

  explicit RunningMean(Index nodes = 0) : values(static_cast<std::size_t>(nodes) * components, 0.0) {}

  /// Takes in one sample.
  /// @param sample  v and p, shape=(nodes,4)
  /// @param weight  w > 0, such as the time the sample stands for [time]
  void add(const double* sample, double weight);

  double weight = 0.0;         ///< W; 0 = no sample yet
  std::vector<double> values;  ///< mean v, mean p, R as xx, xy, xz, yy, yz, zz; shape=(nodes,10)
};

}  // namespace fbi
