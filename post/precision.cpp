#include "post/precision.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/log.hpp"
#include "post/difference.hpp"
#include "post/history_series.hpp"
#include "post/tip.hpp"

namespace fbi::post {
namespace {

// Run times that are nearer to each other than this say nothing about a slope.
constexpr double distinct_times = 1.1;

bool same(double a, double b) { return std::abs(a - b) <= same_time * std::max(std::abs(a), std::abs(b)); }

// Sums of squares over the times of both: of the difference and of the reference.
struct Squares {
  double difference = 0.0, reference = 0.0;
};

void add_squares(const TipSeries& tip, const TipSeries& reference, Squares& squares) {
  std::size_t j = 0;
  for (std::size_t i = 0; i < tip.time.size(); ++i) {
    while (j < reference.time.size() && reference.time[j] < tip.time[i] && !same(reference.time[j], tip.time[i])) ++j;
    if (j == reference.time.size() || !same(reference.time[j], tip.time[i])) continue;
    for (int c = 0; c < 3; ++c) {
      const double u = tip.displacement[i][c], v = reference.displacement[j][c];
      squares.difference += (u - v) * (u - v);
      squares.reference += v * v;
    }
  }
}

}  // namespace

WorkPoint work_of(const Run& run) {
  const io::HistoryTable& history = history_of(run);
  if (!history.failure.empty())
    throw Error(ExitCode::file, "run \"" + run.name + "\" failed (" + history.failure +
                                    "), so its time and error belong to no end; leave it out");
  const int wall = history.column("wall_seconds"), dt = history.column("dt"), krylov = history.column("krylov");
  if (wall < 0)
    throw Error(ExitCode::file, "the history of run \"" + run.name + "\" has no column \"wall_seconds\"; run it again");
  WorkPoint point;
  point.run = run.name;
  point.steps = static_cast<GlobalIndex>(history.rows.size());
  if (dt >= 0) point.dt = history.rows.back()[dt];
  double iterations = 0.0;
  for (const std::vector<double>& row : history.rows) {
    point.seconds += row[wall];
    if (krylov >= 0) iterations += row[krylov];
  }
  point.krylov = static_cast<GlobalIndex>(iterations);
  if (!(point.seconds > 0.0))
    throw Error(ExitCode::file, "the wall times of run \"" + run.name + "\" are 0, which no log-log plot can show");
  return point;
}

double tip_error(const Run& run, const Run& reference, const std::vector<std::string>& fibers) {
  const std::vector<TipSeries> tips = read_tips(run, fibers), others = read_tips(reference, fibers);
  Squares squares;
  bool found = false;
  for (const TipSeries& tip : tips) {
    const auto other = std::find_if(others.begin(), others.end(),
                                    [&](const TipSeries& candidate) { return candidate.fiber == tip.fiber; });
    if (other == others.end()) continue;
    found = true;
    const double end = tip.time.back();
    if (std::none_of(other->time.begin(), other->time.end(), [&](double time) { return same(time, end); }))
      throw Error(
          ExitCode::usage,
          log::format("run \"%s\" ends at time %.10g, of which the reference \"%s\" has no row (its last time is "
                      "%.10g); both must reach the same time, in steps of which one divides the other",
                      run.name.c_str(), end, reference.name.c_str(), other->time.back()));
    add_squares(tip, *other, squares);
  }
  if (!found)
    throw Error(ExitCode::usage, "runs \"" + run.name + "\" and \"" + reference.name +
                                     "\" recorded no fiber end in common; give both the same probes");
  if (!(squares.reference > 0.0))
    throw Error(ExitCode::usage, "the fibers of the reference \"" + reference.name +
                                     "\" do not move, so there is no relative error of their ends");
  return std::sqrt(squares.difference / squares.reference);
}

double field_error(const Run& run, const Run& reference, const std::string& field) {
  DifferenceOptions options;
  options.field = field;
  const io::HistoryTable& history = history_of(run);
  const int time = history.column("time");
  if (time >= 0) options.at.time = history.rows.back()[time];
  const Difference difference = field_difference(run, reference, options);
  if (!(difference.l2_reference > 0.0))
    throw Error(ExitCode::usage,
                "the " + field + " of the reference \"" + reference.name + "\" is 0, so there is no relative error");
  return difference.l2 / difference.l2_reference;
}

std::optional<double> slope(const WorkPoint& first, const WorkPoint& second) {
  return slope(WorkSeries{"", {first, second}});
}

std::optional<double> slope(const WorkSeries& series) {
  std::vector<WorkPoint> points = series.points;
  if (points.size() == 2 && !(points[0].error > 0.0 && points[1].error > 0.0)) return std::nullopt;
  std::erase_if(points, [](const WorkPoint& point) { return !(point.error > 0.0); });
  if (points.size() < 2) return std::nullopt;
  const auto [least, most] = std::minmax_element(
      points.begin(), points.end(), [](const WorkPoint& a, const WorkPoint& b) { return a.seconds < b.seconds; });
  if (most->seconds < distinct_times * least->seconds) return std::nullopt;
  const double count = static_cast<double>(points.size());
  double mean_x = 0.0, mean_y = 0.0, xx = 0.0, xy = 0.0;
  for (const WorkPoint& point : points) {
    mean_x += std::log(point.seconds) / count;
    mean_y += std::log(point.error) / count;
  }
  for (const WorkPoint& point : points) {
    const double x = std::log(point.seconds) - mean_x;
    xx += x * x;
    xy += x * (std::log(point.error) - mean_y);
  }
  return -xy / xx;
}

Table precision_table(const std::vector<WorkSeries>& series, const std::string& quantity) {
  Table table;
  table.columns = {"series", "run", "quantity", "dt", "steps", "Krylov", "wall [s]", "error", "slope", "of the series"};
  const auto cell = [](const std::optional<double>& value) { return value ? Table::Cell(*value) : Table::Cell("-"); };
  for (const WorkSeries& one : series) {
    const std::optional<double> overall = slope(one);
    for (std::size_t i = 0; i < one.points.size(); ++i) {
      const WorkPoint& point = one.points[i];
      table.rows.push_back({one.name, point.run, quantity, point.dt, point.steps, point.krylov, point.seconds,
                            point.error, cell(i > 0 ? slope(one.points[i - 1], point) : std::nullopt), cell(overall)});
    }
  }
  return table;
}

Plot precision_plot(const std::vector<WorkSeries>& series, const std::string& quantity, const std::string& title) {
  Plot plot;
  plot.title = title;
  plot.x_label = "run time in s";
  plot.y_label = "relative error of " + quantity;
  plot.columns = {"wall_seconds", "error", "dt", "steps", "krylov"};
  plot.log_axes = true;
  for (const WorkSeries& one : series) {
    Curve curve;
    const std::optional<double> overall = slope(one);
    curve.label = one.name + (overall ? log::format(" (%.1f)", *overall) : "");
    for (const WorkPoint& point : one.points)
      if (point.error > 0.0)
        curve.rows.push_back({point.seconds, point.error, point.dt, static_cast<double>(point.steps),
                              static_cast<double>(point.krylov)});
    if (!curve.rows.empty()) plot.curves.push_back(std::move(curve));
  }
  if (plot.curves.empty()) throw Error(ExitCode::usage, "all errors are exactly 0, which no log-log plot can show");
  return plot;
}

}  // namespace fbi::post
