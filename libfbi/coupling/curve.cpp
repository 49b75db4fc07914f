#include "coupling/curve.hpp"

#include <algorithm>
#include <cmath>

namespace fbi::coupling {

Curve hermite_curve(const double* dofs1, const double* dofs2, double length) {
  Curve curve;
  const double half = 0.5 * length;
  for (int i = 0; i < 3; ++i) {
    const double d1 = dofs1[i], d2 = dofs2[i], t1 = half * dofs1[3 + i], t2 = half * dofs2[3 + i];
    double* c = curve.component[i].c;
    c[0] = 0.5 * (d1 + d2) + 0.25 * (t1 - t2);
    c[1] = 0.75 * (d2 - d1) - 0.25 * (t1 + t2);
    c[2] = 0.25 * (t2 - t1);
    c[3] = 0.25 * (d1 - d2) + 0.25 * (t1 + t2);
  }
  return curve;
}

search::Aabb curve_box(const Curve& curve) {
  search::Aabb box;
  const Vec3 first = curve.point(-1.0), last = curve.point(1.0);
  const Vec3 second = first + (2.0 / 3.0) * curve.slope(-1.0), third = last - (2.0 / 3.0) * curve.slope(1.0);
  box.include(first.data());
  box.include(second.data());
  box.include(third.data());
  box.include(last.data());
  return box;
}

MonotonePieces::MonotonePieces(const Cubic& given) : cubic(given) {
  x[0] = -1.0;
  count = 0;
  // Extrema: a x^2 + b x + c = 0, solved without cancellation; only those inside (-1, 1) are wanted, so nothing
  // overflows.
  const double a = 3.0 * cubic.c[3], b = 2.0 * cubic.c[2], c = cubic.c[1];
  const double discriminant = b * b - 4.0 * a * c;
  if (discriminant > 0.0) {
    const double q = -0.5 * (b + std::copysign(std::sqrt(discriminant), b));
    double extrema[2];
    int found = 0;
    if (std::abs(q) < std::abs(a)) extrema[found++] = q / a;
    if (std::abs(c) < std::abs(q)) extrema[found++] = c / q;
    if (found == 2 && extrema[0] > extrema[1]) std::swap(extrema[0], extrema[1]);
    for (int i = 0; i < found; ++i)
      if (extrema[i] > x[count]) x[++count] = extrema[i];
  }
  x[++count] = 1.0;
  for (int i = 0; i <= count; ++i) value[i] = cubic.value(x[i]);
}

double MonotonePieces::low() const { return *std::min_element(value, value + count + 1); }
double MonotonePieces::high() const { return *std::max_element(value, value + count + 1); }

int MonotonePieces::crossings(double level, double* roots) const {
  int found = 0;
  for (int i = 0; i < count; ++i) {
    const double fa = value[i] - level, fb = value[i + 1] - level;
    if ((fa < 0.0) == (fb < 0.0)) continue;
    // Newton inside a shrinking bracket.
    double a = x[i], b = x[i + 1];
    double root = a + (b - a) * (fa / (fa - fb));
    for (int iteration = 0; iteration < 100; ++iteration) {
      const double f = cubic.value(root) - level;
      if (f == 0.0) break;
      ((f < 0.0) == (fa < 0.0) ? a : b) = root;
      const double slope = cubic.slope(root);
      double next = 0.5 * (a + b);
      if (std::abs(f) < std::abs(slope) * (b - a)) {
        const double newton = root - f / slope;
        if (newton > a && newton < b) next = newton;
      }
      const double step = std::abs(next - root);
      root = next;
      if (step <= 4e-16) break;
    }
    roots[found++] = root;
  }
  return found;
}

}  // namespace fbi::coupling
