/// A copy of the accepted state in memory, to go back to.
#pragma once

#include <string>
#include <vector>

#include "fsi/acceleration.hpp"
#include "fsi/system.hpp"

namespace fbi::fsi {

/// What an acceleration scheme has learned in earlier steps; null: nothing.
class SavedAcceleration {
 public:
  explicit SavedAcceleration(Acceleration* acceleration);
  void restore() const;

 private:
  Acceleration* acceleration_;
  std::vector<double> history_;
  std::vector<std::vector<double>> arrays_;
};

/// Everything that the next step depends on, of all fields. As large as a checkpoint.
class SavedState {
 public:
  explicit SavedState(System& system);
  /// Makes the copy the accepted state again. Collective.
  void restore() const;

 private:
  std::vector<double*> numbers() const;

  System& system_;
  std::vector<linalg::VecHandle> vectors_;
  std::vector<double> numbers_;
  std::vector<std::vector<double>> arrays_;
  std::vector<double> lambda_, line_force_;  // for output
};

}  // namespace fbi::fsi
