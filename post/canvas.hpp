/// A picture with a depth buffer: shaded tubes, lines and cut planes, without graphics hardware.
#pragma once

#include <string>
#include <vector>

#include "post/camera.hpp"

namespace fbi::post {

/// Red, green, blue from 0 to 1.
using Color = Eigen::Vector3f;

/// Colors between two values.
class ColorScale {
 public:
  /// Evenly spaced colors, "#rrggbb", from `low` to `high`.
  ColorScale(const std::vector<std::string>& colors, double low, double high);
  Color operator()(double value) const;
  double low() const { return low_; }
  double high() const { return high_; }

 private:
  std::vector<Color> colors_;
  double low_, high_;
};

/// White paper at first. Pixels are drawn `fine` times finer in both directions and averaged in the end.
class Canvas {
 public:
  Canvas(int width, int height, int fine);

  /// A tube between two points, lit from above left; `radius` [length], at least `thinnest` pixels.
  void tube(const Camera& camera, const Vec3& a, const Vec3& b, double radius, double thinnest, const Color& color_a,
            const Color& color_b);
  /// A line that is as thick everywhere [pixels], not lit.
  void line(const Camera& camera, const Vec3& a, const Vec3& b, double thickness, const Color& color);

  /// Goes through all fine pixels: `blend`(x, y, depth, color) may change the color of what is seen at depth (infinite
  /// for the paper).
  template <class Blend>
  void for_each_pixel(Blend blend) {
    for (int j = 0; j < height_ * fine_; ++j)
      for (int i = 0; i < width_ * fine_; ++i) {
        const std::size_t at = static_cast<std::size_t>(j) * static_cast<std::size_t>(width_ * fine_) + i;
        blend((i + 0.5) / fine_, (j + 0.5) / fine_, depth_[at], color_[at]);
      }
  }

  /// A bar of colors from left to right; places in pixels.
  void bar(int left, int top, int width, int height, const ColorScale& scale);

  /// Bytes red, green, blue of the pixels, rows from the top.
  std::string rgb() const;

 private:
  using Frame = std::array<std::array<int, 2>, 2>;  // fine pixels: columns and rows, from and to
  // Pixels between two points and `most` pixels around.
  Frame frame(const Pixel& a, const Pixel& b, double most) const;
  void put(int i, int j, double depth, const Color& color);

  int width_, height_, fine_;
  std::vector<Color> color_;
  std::vector<float> depth_;
};

}  // namespace fbi::post
