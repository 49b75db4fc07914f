/// Displacement of fiber ends over time.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "post/plot.hpp"
#include "post/reader.hpp"
#include "post/table.hpp"

namespace fbi::post {

/// The displacement of one end of one fiber.
struct TipSeries {
  std::string run;    ///< NAME of NAME.run.h5
  std::string fiber;  ///< "patch/112/7", "...@start" for a probe at the start
  std::vector<double> time;
  std::vector<std::array<double, 3>> displacement;  ///< [length]
};

/// From the columns NAME:displacement_x, _y, _z of the history; when it has none, from the last nodes of the fibers in
/// the outputs, against their reference. `fibers` selects by name, empty = all. Throws Error(usage) for a name that is
/// not there and Error(file) when there is neither probe nor fiber.
std::vector<TipSeries> read_tips(const Run& run, const std::vector<std::string>& fibers);

/// One row a series: largest |displacement|, its time, the displacement at the end, the number of samples.
Table tip_table(const std::vector<TipSeries>& tips);

/// The component with the largest displacement over time; at most `most` curves, those with the largest displacement.
Plot tip_plot(const std::vector<TipSeries>& tips, std::size_t most);

}  // namespace fbi::post
