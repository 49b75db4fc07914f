/// Time per step, time to go, and memory: what a user wants to know while a run goes on.
#pragma once

#include <chrono>
#include <string>

#include "base/types.hpp"

namespace fbi {

/// Estimates the time to go from the steps done so far in this process.
class Progress {
 public:
  /// The run goes from `first` (done already) to `last`.
  Progress(GlobalIndex first, GlobalIndex last);
  /// Call when step `step` is done; returns its wall time [s].
  double step_done(GlobalIndex step);
  double percent() const;
  /// Estimated seconds to go, from a running mean that forgets slow first steps.
  double seconds_left() const;
  double seconds_total() const;

 private:
  std::chrono::steady_clock::time_point start_, last_time_;
  GlobalIndex first_, last_, step_;
  double mean_ = 0.0;
};

/// "45 s", "3:20 min", "2:05 h".
std::string duration_text(double seconds);
/// Largest resident memory of this process so far [bytes].
double peak_memory();
/// "512 MiB", "1.3 GiB".
std::string memory_text(double bytes);

}  // namespace fbi
