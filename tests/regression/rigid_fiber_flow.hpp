/// A fiber with free ends in a periodic cube of slow flow, and what it should feel.
#pragma once

#include "regression/periodic_stokeslet.hpp"
#include "regression/straight_fibers.hpp"

namespace fbi::test {

/// Fixed fiber of half the side of a periodic cube, along z in its middle (on a line of nodes for even n), the flow
/// driven by a force of 1 per volume along `axis`.
inline Json fiber_in_cube(int n, int axis) {
  Json json = box_with_fiber(n, n, 1.0 / n, 0.5, 0.5);
  json["channel"]["size"] = {1, 1, 1};
  json["channel"]["elements"] = {n, n, n};
  Json& faces = json["channel"]["boundaries"];
  for (const char c : {'x', 'y', 'z'}) {
    const std::string low = std::string(1, c) + "min", high = std::string(1, c) + "max";
    faces[low] = {{"type", "periodic"}, {"with", high}};
    faces[high] = {{"type", "periodic"}, {"with", low}};
  }
  json["fluid"]["body_force"] = {"0", "0", "0"};
  json["fluid"]["body_force"][axis] = "1e6";
  const int half = n / 4;  // the ends lie in the faces between cells or, for odd n, in the middle of cells
  json["fibers"][0]["curve"]["from"][2] = 0.5 - static_cast<double>(half) / n;
  json["fibers"][0]["curve"]["to"][2] = 0.5 + static_cast<double>(half) / n;
  json["fibers"][0]["elements"] = 2 * half;
  return json;
}

/// Tirado and Garcia de la Torre 1984: F/(mu l U) of a cylinder of aspect ratio p = l/(2 a).
inline double cylinder_across(double p) {
  return 4 * std::numbers::pi / (std::log(p) + 0.839 + 0.185 / p + 0.233 / (p * p));
}
inline double cylinder_along(double p) {
  return 2 * std::numbers::pi / (std::log(p) - 0.207 + 0.980 / p - 0.133 / (p * p));
}

/// F/(mu l U) of the fiber alone, from that in the cube: 1/F less what the images add.
inline double alone(double resistance, double length, int axis) {
  const Mat3 images = image_velocity_of_fiber(length, Vec3::UnitZ());
  return 1 / (1 / resistance - length * images(axis, axis) / (8 * std::numbers::pi));
}

struct FiberInCube {
  double across = 0.0, along = 0.0, length = 0.0;  ///< F/(mu l U) without the images; length
};

inline FiberInCube drag_in_cube(int n, const Json& changes = Json::object()) {
  FiberInCube result;
  result.length = 2.0 * (n / 4) / n;
  for (const int axis : {0, 2}) {
    Json json = fiber_in_cube(n, axis);
    json.merge_patch(changes);
    CoupledCase run(json);
    const fsi::StepReport step = run.step();
    EXPECT_TRUE(step.converged);
    const double force = run.drag()[axis], velocity = mean_velocity(run)[axis];
    EXPECT_NEAR(force, 1.0, 1e-5);
    const double ours = alone(force / velocity / result.length, result.length, axis);
    (axis == 0 ? result.across : result.along) = ours;
  }
  return result;
}

}  // namespace fbi::test
