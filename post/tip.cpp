#include "post/tip.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.hpp"
#include "base/log.hpp"
#include "io/format.hpp"

namespace fbi::post {
namespace {

double length(const std::array<double, 3>& u) { return std::sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2]); }

// Sample with the largest displacement.
std::size_t peak(const TipSeries& tip) {
  std::size_t at = 0;
  for (std::size_t i = 1; i < tip.displacement.size(); ++i)
    if (length(tip.displacement[i]) > length(tip.displacement[at])) at = i;
  return at;
}

std::vector<TipSeries> from_history(const Run& run) {
  std::vector<TipSeries> tips;
  const io::HistoryTable& history = *run.history;
  const int time = history.column("time");
  const std::string ending = ":displacement_x";
  for (std::size_t c = 0; c < history.columns.size() && time >= 0; ++c) {
    const std::string& name = history.columns[c];
    if (name.size() <= ending.size() || name.compare(name.size() - ending.size(), ending.size(), ending) != 0) continue;
    const std::string stem = name.substr(0, name.size() - 1);
    const int y = history.column(stem + "y"), z = history.column(stem + "z");
    TipSeries tip = {run.name, name.substr(0, name.size() - ending.size()), {}, {}};
    for (const std::vector<double>& row : history.rows) {
      tip.time.push_back(row[time]);
      tip.displacement.push_back({row[c], y < 0 ? 0.0 : row[y], z < 0 ? 0.0 : row[z]});
    }
    tips.push_back(std::move(tip));
  }
  return tips;
}

std::vector<TipSeries> from_outputs(const Run& run) {
  std::vector<TipSeries> tips;
  const std::vector<std::string> names = fiber_names(run);
  if (names.empty()) return tips;
  const io::File mesh = io::open_kind(run.paths.mesh(), io::FileKind::mesh);
  const std::vector<double> reference = mesh.read<double>("/fibers/reference_dofs");
  std::vector<GlobalIndex> end = mesh.read<GlobalIndex>("/fibers/first_node");  // first node of the next fiber
  end.erase(end.begin());
  end.push_back(static_cast<GlobalIndex>(reference.size() / 6));
  for (const std::string& name : names) tips.push_back({run.name, name, {}, {}});
  for (const io::StepTime& output : run.outputs) {
    const std::vector<double> dofs =
        io::open_kind(run.paths.step(output.step), io::FileKind::step).read<double>("/fibers/dofs");
    for (std::size_t f = 0; f < tips.size(); ++f) {
      const std::size_t last = 6 * static_cast<std::size_t>(end[f] - 1);
      tips[f].time.push_back(output.time);
      tips[f].displacement.push_back({dofs.at(last) - reference[last], dofs.at(last + 1) - reference[last + 1],
                                      dofs.at(last + 2) - reference[last + 2]});
    }
  }
  return tips;
}

std::vector<TipSeries> selected(std::vector<TipSeries> tips, const Run& run, const std::vector<std::string>& fibers) {
  if (fibers.empty()) return tips;
  std::vector<TipSeries> chosen;
  for (const std::string& name : fibers) {
    const auto at = std::find_if(tips.begin(), tips.end(), [&](const TipSeries& tip) { return tip.fiber == name; });
    if (at == tips.end()) {
      std::string known;
      for (std::size_t i = 0; i < std::min<std::size_t>(tips.size(), 5); ++i) known += (i ? ", " : "") + tips[i].fiber;
      throw Error(ExitCode::usage, "run \"" + run.name + "\" has no record of fiber \"" + name + "\"; it has: " +
                                       known + (tips.size() > 5 ? log::format(", ... (%zu in all)", tips.size()) : ""));
    }
    chosen.push_back(*at);
  }
  return chosen;
}

}  // namespace

std::vector<TipSeries> read_tips(const Run& run, const std::vector<std::string>& fibers) {
  std::vector<TipSeries> tips;
  if (run.history) tips = from_history(run);
  if (tips.empty() && !run.outputs.empty()) tips = from_outputs(run);
  if (tips.empty())
    throw Error(ExitCode::file,
                "\"" + run.paths.index +
                    "\" holds no fiber ends: no probe in the history and no fibers in the outputs; add a probe "
                    "{ \"fiber\": NAME } to \"output\" and run the case again");
  if (tips[0].time.empty())
    throw Error(ExitCode::file, "\"" + run.paths.csv + "\" has no rows yet; wait for the first step");
  return selected(std::move(tips), run, fibers);
}

Table tip_table(const std::vector<TipSeries>& tips) {
  Table table;
  table.columns = {"run",     "fiber",   "max displacement", "at time", "final time",
                   "final x", "final y", "final z",          "samples"};
  for (const TipSeries& tip : tips) {
    const std::size_t at = peak(tip);
    const std::array<double, 3>& last = tip.displacement.back();
    table.rows.push_back({tip.run, tip.fiber, length(tip.displacement[at]), tip.time[at], tip.time.back(), last[0],
                          last[1], last[2], static_cast<GlobalIndex>(tip.time.size())});
  }
  return table;
}

Plot tip_plot(const std::vector<TipSeries>& tips, std::size_t most) {
  std::vector<std::size_t> order(tips.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  if (order.size() > most) {
    std::vector<double> largest;
    for (const TipSeries& tip : tips) largest.push_back(length(tip.displacement[peak(tip)]));
    std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return largest[a] > largest[b]; });
    order.resize(most);
    std::sort(order.begin(), order.end());
  }
  std::array<double, 3> extent = {0.0, 0.0, 0.0};
  bool one_fiber = true, one_run = true;
  Plot plot;
  for (const std::size_t i : order) {
    const TipSeries& tip = tips[i];
    one_fiber = one_fiber && tip.fiber == tips[order[0]].fiber;
    one_run = one_run && tip.run == tips[order[0]].run;
    for (const std::array<double, 3>& u : tip.displacement)
      for (int d = 0; d < 3; ++d) extent[d] = std::max(extent[d], std::abs(u[d]));
  }
  for (const std::size_t i : order) {
    const TipSeries& tip = tips[i];
    Curve curve;
    curve.label = one_run && one_fiber ? tip.fiber
                  : one_run            ? tip.fiber
                  : one_fiber          ? tip.run
                                       : tip.run + " " + tip.fiber;
    for (std::size_t k = 0; k < tip.time.size(); ++k) {
      const std::array<double, 3>& u = tip.displacement[k];
      curve.rows.push_back({tip.time[k], u[0], u[1], u[2], length(u)});
    }
    plot.curves.push_back(std::move(curve));
  }
  const int axis = static_cast<int>(std::max_element(extent.begin(), extent.end()) - extent.begin());
  plot.title = "Tip displacement" + (one_run     ? " of " + tips[order[0]].run
                                     : one_fiber ? " of " + tips[order[0]].fiber
                                                 : "");
  plot.x_label = "time";
  plot.y_label = std::string("displacement in ") + "xyz"[axis];
  plot.columns = {"time", "displacement_x", "displacement_y", "displacement_z", "magnitude"};
  plot.y_column = 2 + axis;
  return plot;
}

}  // namespace fbi::post
