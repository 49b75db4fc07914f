/// A tree of wall-clock timers: where the time of a run goes, with the rest of each branch shown as "other".
#pragma once

#include <chrono>
#include <memory>
#include <string>
#include <vector>

namespace fbi {

/// One node of the timer tree of this rank.
struct TimerNode {
  std::string name;
  double seconds = 0.0;
  long calls = 0;
  TimerNode* parent = nullptr;
  std::vector<std::unique_ptr<TimerNode>> children;
};

/// Root of the tree of this process.
TimerNode& timer_root();

/// Measures a scope as a child of the scope around it: `Timed timed("search");`
class Timed {
 public:
  explicit Timed(const char* name);
  ~Timed();
  Timed(const Timed&) = delete;
  Timed& operator=(const Timed&) = delete;

 private:
  TimerNode* node_;
  std::chrono::steady_clock::time_point start_;
};

/// The tree as an indented table: seconds, share of the whole, calls. Times are those of this rank.
std::string timer_report();

}  // namespace fbi
