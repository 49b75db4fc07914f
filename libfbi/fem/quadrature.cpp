#include "fem/quadrature.hpp"

#include <cmath>
#include <numbers>

namespace fbi::fem {

QuadratureRule gauss_legendre(int n) {
  QuadratureRule rule;
  rule.points.resize(n);
  rule.weights.resize(n);
  for (int i = 0; i < (n + 1) / 2; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5));
    double derivative = 1.0;
    for (int iteration = 0; iteration < 100; ++iteration) {
      double previous = 1.0, value = x;  // P_0, P_1
      for (int k = 2; k <= n; ++k) {
        const double next = ((2 * k - 1) * x * value - (k - 1) * previous) / k;
        previous = value;
        value = next;
      }
      derivative = n * (x * value - previous) / (x * x - 1.0);
      const double step = value / derivative;
      x -= step;
      if (std::abs(step) < 1e-16) break;
    }
    if (n % 2 == 1 && i == n / 2) x = 0.0;
    const double weight = 2.0 / ((1.0 - x * x) * derivative * derivative);
    rule.points[i] = -x;
    rule.points[n - 1 - i] = x;
    rule.weights[i] = weight;
    rule.weights[n - 1 - i] = weight;
  }
  return rule;
}

}  // namespace fbi::fem
