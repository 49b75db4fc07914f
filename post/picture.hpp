/// A picture of the flow in the middle plane of a box with the fibers over it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "post/reader.hpp"

namespace fbi::post {

/// Velocity magnitude in the plane z = middle (linear between node layers) and the center lines of the fibers whose
/// feet are nearest to that plane. Writes BASE.dat, BASE.fibers.dat and BASE.gp; gnuplot makes BASE.png and BASE.svg.
/// `step`: an output of the run, missing = the last one. Returns the files' paths. Throws Error(usage) for a step that
/// is not there, Error(file) when the run has no box of fluid, no velocity or no output, or a file cannot be written.
std::vector<std::string> write_picture(const std::string& base, const Run& run, std::optional<GlobalIndex> step);

}  // namespace fbi::post
