/// Energies and forces over a run, from the columns of its history.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "post/history_series.hpp"
#include "post/plot.hpp"
#include "post/table.hpp"

namespace fbi::post {

/// The columns energy:* and power:* of the history, and the work since the first row for each power (trapezoidal rule)
/// named work:*. Throws Error(file) when the history has none: it was written by an older program.
std::vector<Series> read_energies(const Run& run);
/// One row a series: first, last, smallest and largest value, with the time of the largest.
Table energy_table(const std::vector<Series>& energies);
/// Energies and works over time; powers are in the table only.
Plot energy_plot(const std::string& run, const std::vector<Series>& energies);

/// Columns NAME:force_*, NAME:drag_*, NAME:lift_*, NAME:reaction_*, NAME:moment_* of the history from time `from` on;
/// with `columns` these columns, whatever they are. Throws Error(usage) for a name that is not there and Error(file)
/// when the history has no forces.
std::vector<Series> read_forces(const Run& run, const std::vector<std::string>& columns, std::optional<double> from);
/// One row a series: mean, min, max, peak to peak, middle and amplitude of the last period, frequency by crossings and
/// by the spectrum, number of periods; with `length` and `speed` the Strouhal number f L/U.
Table forces_table(const std::vector<Series>& forces, std::optional<double> length, std::optional<double> speed);
/// At most `most` series over time, those with the largest values.
Plot forces_plot(const std::string& run, const std::vector<Series>& forces, std::size_t most);

}  // namespace fbi::post
