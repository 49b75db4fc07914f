/// Iterations of runs: what a step of each scheme costs.
#pragma once

#include <vector>

#include "post/plot.hpp"
#include "post/reader.hpp"
#include "post/table.hpp"

namespace fbi::post {

/// One row a run: number of steps; mean and largest number a step of coupling iterations, field evaluations, nonlinear
/// and Krylov iterations, and of the Krylov iterations on the interface where a run counts them; wall time of all steps
/// and of one [s]; the step that failed. Cells of columns that a run does not have, or that are zero in every step, are
/// "-"; columns that no run has are left out. Throws Error(file) for a run without rows, unless its first step failed.
Table iterations_table(const std::vector<Run>& runs);

/// The same numbers over time, one plot for each of: coupling iterations, evaluations, relaxation factors, Krylov
/// iterations; without those that no run has. Throws as iterations_table.
std::vector<Plot> iterations_plots(const std::vector<Run>& runs);

}  // namespace fbi::post
