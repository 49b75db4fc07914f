/// Running means against direct sums, and where a sum of squares would lose all digits.
#include "base/running_mean.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace fbi {
namespace {

constexpr int nodes = 3, samples = 40;

// Velocity component or pressure c of node n in sample k.
double value(int n, int c, int k) { return std::sin(1.7 * k + n) * (c + 1) + 0.3 * std::cos(0.9 * k * (c + 1)) + n; }

double weight(int k) { return 0.01 * (1 + k % 5); }

RunningMean mean_of(double level, double size) {
  RunningMean mean(nodes);
  for (int k = 0; k < samples; ++k) {
    double sample[4 * nodes];
    for (int n = 0; n < nodes; ++n)
      for (int c = 0; c < 4; ++c) sample[4 * n + c] = level + size * value(n, c, k);
    mean.add(sample, weight(k));
  }
  return mean;
}

TEST(RunningMean, equals_direct_sums) {
  const RunningMean mean = mean_of(0.0, 1.0);
  double total = 0.0;
  for (int k = 0; k < samples; ++k) total += weight(k);
  EXPECT_NEAR(mean.weight, total, 1e-14);
  for (int n = 0; n < nodes; ++n) {
    double first[4] = {0, 0, 0, 0};
    for (int c = 0; c < 4; ++c) {
      for (int k = 0; k < samples; ++k) first[c] += weight(k) * value(n, c, k) / total;
      EXPECT_NEAR(mean.values[10 * n + c], first[c], 1e-14);
    }
    std::size_t place = 10 * n + RunningMean::stress;
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j, ++place) {
        double sum = 0.0;
        for (int k = 0; k < samples; ++k)
          sum += weight(k) * (value(n, i, k) - first[i]) * (value(n, j, k) - first[j]) / total;
        EXPECT_NEAR(mean.values[place], sum, 1e-13);
      }
  }
}

TEST(RunningMean, small_fluctuations_on_a_large_mean_keep_their_digits) {
  const RunningMean plain = mean_of(0.0, 1.0), shifted = mean_of(1e4, 1e-4);
  for (int n = 0; n < nodes; ++n)
    for (int c = RunningMean::stress; c < RunningMean::components; ++c)
      EXPECT_NEAR(shifted.values[10 * n + c], 1e-8 * plain.values[10 * n + c], 1e-15);  // 1e-8: eps (1e4)^2
}

TEST(RunningMean, one_sample_has_no_fluctuation) {
  RunningMean mean(1);
  EXPECT_EQ(mean.weight, 0.0);
  const double sample[4] = {1.0, 2.0, 3.0, 4.0};
  mean.add(sample, 0.5);
  EXPECT_EQ(mean.values, (std::vector<double>{1, 2, 3, 4, 0, 0, 0, 0, 0, 0}));
}

}  // namespace
}  // namespace fbi
