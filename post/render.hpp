/// Pictures in three dimensions: fibers as tubes, cut planes of the flow, drawn without graphics hardware.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "post/camera.hpp"
#include "post/outputs.hpp"
#include "post/reader.hpp"

namespace fbi::post {

/// A plane of constant coordinate.
struct Slice {
  int axis = 2;
  double position = 0.0;
};

/// "z=0.5". Throws Error(usage).
Slice parse_slice(const std::string& text);

/// What is drawn and how.
struct RenderOptions {
  OutputChoice at;
  View view;
  std::optional<Vec3> from, to;  ///< corners of the box that is shown; missing: all [length]
  std::vector<Slice> slices;
  bool middle_slice = true;        ///< when there are no slices, one in the middle, normal to z (to y when z is up)
  std::string quantity = "speed";  ///< on the slices, as read_scalar() has them
  std::string fibers = "displacement";  ///< colors of the fibers: also displacement_x, _y, _z, "plain", "none" (hidden)
  std::optional<std::array<double, 2>> range,
      fiber_range;               ///< of the colors; missing: of all nodes, and of the fibers shown
  double opacity = 1.0;          ///< of the slices, from 0 to 1
  std::optional<double> radius;  ///< of the tubes; missing: of the input [length]
  int width = 1600, height = 0;  ///< pixels; height 0: as high as needed
};

/// Draws an output. Fibers belong to the box when their first point at rest does. A slice is evaluated at every pixel
/// (trilinear in the cells), so that meshes of any kind look the same. Writes BASE.rgb (the picture without text) and
/// BASE.gp; gnuplot adds text and makes BASE.png. Returns the files' paths. Throws Error(usage) for quantities, outputs
/// and planes that are not there, Error(file). Needs about 64 bytes for each pixel.
std::vector<std::string> write_render(const std::string& base, const Run& run, const RenderOptions& options);

}  // namespace fbi::post
