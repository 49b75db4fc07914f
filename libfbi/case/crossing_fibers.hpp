/// How many fibers touch or cross each other, recorded in every row of the history.
#pragma once

#include <vector>

#include "case/setup.hpp"
#include "io/history.hpp"
#include "search/fiber_crossings.hpp"

namespace fbi::cases {

/// The column `fibers:crossing`, the number of pairs of fibers whose center lines are nearer to each other than the sum
/// of their radii, of cases with several fibers. There is no contact: the first pair is a warning.
class CrossingFibers {
 public:
  /// `setup` must outlive this object. Collective.
  explicit CrossingFibers(const Setup& setup);

  static std::vector<io::HistoryColumn> columns(const Setup& setup);
  /// Value in the accepted state, the same on all ranks; nothing without the column. Warns once. Collective.
  std::vector<double> values();

 private:
  std::string name_of(GlobalIndex fiber) const;

  const Setup& setup_;
  std::unique_ptr<search::FiberCrossings> search_;
  bool warned_ = false;
};

}  // namespace fbi::cases
