#include "meshgen/smooth_curve.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/error.hpp"
#include "base/log.hpp"

namespace fbi::meshgen {
namespace {

constexpr int most_halvings = 24;
constexpr double epsilon = std::numeric_limits<double>::epsilon();

// Without arithmetic on what may not be finite.
bool is_finite(const Vec3& x) { return std::isfinite(x[0]) && std::isfinite(x[1]) && std::isfinite(x[2]); }

/// sum_k c_k T_k(x) by Clenshaw's recurrence.
template <std::size_t n>
double evaluate(const std::array<double, n>& c, double x) {
  double b1 = 0.0, b2 = 0.0;
  for (std::size_t k = n - 1; k > 0; --k) {
    const double b = c[k] + 2 * x * b1 - b2;
    b2 = b1;
    b1 = b;
  }
  return c[0] + x * b1 - b2;
}

/// Coefficients of the sum through values at cos(pi j / degree), j = 0 ... degree.
template <std::size_t n>
std::array<double, n> interpolate(const std::array<double, n>& values) {
  constexpr int degree = static_cast<int>(n) - 1;
  std::array<double, n> c{};
  for (int k = 0; k <= degree; ++k) {
    double sum = 0.0;
    for (int j = 0; j <= degree; ++j)
      sum += (j == 0 || j == degree ? 0.5 : 1.0) * values[j] *
             std::cos(std::numbers::pi * ((j * k) % (2 * degree)) / degree);
    c[k] = (k == 0 || k == degree ? 1.0 : 2.0) / degree * sum;
  }
  return c;
}

template <std::size_t n>
std::array<double, n> derivative(const std::array<double, n>& c) {
  std::array<double, n> d{};
  double after = 0.0, after_next = 0.0;  // d_{k+1}, d_{k+2}
  for (int k = static_cast<int>(n) - 2; k >= 0; --k) {
    const double value = after_next + 2 * (k + 1) * c[k + 1];
    d[k] = k == 0 ? 0.5 * value : value;
    after_next = after;
    after = value;
  }
  return d;
}

/// int_{-1}^x, one order more.
template <std::size_t n>
std::array<double, n + 1> integral(const std::array<double, n>& c) {
  std::array<double, n + 1> s{};
  const auto at = [&](std::size_t k) { return k < n ? c[k] : 0.0; };
  for (std::size_t k = 1; k <= n; ++k)
    s[k] = ((k == 1 ? 2.0 : 1.0) * at(k - 1) - at(k + 1)) / (2.0 * static_cast<double>(k));
  for (std::size_t k = 1; k <= n; ++k) s[0] += (k % 2 == 1 ? 1.0 : -1.0) * s[k];
  return s;
}

/// Size of the last coefficients: what higher orders would add.
template <std::size_t n>
double tail(const std::array<double, n>& c) {
  return std::max({std::abs(c[n - 1]), std::abs(c[n - 2]), std::abs(c[n - 3])});
}

}  // namespace

SmoothCurve::SmoothCurve(const std::function<Vec3(double)>& position, const std::vector<double>& breaks)
    : arc_(1, 0.0) {
  const double range = breaks.back() - breaks.front();
  for (int k = 0; k <= 64; ++k) {
    const Vec3 x = position(breaks.front() + range * k / 64);
    if (is_finite(x)) scale_ = std::max(scale_, x.cwiseAbs().maxCoeff());
  }
  for (std::size_t i = 0; i + 1 < breaks.size(); ++i) add(position, breaks[i], breaks[i + 1], 0);
  const double mean = length() / std::abs(range);
  if (!(length() > 64 * epsilon * scale_)) throw Error(ExitCode::geometry, "has zero length: all its points coincide");
  for (const Piece& piece : pieces_)
    if (!(2 * piece.slowest > 1e-6 * mean * std::abs(piece.end - piece.begin)))
      throw Error(
          ExitCode::geometry,
          log::format("stands still near t = %.6g: it has no direction there (dx/dt = dy/dt = dz/dt = 0); choose "
                      "another parameter, or begin or end elsewhere",
                      piece.begin == breaks.front() ? piece.begin : piece.end));
}

void SmoothCurve::add(const std::function<Vec3(double)>& position, double begin, double end, int depth) {
  Piece piece;
  piece.begin = begin;
  piece.end = end;
  const double middle = 0.5 * (begin + end), half = 0.5 * (end - begin);
  std::array<Sum, 3> values;
  for (int j = 0; j <= degree; ++j) {
    const double t = j == 0 ? end : j == degree ? begin : middle + half * std::cos(std::numbers::pi * j / degree);
    const Vec3 x = position(t);
    if (!is_finite(x))
      throw Error(ExitCode::geometry,
                  log::format("is not finite at t = %.6g: (%g, %g, %g); change \"position\", \"begin\" "
                              "or \"end\"",
                              t, x[0], x[1], x[2]));
    for (int i = 0; i < 3; ++i) values[i][j] = x[i];
  }
  bool resolved = true;
  double spread = 0.0;
  for (int i = 0; i < 3; ++i) {
    const auto [low, high] = std::minmax_element(values[i].begin(), values[i].end());
    spread = std::max(spread, *high - *low);
  }
  for (int i = 0; i < 3; ++i) {
    piece.position[i] = interpolate(values[i]);
    piece.slope[i] = derivative(piece.position[i]);
    resolved = resolved && tail(piece.position[i]) <= 1e-14 * spread + 4 * epsilon * scale_;
  }
  Sum speed;
  double largest = 0.0, smallest = std::numeric_limits<double>::infinity();
  for (int j = 0; j <= degree; ++j) {
    const double x = std::cos(std::numbers::pi * j / degree);
    double square = 0.0;
    for (const Sum& slope : piece.slope) square += std::pow(evaluate(slope, x), 2);
    speed[j] = std::sqrt(square);
    largest = std::max(largest, speed[j]);
    smallest = std::min(smallest, speed[j]);
  }
  const Sum coefficients = interpolate(speed);
  resolved = resolved && tail(coefficients) <= 1e-12 * largest + 256 * epsilon * scale_;
  if (!resolved) {
    if (depth < most_halvings) {
      add(position, begin, middle, depth + 1);
      add(position, middle, end, depth + 1);
      return;
    }
    throw Error(
        ExitCode::geometry,
        log::format("has a kink, a jump or a point where it stands still near t = %.6g: a center line is smooth; "
                    "choose another parameter, or make it of several fibers with \"joints\"",
                    middle));
  }
  piece.slowest = smallest;
  piece.arc = integral(coefficients);
  arc_.push_back(arc_.back() + evaluate(piece.arc, 1.0));
  pieces_.push_back(piece);
}

CurvePoint SmoothCurve::at(double u) const {
  const double target = u * length();
  const auto after = std::upper_bound(arc_.begin() + 1, arc_.end() - 1, target);
  const std::size_t p = static_cast<std::size_t>(after - arc_.begin()) - 1;
  const Piece& piece = pieces_[p];
  const double rest = target - arc_[p];
  const auto slope = [&](double x) {
    return Vec3(evaluate(piece.slope[0], x), evaluate(piece.slope[1], x), evaluate(piece.slope[2], x));
  };
  double x = u >= 1.0 ? 1.0 : u <= 0.0 ? -1.0 : 2 * rest / (arc_[p + 1] - arc_[p]) - 1;
  double low = -1.0, high = 1.0;
  for (int iteration = 0; iteration < 100 && u > 0.0 && u < 1.0; ++iteration) {
    const double beyond = evaluate(piece.arc, x) - rest;
    (beyond > 0.0 ? high : low) = x;
    double next = x - beyond / slope(x).norm();
    if (!(next > low && next < high)) next = 0.5 * (low + high);
    const double change = std::abs(next - x);
    x = next;
    if (change <= 4 * epsilon) break;
  }
  return {Vec3(evaluate(piece.position[0], x), evaluate(piece.position[1], x), evaluate(piece.position[2], x)),
          slope(x).normalized()};
}

}  // namespace fbi::meshgen
