/// The "expect" block: numbers that a run must reproduce.
#pragma once

#include <string>
#include <vector>

#include "case/schema.hpp"

namespace fbi::cases {

/// Watches the rows of the history and judges at the end.
class Expectations {
 public:
  /// Throws Error(usage) when an expected quantity is not a column of the history.
  Expectations(const std::vector<Expectation>& expected, const std::vector<std::string>& columns);
  bool empty() const { return watched_.empty(); }
  /// One row of the history at time `t`, values in the order of the columns.
  void add_row(double t, const std::vector<double>& values);
  /// Prints a line for each expectation; returns true when all are met.
  bool report() const;
  /// A line for each expectation as a row of the verification tables (docs/extending.md): section "Cases", the name of
  /// the case, quantity, source, expected value, value, relative error, tolerance, "cases/NAME".
  std::string rows(const std::string& case_name) const;

 private:
  struct Watched {
    Expectation expected;
    std::size_t column = 0;
    bool seen = false;
    double value = 0.0;
    double nearest = 1e300;  // distance to the wanted time
  };
  std::vector<Watched> watched_;
};

}  // namespace fbi::cases
