#include "post/camera.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace fbi::post {

Camera::Camera(const View& view, const std::vector<Vec3>& points, int width, int height,
               const std::array<double, 4>& margin)
    : perspective_(view.opening > 0.0), width_(width), height_(height) {
  const double a = view.azimuth * M_PI / 180, e = view.elevation * M_PI / 180;
  // Axes of the world: `up`, and at azimuth 0 the one to the right and the one towards the eye; right-handed.
  const Vec3 vertical = Vec3::Unit(view.up), side = Vec3::Unit(view.up == 0 ? 1 : 0), front = side.cross(vertical);
  forward_ = -std::cos(e) * (std::sin(a) * side + std::cos(a) * front) - std::sin(e) * vertical;
  right_ = std::cos(a) * side - std::sin(a) * front;
  up_ = right_.cross(forward_);
  Vec3 low = points[0], high = points[0];
  for (const Vec3& x : points) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  const double radius = std::max(0.5 * (high - low).norm(), 1e-12);
  const double half_angle = std::clamp(view.opening, 1.0, 150.0) * M_PI / 360;
  eye_ = 0.5 * (low + high) - forward_ * (perspective_ ? radius / std::sin(half_angle) : 2.0 * radius);
  Vec3 first = local(points[0]), last = first;
  for (const Vec3& x : points) {
    first = first.cwiseMin(local(x));
    last = last.cwiseMax(local(x));
  }
  const Vec3 extent = (last - first).cwiseMax(1e-12 * radius);
  const double free_width = width - margin[0] - margin[1];
  if (height_ <= 0) {
    height_ = static_cast<int>(std::ceil(free_width * std::min(extent[1] / extent[0], 2.0) + margin[2] + margin[3]));
    height_ += height_ % 2;
  }
  const double free_height = height_ - margin[2] - margin[3];
  scale_ = std::min(free_width / extent[0], free_height / extent[1]);
  x0_ = margin[0] + 0.5 * free_width - 0.5 * scale_ * (first[0] + last[0]);
  y0_ = margin[2] + 0.5 * free_height + 0.5 * scale_ * (first[1] + last[1]);
}

Vec3 Camera::local(const Vec3& x) const {
  const Vec3 d = x - eye_;
  const double depth = d.dot(forward_), part = perspective_ ? 1.0 / depth : 1.0;
  return Vec3(part * d.dot(right_), part * d.dot(up_), depth);
}

Pixel Camera::project(const Vec3& x) const {
  const Vec3 at = local(x);
  return {x0_ + scale_ * at[0], y0_ - scale_ * at[1], at[2], perspective_ ? scale_ / at[2] : scale_};
}

Ray Camera::ray(double x, double y) const {
  const Vec3 across = (x - x0_) / scale_ * right_ + (y0_ - y) / scale_ * up_;
  if (perspective_) return {eye_, forward_ + across};
  return {eye_ + across, forward_};
}

}  // namespace fbi::post
