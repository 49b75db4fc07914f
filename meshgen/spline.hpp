/// Natural cubic spline through points.
#pragma once

#include <vector>

#include "base/types.hpp"

namespace fbi::meshgen {

/// The C2 cubic spline through points, its parameter counted along the chords, without curvature at its ends; straight
/// when the points lie on a line.
class Spline {
 public:
  /// At least two points, neighbors different.
  explicit Spline(const std::vector<Vec3>& points);

  /// Parameters of the points: 0 and the sums of the chords [length].
  const std::vector<double>& knots() const { return knots_; }
  Vec3 operator()(double t) const;

 private:
  std::vector<double> knots_;
  std::vector<Vec3> points_, bend_;  // bend: second derivative at the points [1/length]
};

}  // namespace fbi::meshgen
