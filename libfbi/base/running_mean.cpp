#include "base/running_mean.hpp"

namespace fbi {

void RunningMean::add(const double* sample, double added) {
  weight += added;
  const double share = added / weight, rest = 1.0 - share;
  const std::size_t nodes = values.size() / components;
  for (std::size_t n = 0; n < nodes; ++n) {
    const double* v = sample + 4 * n;
    double* mean = &values[components * n];
    double* r = mean + stress;
    const double d[3] = {v[0] - mean[0], v[1] - mean[1], v[2] - mean[2]};
    for (int i = 0; i < 3; ++i) mean[i] += share * d[i];
    mean[pressure] += share * (v[3] - mean[pressure]);
    // R_new = (1 - s) (R + s d d^T), s = w/W
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j, ++r) *r = rest * (*r + share * d[i] * d[j]);
  }
}

}  // namespace fbi
