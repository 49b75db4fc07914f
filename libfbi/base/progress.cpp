#include "base/progress.hpp"

#include <sys/resource.h>

#include <algorithm>

#include "base/log.hpp"

namespace fbi {
namespace {

double seconds_between(std::chrono::steady_clock::time_point a, std::chrono::steady_clock::time_point b) {
  return std::chrono::duration<double>(b - a).count();
}

}  // namespace

Progress::Progress(GlobalIndex first, GlobalIndex last)
    : start_(std::chrono::steady_clock::now()), last_time_(start_), first_(first), last_(last), step_(first) {}

double Progress::step_done(GlobalIndex step) {
  const std::chrono::steady_clock::time_point now = std::chrono::steady_clock::now();
  const double seconds = seconds_between(last_time_, now);
  last_time_ = now;
  const double weight = std::max(0.02, 1.0 / static_cast<double>(std::max<GlobalIndex>(1, step - first_)));
  mean_ += weight * (seconds - mean_);
  step_ = step;
  return seconds;
}

double Progress::percent() const {
  return last_ > 0 ? 100.0 * static_cast<double>(step_) / static_cast<double>(last_) : 100.0;
}
double Progress::seconds_left() const { return mean_ * static_cast<double>(last_ - step_); }
double Progress::seconds_total() const { return seconds_between(start_, std::chrono::steady_clock::now()); }

std::string duration_text(double seconds) {
  if (seconds < 99.5) return log::format("%.0f s", seconds);
  const long whole = static_cast<long>(seconds + 0.5);
  if (whole < 3600) return log::format("%ld:%02ld min", whole / 60, whole % 60);
  return log::format("%ld:%02ld h", whole / 3600, whole % 3600 / 60);
}

double peak_memory() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

std::string memory_text(double bytes) {
  if (bytes < 1024.0 * 1024.0) return log::format("%.0f KiB", bytes / 1024.0);
  if (bytes < 1024.0 * 1024.0 * 1024.0) return log::format("%.0f MiB", bytes / (1024.0 * 1024.0));
  return log::format("%.1f GiB", bytes / (1024.0 * 1024.0 * 1024.0));
}

}  // namespace fbi
