/// Columns of the history over time, and what they amount to: range, mean, frequency.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "post/plot.hpp"
#include "post/reader.hpp"
#include "post/table.hpp"

namespace fbi::post {

/// One column of the history.
struct Series {
  std::string name, unit;
  std::vector<double> time, value;
};

/// The history of a run. Throws Error(file) when it has none or no rows yet.
const io::HistoryTable& history_of(const Run& run);

/// A column from time `from` on. Throws Error(usage) for a name that is not there (naming the columns) and for a time
/// after the end.
Series read_series(const Run& run, const std::string& column, std::optional<double> from = std::nullopt);

/// What a series amounts to. Frequencies are 0 when the series has no two whole periods.
struct Statistics {
  double mean = 0.0;  ///< over time, by the trapezoidal rule; over whole periods where there are some
  double smallest = 0.0, largest = 0.0;
  double middle = 0.0, amplitude = 0.0;  ///< (max + min)/2 and (max - min)/2 of the last whole period, or of everything
  double frequency = 0.0;                ///< whole periods over their duration, from upward crossings of the middle
  double spectral = 0.0;                 ///< largest peak of the spectrum (Hann window, parabola through its logarithm)
  double scatter = 0.0;                  ///< largest deviation of a period from their mean, relative
  GlobalIndex periods = 0;               ///< whole ones between crossings
};

/// Crossings count when the series has been below (middle - range/4) since the last one, so that noise makes none. The
/// spectrum is that of the series at equal distances in time (linear between the steps).
Statistics statistics(const Series& series);

}  // namespace fbi::post
