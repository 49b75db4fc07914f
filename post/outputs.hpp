/// Which output of a run is meant.
#pragma once

#include <optional>

#include "post/reader.hpp"

namespace fbi::post {

/// The choice of a user; nothing chosen = the last output.
struct OutputChoice {
  std::optional<GlobalIndex> step;
  std::optional<double> time;
};

/// Two times are the same when they differ by less than this part of the larger one: sums of time steps.
inline constexpr double same_time = 1e-9;

/// The output of a run that is chosen. Throws Error(usage) naming the nearest ones when there is none, Error(file) when
/// the run has no output at all.
io::StepTime choose_output(const Run& run, const OutputChoice& choice);

/// Outputs of two runs at the same time: that of `choice` in the first run and the one of the same time in the second;
/// without a choice the last time that both have. Throws as above.
std::array<io::StepTime, 2> choose_outputs(const Run& first, const Run& second, const OutputChoice& choice);

}  // namespace fbi::post
