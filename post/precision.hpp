/// Work and precision: run times of series of runs against their errors.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "post/plot.hpp"
#include "post/reader.hpp"
#include "post/table.hpp"

namespace fbi::post {

/// Error and cost of one run.
struct WorkPoint {
  std::string run;
  double dt = 0.0;  ///< of the last step
  GlobalIndex steps = 0;
  GlobalIndex krylov = 0;  ///< linear iterations of all steps: a cost that does not depend on the machine
  double seconds = 0.0;    ///< wall times of all steps
  double error = 0.0;      ///< relative; 0: not different at all
};

/// Runs that differ in one thing, in its order.
struct WorkSeries {
  std::string name;
  std::vector<WorkPoint> points;
};

/// Cost of a run from its history, without error. Throws Error(file) when the run has no history, failed, or did not
/// record its times.
WorkPoint work_of(const Run& run);

/// Displacement of fiber ends against `reference` over all steps: sqrt(sum |u - u_ref|^2 / sum |u_ref|^2), the sums
/// over the times that both have and over all ends that both recorded (`fibers`: these only). Throws Error(usage) when
/// the reference has no row at the last time of the run, no end is in both, or nothing moves.
double tip_error(const Run& run, const Run& reference, const std::vector<std::string>& fibers);

/// Relative L2 error of "velocity", "pressure" or "centerline" at the end of the run. Throws Error(usage) when the
/// reference has no output at that time.
double field_error(const Run& run, const Run& reference, const std::string& field);

/// Slopes in log-log, positive when more work leaves a smaller error: -log(e2/e1)/log(s2/s1) of neighbours, the one of
/// least squares for a series. Nothing where an error is 0 or run times differ by less than a tenth.
std::optional<double> slope(const WorkPoint& first, const WorkPoint& second);
std::optional<double> slope(const WorkSeries& series);

/// Rows in the order of the series and their points, with the slope to the point before and that of the series.
Table precision_table(const std::vector<WorkSeries>& series, const std::string& quantity);

/// Run time against error, log-log, one curve a series with its slope in the key. Errors of zero are left out. Throws
/// Error(usage) when nothing is left.
Plot precision_plot(const std::vector<WorkSeries>& series, const std::string& quantity, const std::string& title);

}  // namespace fbi::post
