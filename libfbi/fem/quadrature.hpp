/// Gauss-Legendre quadrature on [-1, 1].
#pragma once

#include <vector>

namespace fbi::fem {

struct QuadratureRule {
  std::vector<double> points;   ///< in (-1, 1), ascending
  std::vector<double> weights;  ///< sum = 2
};

/// Gauss-Legendre rule with n >= 1 points, exact for polynomials of degree 2n-1; computed by Newton to round-off.
QuadratureRule gauss_legendre(int n);

}  // namespace fbi::fem
