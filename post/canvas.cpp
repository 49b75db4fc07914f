#include "post/canvas.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace fbi::post {

ColorScale::ColorScale(const std::vector<std::string>& colors, double low, double high) : low_(low), high_(high) {
  for (const std::string& text : colors) {
    const unsigned long value = std::stoul(text.substr(1), nullptr, 16);
    colors_.push_back(Color(static_cast<float>(value >> 16 & 255), static_cast<float>(value >> 8 & 255),
                            static_cast<float>(value & 255)) /
                      255.0f);
  }
}

Color ColorScale::operator()(double value) const {
  const double share = high_ > low_ ? std::clamp((value - low_) / (high_ - low_), 0.0, 1.0) : 0.5;
  const double place = share * static_cast<double>(colors_.size() - 1);
  const std::size_t k = std::min(static_cast<std::size_t>(place), colors_.size() - 2);
  const float part = static_cast<float>(place - static_cast<double>(k));
  return (1.0f - part) * colors_[k] + part * colors_[k + 1];
}

Canvas::Canvas(int width, int height, int fine)
    : width_(width),
      height_(height),
      fine_(fine),
      color_(static_cast<std::size_t>(width) * height * fine * fine, Color::Ones()),
      depth_(color_.size(), std::numeric_limits<float>::infinity()) {}

Canvas::Frame Canvas::frame(const Pixel& a, const Pixel& b, double most) const {
  const auto limits = [&](double p, double q, int pixels) {
    const double low = std::floor(fine_ * (std::min(p, q) - most)), high = std::ceil(fine_ * (std::max(p, q) + most));
    return std::array<int, 2>{static_cast<int>(std::clamp(low, 0.0, 1.0 * fine_ * pixels)),
                              static_cast<int>(std::clamp(high, 0.0, 1.0 * fine_ * pixels))};
  };
  if (!(a.depth > 0.0) || !(b.depth > 0.0)) return Frame{};  // behind the eye
  return {limits(a.x, b.x, width_), limits(a.y, b.y, height_)};
}

void Canvas::put(int i, int j, double depth, const Color& color) {
  const std::size_t at = static_cast<std::size_t>(j) * static_cast<std::size_t>(width_ * fine_) + i;
  if (static_cast<float>(depth) >= depth_[at]) return;
  depth_[at] = static_cast<float>(depth);
  color_[at] = color.cwiseMin(1.0f);
}

// The first point of a ray on a cylinder with hemispheres at its ends: |o + t d - (a + s (b - a))| = r with s cut to
// [0,1], quadratic in t on the cylinder and on each sphere.
void Canvas::tube(const Camera& camera, const Vec3& a, const Vec3& b, double radius, double thinnest,
                  const Color& color_a, const Color& color_b) {
  const Pixel pa = camera.project(a), pb = camera.project(b);
  const double r = std::max(radius, thinnest / std::min(pa.scale, pb.scale));
  // A sphere off the middle of a perspective picture is an ellipse, longer by up to 1/cos^2 of the angle.
  const double stretch =
      std::max(camera.ray(pa.x, pa.y).direction.squaredNorm(), camera.ray(pb.x, pb.y).direction.squaredNorm());
  const Frame where = frame(pa, pb, stretch * r * std::max(pa.scale, pb.scale) + 1.0);
  const Vec3 light = (-0.45 * camera.right() + 0.55 * camera.up() - 0.7 * camera.forward()).normalized();
  const Vec3 along = b - a;
  const double square = along.squaredNorm();
  for (int j = where[1][0]; j < where[1][1]; ++j)
    for (int i = where[0][0]; i < where[0][1]; ++i) {
      const Ray ray = camera.ray((i + 0.5) / fine_, (j + 0.5) / fine_);
      const Vec3 from = ray.origin - a;
      const double dd = ray.direction.squaredNorm(), bd = along.dot(ray.direction), bf = along.dot(from);
      const double qa = square * dd - bd * bd, qb = square * ray.direction.dot(from) - bf * bd,
                   qc = square * (from.squaredNorm() - r * r) - bf * bf, root = qb * qb - qa * qc;
      double t = 0.0, s = bd > 0.0 ? -1.0 : 2.0;  // along the axis: the end that is nearer
      if (qa > 1e-12 * square * dd) {
        if (root < 0.0) continue;
        t = (-qb - std::sqrt(root)) / qa;
        s = (bf + t * bd) / square;
      }
      if (!(s >= 0.0 && s <= 1.0)) {
        s = s < 0.0 ? 0.0 : 1.0;
        const Vec3 end = from - s * along;
        const double eb = ray.direction.dot(end), rest = eb * eb - dd * (end.squaredNorm() - r * r);
        if (rest < 0.0) continue;
        t = (-eb - std::sqrt(rest)) / dd;
      }
      const Vec3 normal = (from + t * ray.direction - s * along) / r;
      const Color color = static_cast<float>(1.0 - s) * color_a + static_cast<float>(s) * color_b;
      put(i, j, t, static_cast<float>(0.42 + 0.63 * std::max(0.0, normal.dot(light))) * color);
    }
}

void Canvas::line(const Camera& camera, const Vec3& a, const Vec3& b, double thickness, const Color& color) {
  const Pixel pa = camera.project(a), pb = camera.project(b);
  const Frame where = frame(pa, pb, thickness);
  const double dx = pb.x - pa.x, dy = pb.y - pa.y, square = std::max(dx * dx + dy * dy, 1e-12);
  for (int j = where[1][0]; j < where[1][1]; ++j)
    for (int i = where[0][0]; i < where[0][1]; ++i) {
      const double x = (i + 0.5) / fine_ - pa.x, y = (j + 0.5) / fine_ - pa.y;
      const double s = std::clamp((x * dx + y * dy) / square, 0.0, 1.0);
      if (std::hypot(x - s * dx, y - s * dy) > 0.5 * thickness) continue;
      // Equal parts of the picture are not equal parts of the line in perspective, where scale ~ 1/depth.
      const double part = s * pb.scale / ((1.0 - s) * pa.scale + s * pb.scale);
      put(i, j, pa.depth + part * (pb.depth - pa.depth), color);
    }
}

void Canvas::bar(int left, int top, int width, int height, const ColorScale& scale) {
  for (int j = top * fine_; j < (top + height) * fine_; ++j)
    for (int i = left * fine_; i < (left + width) * fine_; ++i) {
      const double share = (i + 0.5 - left * fine_) / (width * fine_);
      color_[static_cast<std::size_t>(j) * static_cast<std::size_t>(width_ * fine_) + i] =
          scale(scale.low() + share * (scale.high() - scale.low()));
    }
}

std::string Canvas::rgb() const {
  std::string bytes;
  bytes.reserve(3 * static_cast<std::size_t>(width_) * height_);
  for (int j = 0; j < height_; ++j)
    for (int i = 0; i < width_; ++i) {
      Color sum = Color::Zero();
      for (int b = 0; b < fine_; ++b)
        for (int a = 0; a < fine_; ++a)
          sum += color_[static_cast<std::size_t>(j * fine_ + b) * static_cast<std::size_t>(width_ * fine_) +
                        static_cast<std::size_t>(i * fine_ + a)];
      for (int c = 0; c < 3; ++c)
        bytes += static_cast<char>(static_cast<unsigned char>(std::lround(255.0f * sum[c] / (fine_ * fine_))));
    }
  return bytes;
}

}  // namespace fbi::post
