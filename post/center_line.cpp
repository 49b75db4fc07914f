#include "post/center_line.hpp"

#include <algorithm>
#include <cmath>

#include "fem/line_shapes.hpp"
#include "fem/quadrature.hpp"

namespace fbi::post {
namespace {

Vec3 shape(const double* q, const std::array<double, 4>& h, double length) {
  const Eigen::Map<const Vec3> d1(q), t1(q + 3), d2(q + 6), t2(q + 9);
  return h[0] * d1 + 0.5 * length * h[1] * t1 + h[2] * d2 + 0.5 * length * h[3] * t2;
}

}  // namespace

CenterLine::CenterLine(std::vector<double> reference, std::vector<double> current)
    : reference_(std::move(reference)), current_(std::move(current)) {
  static const fem::QuadratureRule rule = fem::gauss_legendre(8);
  breaks_ = {0.0};
  for (std::size_t e = 0; e + 1 < reference_.size() / 6; ++e) {
    // The length belongs to the element: l = int |r'| with r = sum H^d d + l/2 H^t t.
    const double* q = &reference_[6 * e];
    double length = (Eigen::Map<const Vec3>(q + 6) - Eigen::Map<const Vec3>(q)).norm();
    for (int iteration = 0; iteration < 100; ++iteration) {
      double next = 0.0;
      for (std::size_t p = 0; p < rule.points.size(); ++p)
        next += rule.weights[p] * shape(q, fem::hermite_first(rule.points[p]), length).norm();
      const bool done = std::abs(next - length) <= 1e-15 * length;
      length = next;
      if (done) break;
    }
    breaks_.push_back(breaks_.back() + length);
  }
}

std::vector<double> CenterLine::shares() const {
  std::vector<double> shares;
  for (const double s : breaks_) shares.push_back(s / length());
  return shares;
}

Vec3 CenterLine::at(const std::vector<double>& dofs, double share) const {
  const double s = share * length();
  const auto above = std::upper_bound(breaks_.begin() + 1, breaks_.end() - 1, s);
  const std::size_t e = static_cast<std::size_t>(above - breaks_.begin()) - 1;
  const double l = breaks_[e + 1] - breaks_[e];
  return shape(&dofs[6 * e], fem::hermite(2.0 * (s - breaks_[e]) / l - 1.0), l);
}

}  // namespace fbi::post
