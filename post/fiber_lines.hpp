/// The fibers of an output as lines of points.
#pragma once

#include <string>
#include <vector>

#include "post/reader.hpp"

namespace fbi::post {

/// Points on the center lines of all fibers, in file order.
struct FiberLines {
  std::vector<GlobalIndex> first;  ///< first point of each fiber, then the number of points; shape=(fibers+1)
  std::vector<GlobalIndex> group;  ///< place of each fiber in "fibers" of the case, shape=(fibers)
  std::vector<double> position;    ///< shape=(points,3) [length]
  std::vector<double> reference;   ///< the same material points at rest, shape=(points,3) [length]
  std::vector<double> radius;  ///< of each fiber, sqrt(A/pi); 0 when the input does not tell, shape=(fibers) [length]

  std::size_t fibers() const { return group.size(); }
  std::size_t points() const { return position.size() / 3; }
};

/// Reads the fibers of an output; none for a run without fibers. Throws Error(file).
FiberLines read_fiber_lines(const Run& run, const io::StepTime& output);

/// Largest coordinate `axis` of the points, at rest and in the output; only of fibers whose first point at rest lies
/// between `from` and `to` in the other two directions. Nothing when there are none.
struct CanopyHeight {
  double rest = 0.0, current = 0.0;
};
std::optional<CanopyHeight> canopy_height(const FiberLines& lines, int axis, const Vec3& from, const Vec3& to);

}  // namespace fbi::post
