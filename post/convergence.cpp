#include "post/convergence.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/log.hpp"
#include "io/format.hpp"
#include "post/hex_field.hpp"
#include "post/history_series.hpp"

namespace fbi::post {
namespace {

const char* label(Against against) {
  switch (against) {
    case Against::h:
      return "cell size h";
    case Against::dt:
      return "time step";
    case Against::elements:
      return "elements";
    case Against::unknowns:
      return "unknowns";
    default:
      return "wall time in s";
  }
}

bool falls_towards_fine(Against against) { return against == Against::h || against == Against::dt; }

using Curves = std::vector<std::vector<ErrorPoint>>;

// One list for each quantity, coarse runs first.
Curves sorted(const std::vector<ErrorPoint>& points, Against against) {
  Curves curves;
  for (const ErrorPoint& point : points) {
    if (!(point.resolution.of(against) > 0.0))
      throw Error(ExitCode::usage,
                  "run \"" + point.run + "\" has no " + label(against) + "; choose another axis with --against");
    auto curve = std::find_if(curves.begin(), curves.end(),
                              [&](const std::vector<ErrorPoint>& other) { return other[0].what == point.what; });
    if (curve == curves.end()) curve = curves.insert(curves.end(), std::vector<ErrorPoint>{});
    curve->push_back(point);
  }
  for (std::vector<ErrorPoint>& curve : curves) {
    std::stable_sort(curve.begin(), curve.end(), [&](const ErrorPoint& a, const ErrorPoint& b) {
      const double x = a.resolution.of(against), y = b.resolution.of(against);
      return falls_towards_fine(against) ? x > y : x < y;
    });
  }
  return curves;
}

// An order needs two resolutions.
void check_distinct(const std::vector<ErrorPoint>& curve, Against against) {
  for (std::size_t i = 1; i < curve.size(); ++i)
    if (std::abs(curve[i].resolution.of(against) / curve[i - 1].resolution.of(against) - 1.0) < 1e-9)
      throw Error(ExitCode::usage, log::format("runs \"%s\" and \"%s\" have the same %s, %g; choose another axis with "
                                               "--against (h, dt, elements, unknowns, wall)",
                                               curve[i - 1].run.c_str(), curve[i].run.c_str(), label(against),
                                               curve[i].resolution.of(against)));
}

double slope(const ErrorPoint& coarse, const ErrorPoint& fine, Against against) {
  return std::log(coarse.error / fine.error) /
         std::abs(std::log(coarse.resolution.of(against) / fine.resolution.of(against)));
}

// Two sides of a right triangle below the last two points, and its slope.
std::vector<Curve> triangle(const std::vector<ErrorPoint>& curve, Against against) {
  if (curve.size() < 2) return {};
  const ErrorPoint &coarse = curve[curve.size() - 2], &fine = curve.back();
  const double order = std::round(2.0 * slope(coarse, fine, against)) / 2.0;
  if (!(order > 0.0) || !std::isfinite(order)) return {};
  const double x1 = coarse.resolution.of(against), x2 = fine.resolution.of(against), y2 = 0.5 * fine.error;
  const double left = std::sqrt(x1 * x2), ratio = std::pow(std::max(left / x2, x2 / left), order);
  Curve guide;
  guide.label = log::format("%g", order);
  if (falls_towards_fine(against))
    guide.rows = {{left, y2}, {x2, y2}, {left, y2 * ratio}, {left, y2}, {left, y2 * std::sqrt(ratio)}};
  else
    guide.rows = {{left, y2}, {left, y2 * ratio}, {x2, y2}, {left, y2}, {left, y2 * std::sqrt(ratio)}};
  return {guide};
}

}  // namespace

std::optional<Against> against(const std::string& name) {
  const std::pair<const char*, Against> names[] = {{"h", Against::h},
                                                   {"dt", Against::dt},
                                                   {"elements", Against::elements},
                                                   {"unknowns", Against::unknowns},
                                                   {"wall", Against::wall}};
  for (const auto& [text, value] : names)
    if (name == text) return value;
  return std::nullopt;
}

double Resolution::of(Against against) const {
  switch (against) {
    case Against::h:
      return h;
    case Against::dt:
      return dt;
    case Against::elements:
      return elements;
    case Against::unknowns:
      return unknowns;
    default:
      return wall;
  }
}

Resolution resolution(const Run& run) {
  Resolution r;
  const io::File mesh = io::open_kind(run.paths.mesh(), io::FileKind::mesh);
  if (mesh.has("/fluid/nodes")) {
    const Grid grid = Grid::read(run);
    r.elements = static_cast<double>(grid.cells());
    r.h = std::cbrt(grid.volume() / r.elements);
    r.unknowns = 4.0 * static_cast<double>(grid.nodes());
  }
  if (mesh.has("/fibers/reference_dofs")) {
    const double nodes = static_cast<double>(mesh.shape("/fibers/reference_dofs")[0]),
                 fibers = static_cast<double>(mesh.shape("/fibers/names")[0]);
    r.unknowns += 6.0 * nodes;
    if (r.elements == 0.0) {
      r.elements = nodes - fibers;
      const std::vector<double> dofs = mesh.read<double>("/fibers/reference_dofs");
      std::vector<GlobalIndex> first = mesh.read<GlobalIndex>("/fibers/first_node");
      first.push_back(static_cast<GlobalIndex>(nodes));
      double length = 0.0;  // of the chords
      for (std::size_t f = 0; f + 1 < first.size(); ++f)
        for (GlobalIndex n = first[f]; n + 1 < first[f + 1]; ++n) {
          const double* q = &dofs[6 * static_cast<std::size_t>(n)];
          length += (Eigen::Map<const Vec3>(q + 6) - Eigen::Map<const Vec3>(q)).norm();
        }
      r.h = length / r.elements;
    }
  }
  if (run.history && !run.history->rows.empty()) {
    const int dt = run.history->column("dt"), wall = run.history->column("wall_seconds");
    if (dt >= 0) r.dt = run.history->rows.back()[dt];
    if (wall >= 0)
      for (const std::vector<double>& row : run.history->rows) r.wall += row[wall];
  }
  return r;
}

Table convergence_table(const std::vector<ErrorPoint>& points, Against against) {
  Table table;
  table.columns = {"run", "quantity", "h", "dt", "elements", "unknowns", "wall [s]", "error", "order"};
  for (const std::vector<ErrorPoint>& curve : sorted(points, against)) {
    check_distinct(curve, against);
    for (std::size_t i = 0; i < curve.size(); ++i) {
      const Resolution& r = curve[i].resolution;
      const bool has_order = i > 0 && curve[i].error > 0.0 && curve[i - 1].error > 0.0;
      table.rows.push_back({curve[i].run, curve[i].what, r.h, r.dt, static_cast<GlobalIndex>(r.elements),
                            static_cast<GlobalIndex>(r.unknowns), r.wall, curve[i].error,
                            has_order ? Table::Cell(slope(curve[i - 1], curve[i], against)) : Table::Cell("-")});
    }
  }
  return table;
}

Plot convergence_plot(const std::vector<ErrorPoint>& points, Against against, const std::string& title) {
  Plot plot;
  plot.title = title;
  plot.x_label = label(against);
  plot.y_label = "error";
  plot.columns = {"x", "error", "h", "dt", "elements", "unknowns", "wall_seconds"};
  plot.log_axes = true;
  for (std::vector<ErrorPoint>& points_of_curve : sorted(points, against)) {
    std::erase_if(points_of_curve, [](const ErrorPoint& point) { return !(point.error > 0.0); });
    if (points_of_curve.empty()) continue;
    Curve curve;
    curve.label = points_of_curve[0].what;
    for (const ErrorPoint& point : points_of_curve) {
      const Resolution& r = point.resolution;
      curve.rows.push_back({r.of(against), point.error, r.h, r.dt, r.elements, r.unknowns, r.wall});
    }
    if (plot.curves.empty()) plot.guides = triangle(points_of_curve, against);
    plot.curves.push_back(std::move(curve));
  }
  if (plot.curves.empty()) throw Error(ExitCode::usage, "all errors are exactly 0, which no log-log plot can show");
  return plot;
}

}  // namespace fbi::post
