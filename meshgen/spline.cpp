#include "meshgen/spline.hpp"

#include <algorithm>

namespace fbi::meshgen {

Spline::Spline(const std::vector<Vec3>& points) : knots_(1, 0.0), points_(points), bend_(points.size(), Vec3::Zero()) {
  for (std::size_t n = 1; n < points.size(); ++n) knots_.push_back(knots_.back() + (points[n] - points[n - 1]).norm());
  // h_{n-1} m_{n-1} + 2 (h_{n-1} + h_n) m_n + h_n m_{n+1} = 6 (slope_n - slope_{n-1}), m = 0 at the ends.
  std::vector<double> above(points.size(), 0.0);
  for (std::size_t n = 1; n + 1 < points.size(); ++n) {
    const double before = knots_[n] - knots_[n - 1], after = knots_[n + 1] - knots_[n];
    const Vec3 right = 6 * ((points[n + 1] - points[n]) / after - (points[n] - points[n - 1]) / before);
    const double pivot = 2 * (before + after) - before * above[n - 1];
    above[n] = after / pivot;
    bend_[n] = (right - before * bend_[n - 1]) / pivot;
  }
  for (std::size_t n = points.size() - 1; n-- > 1;) bend_[n] -= above[n] * bend_[n + 1];
}

Vec3 Spline::operator()(double t) const {
  const auto after = std::upper_bound(knots_.begin() + 1, knots_.end() - 1, t);
  const std::size_t n = static_cast<std::size_t>(after - knots_.begin());
  const double h = knots_[n] - knots_[n - 1], b = (t - knots_[n - 1]) / h, a = 1 - b;
  return a * points_[n - 1] + b * points_[n] +
         (h * h / 6) * ((a * a * a - a) * bend_[n - 1] + (b * b * b - b) * bend_[n]);
}

}  // namespace fbi::meshgen
