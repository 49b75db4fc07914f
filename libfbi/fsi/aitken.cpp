#include "fsi/aitken.hpp"

#include <algorithm>
#include <cmath>

namespace fbi::fsi {

bool Aitken::advance(std::vector<double>& x, const std::vector<double>& r, const NearbyMap& /*nearby*/) {
  // Whether there is a previous residual must be the same decision on ranks without fibers.
  const bool first = !comm_.any(!previous_.empty());
  if (first) {
    omega_ = std::copysign(std::min(std::abs(omega_), initial_), omega_);
  } else {
    double sums[2] = {0.0, 0.0};
    for (std::size_t k = 0; k < r.size(); ++k) {
      const double difference = r[k] - previous_[k];
      sums[0] += previous_[k] * difference;
      sums[1] += difference * difference;
    }
    comm_.sum(sums, 2);
    if (sums[1] > 0.0) omega_ *= -sums[0] / sums[1];
  }
  previous_ = r;
  for (std::size_t k = 0; k < x.size(); ++k) x[k] += omega_ * r[k];
  return true;
}

}  // namespace fbi::fsi
