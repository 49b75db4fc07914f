/// Shape functions on the line [-1, 1]: cubic Hermite (center line) and linear Lagrange (multipliers).
#pragma once

#include <array>

namespace fbi::fem {

/// Cubic Hermite functions of one element in the order (d1, t1, d2, t2), SPEC of the beam: r = sum H^d d + (l/2) H^t t.
/// The factor l/2 of the tangent functions is *not* included.
inline std::array<double, 4> hermite(double x) {
  return {0.25 * (2 + x) * (1 - x) * (1 - x), 0.25 * (1 + x) * (1 - x) * (1 - x), 0.25 * (2 - x) * (1 + x) * (1 + x),
          -0.25 * (1 - x) * (1 + x) * (1 + x)};
}
/// First derivatives with respect to x.
inline std::array<double, 4> hermite_first(double x) {
  return {-0.75 * (1 - x * x), 0.25 * (1 - x) * (-1 - 3 * x), 0.75 * (1 - x * x), 0.25 * (1 + x) * (3 * x - 1)};
}
/// Second derivatives with respect to x.
inline std::array<double, 4> hermite_second(double x) {
  return {1.5 * x, 0.25 * (6 * x - 2), -1.5 * x, 0.25 * (6 * x + 2)};
}

/// Linear Lagrange functions (1-x)/2, (1+x)/2.
inline std::array<double, 2> linear(double x) { return {0.5 * (1 - x), 0.5 * (1 + x)}; }

}  // namespace fbi::fem
