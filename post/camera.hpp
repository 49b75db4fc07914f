/// Cameras: from points in space to pixels, and back to rays.
#pragma once

#include <vector>

#include "base/types.hpp"

namespace fbi::post {

/// Where a camera looks from.
struct View {
  double azimuth = 15.0;    ///< 0: x points to the right (y when x is up); positive: the eye goes right [degree]
  double elevation = 20.0;  ///< of the eye above the horizon [degree]
  double opening = 0.0;     ///< angle of a perspective camera; 0: parallel projection [degree]
  int up = 1;               ///< axis that points up
};

/// A point in a picture.
struct Pixel {
  double x = 0.0, y = 0.0;  ///< from the left and from the top
  double depth = 0.0;       ///< along the direction of sight, increasing away from the eye [length]
  double scale = 1.0;       ///< pixels per length there
};

/// A ray of sight, x = origin + depth direction.
struct Ray {
  Vec3 origin, direction;
};

/// Parallel or perspective projection.
class Camera {
 public:
  /// Looks at the middle of `points`, such that all of them lie within a picture of width x height pixels with margins
  /// around (left, right, top, bottom). With height = 0 the picture becomes as high as it needs to be.
  Camera(const View& view, const std::vector<Vec3>& points, int width, int height, const std::array<double, 4>& margin);

  int width() const { return width_; }
  int height() const { return height_; }
  /// Directions of the picture in space, and of sight through its middle.
  const Vec3& right() const { return right_; }
  const Vec3& up() const { return up_; }
  const Vec3& forward() const { return forward_; }
  Pixel project(const Vec3& x) const;
  /// The ray through a place in the picture; its depth is that of project().
  Ray ray(double x, double y) const;

 private:
  // Right, up and depth; in perspective right and up at depth 1.
  Vec3 local(const Vec3& x) const;

  Vec3 right_, up_, forward_, eye_;
  bool perspective_;
  double scale_ = 1.0, x0_ = 0.0, y0_ = 0.0;
  int width_, height_;
};

}  // namespace fbi::post
