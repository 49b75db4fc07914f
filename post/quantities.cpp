#include "post/quantities.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.hpp"

namespace fbi::post {
namespace {

bool starts_with(const std::string& text, const std::string& start) { return text.rfind(start, 0) == 0; }

Plot plot_of(const std::string& title, const std::string& y_label, const std::vector<const Series*>& series) {
  Plot plot;
  plot.title = title;
  plot.x_label = "time";
  plot.y_label = y_label;
  plot.columns = {"time", "value"};
  for (const Series* one : series) {
    Curve curve;
    curve.label = one->name;
    for (std::size_t i = 0; i < one->time.size(); ++i) curve.rows.push_back({one->time[i], one->value[i]});
    plot.curves.push_back(std::move(curve));
  }
  return plot;
}

double largest(const Series& series) {
  double value = 0.0;
  for (const double v : series.value) value = std::max(value, std::abs(v));
  return value;
}

}  // namespace

std::vector<Series> read_energies(const Run& run) {
  std::vector<Series> energies, works;
  for (const std::string& column : history_of(run).columns) {
    const bool is_power = starts_with(column, "power:");
    if (!is_power && !starts_with(column, "energy:")) continue;
    energies.push_back(read_series(run, column));
    if (!is_power) continue;
    Series work = energies.back();
    work.name = "work:" + column.substr(6);
    work.unit = "force length";
    double sum = 0.0, before = 0.0;
    for (std::size_t i = 0; i < work.value.size(); ++i) {
      const double now = work.value[i];
      if (i > 0) sum += 0.5 * (before + now) * (work.time[i] - work.time[i - 1]);
      before = now;
      work.value[i] = sum;
    }
    works.push_back(std::move(work));
  }
  if (energies.empty())
    throw Error(ExitCode::file, "the history of run \"" + run.name +
                                    "\" has no energies: an older fbi-run wrote it; run the case again");
  energies.insert(energies.end(), works.begin(), works.end());
  return energies;
}

Table energy_table(const std::vector<Series>& energies) {
  Table table;
  table.columns = {"quantity", "unit", "first", "last", "min", "max", "at time"};
  for (const Series& series : energies) {
    const auto [low, high] = std::minmax_element(series.value.begin(), series.value.end());
    table.rows.push_back({series.name, series.unit, series.value.front(), series.value.back(), *low, *high,
                          series.time[static_cast<std::size_t>(high - series.value.begin())]});
  }
  return table;
}

Plot energy_plot(const std::string& run, const std::vector<Series>& energies) {
  std::vector<const Series*> shown;
  for (const Series& series : energies)
    if (!starts_with(series.name, "power:")) shown.push_back(&series);
  return plot_of("Energies of " + run, "energy, work", shown);
}

std::vector<Series> read_forces(const Run& run, const std::vector<std::string>& columns, std::optional<double> from) {
  std::vector<Series> forces;
  for (const std::string& column : columns) forces.push_back(read_series(run, column, from));
  if (!columns.empty()) return forces;
  for (const std::string& column : history_of(run).columns)
    for (const char* kind : {":force_", ":drag_", ":lift_", ":reaction_", ":moment_"})
      if (column.find(kind) != std::string::npos) forces.push_back(read_series(run, column, from));
  if (forces.empty())
    throw Error(ExitCode::file, "the history of run \"" + run.name +
                                    "\" has no forces; add a probe { \"fiber\": NAME, \"forces\": true } or a force "
                                    "output of a boundary to the case, or name columns with --quantity");
  return forces;
}

Table forces_table(const std::vector<Series>& forces, std::optional<double> length, std::optional<double> speed) {
  Table table;
  table.columns = {"quantity", "mean",      "min",       "max",        "peak to peak",
                   "middle",   "amplitude", "frequency", "spectral f", "periods"};
  if (length && speed) table.columns.push_back("Strouhal");
  for (const Series& series : forces) {
    const Statistics s = statistics(series);
    const auto known = [](double value) { return value > 0.0 ? Table::Cell(value) : Table::Cell("-"); };
    table.rows.push_back({series.name, s.mean, s.smallest, s.largest, s.largest - s.smallest, s.middle, s.amplitude,
                          known(s.frequency), known(s.spectral), s.periods});
    if (length && speed) table.rows.back().push_back(known(s.frequency * *length / *speed));
  }
  return table;
}

Plot forces_plot(const std::string& run, const std::vector<Series>& forces, std::size_t most) {
  std::vector<std::size_t> order(forces.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (order.size() > most) {
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return largest(forces[a]) > largest(forces[b]); });
    order.resize(most);
    std::sort(order.begin(), order.end());
  }
  std::vector<const Series*> shown;
  for (const std::size_t i : order) shown.push_back(&forces[i]);
  const std::string& unit = forces[order[0]].unit;
  const bool one_unit = std::all_of(shown.begin(), shown.end(), [&](const Series* s) { return s->unit == unit; });
  return plot_of("Forces of " + run, one_unit ? unit : "value", shown);
}

}  // namespace fbi::post
