/// Step sizes: whole steps of the grid of times n dt, and parts of them where a step did not converge.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "fsi/acceleration.hpp"
#include "fsi/system.hpp"

namespace fbi::fsi {

/// Where in time a run is: step n ends at n dt.
struct StepClock {
  GlobalIndex step = 0;
  double time = 0.0;
  double dt = 0.0;  ///< of a step that was done in parts: that of its smallest part
};

/// How far steps are halved. What is learned in one step serves the next.
class StepControl {
 public:
  /// `most_halvings`: a step is divided into at most 2^most_halvings parts.
  explicit StepControl(Index most_halvings = 0) : most_(most_halvings) {}

  /// Solves and accepts the grid step that ends at `clock`, in one piece or in 2^k equal or unequal parts: a part that
  /// does not converge is repeated with half its size, and after `restore_after` parts of one size the next one is
  /// twice as large where it ends on the coarser grid, so that every step ends at n dt. The report adds up all
  /// attempts; clock.dt becomes the size of the smallest part. Where the smallest part fails the fields are those at
  /// the beginning of the step, `failure` tells why, and false is returned. Throws what a step throws that no smaller
  /// one can mend. Collective.
  bool advance(System& system, Acceleration* acceleration, StepClock& clock, StepReport& report, std::string& failure);

  /// Numbers that a restart needs.
  std::vector<std::pair<std::string, double*>> scalars() {
    return {{"halvings", &level_}, {"parts_of_this_size", &successes_}};
  }

  /// For tests: a part that was solved is thrown away as if it had failed when this returns true for it. The same on
  /// every rank.
  std::function<bool(const StepClock&)> refuse;

  static constexpr int restore_after = 4;

 private:
  Index most_;
  double level_ = 0.0;      // parts are dt/2^level; doubles so that a restart can hold them
  double successes_ = 0.0;  // parts of this size done in a row
};

}  // namespace fbi::fsi
