/// Axis-aligned boxes.
#pragma once

#include <algorithm>
#include <limits>

#include "base/types.hpp"

namespace fbi::search {

/// The box [low, high]; a new one is empty. Trivially copyable: it travels between ranks.
struct Aabb {
  double low[3] = {std::numeric_limits<double>::max(), std::numeric_limits<double>::max(),
                   std::numeric_limits<double>::max()};
  double high[3] = {std::numeric_limits<double>::lowest(), std::numeric_limits<double>::lowest(),
                    std::numeric_limits<double>::lowest()};

  void include(const double* point) {
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], point[i]);
      high[i] = std::max(high[i], point[i]);
    }
  }
  void include(const Aabb& other) {
    for (int i = 0; i < 3; ++i) {
      low[i] = std::min(low[i], other.low[i]);
      high[i] = std::max(high[i], other.high[i]);
    }
  }
  bool empty() const { return low[0] > high[0]; }
  bool overlaps(const Aabb& other) const {
    return low[0] <= other.high[0] && other.low[0] <= high[0] && low[1] <= other.high[1] && other.low[1] <= high[1] &&
           low[2] <= other.high[2] && other.low[2] <= high[2];
  }
  /// Longest edge [length]; 0 when empty.
  double size() const { return empty() ? 0.0 : std::max({high[0] - low[0], high[1] - low[1], high[2] - low[2]}); }
  double volume() const { return empty() ? 0.0 : (high[0] - low[0]) * (high[1] - low[1]) * (high[2] - low[2]); }
  /// Moves every face outwards by `distance` [length].
  void inflate(double distance) {
    for (int i = 0; i < 3; ++i) {
      low[i] -= distance;
      high[i] += distance;
    }
  }
};

}  // namespace fbi::search
