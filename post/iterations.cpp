#include "post/iterations.hpp"

#include <algorithm>
#include <cmath>

#include "post/history_series.hpp"

namespace fbi::post {
namespace {

/// A column of histories that may be missing, and its name for readers.
struct Counter {
  const char* column;
  const char* name;
};

constexpr Counter counted[] = {{"coupling_iterations", "iterations"},
                               {"evaluations", "evaluations"},
                               {"interface_krylov", "interface Krylov"},
                               {"newton", "Newton"},
                               {"krylov", "Krylov"}};
constexpr Counter drawn[] = {{"coupling_iterations", "coupling iterations"},
                             {"evaluations", "field evaluations"},
                             {"relaxation", "relaxation factor"},
                             {"krylov", "Krylov iterations"}};

/// The history of a run, which may be without rows when the first step failed.
const io::HistoryTable& rows_or_failure(const Run& run) {
  return run.history && !run.history->failure.empty() ? *run.history : history_of(run);
}

/// Number of a column that counts something in this run; -1: it is missing, or zero in every step.
int used_column(const Run& run, const char* name) {
  const io::HistoryTable& history = rows_or_failure(run);
  const int column = history.column(name);
  const bool used = column >= 0 && std::any_of(history.rows.begin(), history.rows.end(),
                                               [column](const std::vector<double>& row) { return row[column] != 0.0; });
  return used ? column : -1;
}

bool any_has(const std::vector<Run>& runs, const char* name) {
  return std::any_of(runs.begin(), runs.end(), [name](const Run& run) { return used_column(run, name) >= 0; });
}

}  // namespace

Table iterations_table(const std::vector<Run>& runs) {
  Table table;
  table.columns = {"run", "steps"};
  std::vector<Counter> counters;
  for (const Counter& counter : counted)
    if (any_has(runs, counter.column)) {
      counters.push_back(counter);
      table.columns.push_back(counter.name + std::string(", mean"));
      table.columns.push_back(counter.name + std::string(", most"));
    }
  table.columns.insert(table.columns.end(), {"wall [s]", "wall a step [s]", "failed at"});
  for (const Run& run : runs) {
    const io::HistoryTable& history = rows_or_failure(run);
    const double steps = static_cast<double>(history.rows.size());
    std::vector<Table::Cell> row = {run.name, static_cast<GlobalIndex>(history.rows.size())};
    for (const Counter& counter : counters) {
      const int column = used_column(run, counter.column);
      if (column < 0) {
        row.insert(row.end(), {std::string("-"), std::string("-")});
        continue;
      }
      double sum = 0.0, most = 0.0;
      for (const std::vector<double>& values : history.rows) {
        sum += values[column];
        most = std::max(most, values[column]);
      }
      row.push_back(sum / steps);
      row.push_back(static_cast<GlobalIndex>(most));
    }
    const int wall = history.column("wall_seconds"), step = history.column("step");
    double seconds = 0.0;
    for (const std::vector<double>& values : history.rows) seconds += wall < 0 ? 0.0 : values[wall];
    row.push_back(seconds);
    row.push_back(history.rows.empty() ? Table::Cell("-") : Table::Cell(seconds / steps));
    const double last = step < 0 || history.rows.empty() ? steps : history.rows.back()[step];
    row.push_back(history.failure.empty() ? Table::Cell("-") : Table::Cell(static_cast<GlobalIndex>(last) + 1));
    table.rows.push_back(std::move(row));
  }
  return table;
}

std::vector<Plot> iterations_plots(const std::vector<Run>& runs) {
  std::vector<Plot> plots;
  for (const Counter& counter : drawn) {
    if (!any_has(runs, counter.column)) continue;
    Plot plot;
    plot.title = "Iterations a step" + (runs.size() == 1 ? " of " + runs[0].name : "");
    plot.x_label = "time";
    plot.y_label = counter.name;
    plot.columns = {"time", counter.column};
    for (const Run& run : runs) {
      Curve curve{run.name, {}};
      const io::HistoryTable& history = rows_or_failure(run);
      const int column = used_column(run, counter.column), time = history.column("time");
      for (const std::vector<double>& row : history.rows)
        if (column >= 0 && time >= 0) curve.rows.push_back({row[time], row[column]});
      // gnuplot draws no curve without points; one that is not a number keeps colors and key in step
      if (curve.rows.empty()) curve.rows.push_back({0.0, NAN});
      plot.curves.push_back(std::move(curve));
    }
    plots.push_back(std::move(plot));
  }
  return plots;
}

}  // namespace fbi::post
