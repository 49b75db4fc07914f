#include "tools/fbi_post_actions.hpp"

#include <cstdio>
#include <filesystem>

#include "base/error.hpp"
#include "base/log.hpp"
#include "io/pending_file.hpp"
#include "post/convergence.hpp"
#include "post/difference.hpp"
#include "post/history_series.hpp"
#include "post/info.hpp"
#include "post/iterations.hpp"
#include "post/map.hpp"
#include "post/picture.hpp"
#include "post/plot.hpp"
#include "post/precision.hpp"
#include "post/profiles.hpp"
#include "post/quantities.hpp"
#include "post/reader.hpp"
#include "post/table.hpp"
#include "post/tip.hpp"
#include "post/verification.hpp"
#include "post/vtk_export.hpp"

namespace fbi::tools {

using namespace fbi::post;

namespace {

/// DIRECTORY/NAME.KIND; beside the first run unless a directory is given. Several runs share the name "compare".
std::string base_name(const Arguments& arguments, const std::vector<Run>& runs, const std::string& kind) {
  std::filesystem::path directory = arguments.directory;
  if (directory.empty())
    directory = std::filesystem::path(runs[0].paths.index).parent_path();
  else
    fbi::io::make_directory(arguments.directory);
  return (directory / ((runs.size() > 1 ? "compare" : runs[0].name) + "." + kind)).string();
}

void print(const std::string& text) {
  if (std::fputs(text.c_str(), stdout) == EOF || std::fflush(stdout) != 0)
    throw Error(ExitCode::file, "standard output cannot be written");
}

void say_written(const std::vector<std::string>& files) {
  std::string text;
  for (const std::string& file : files) text += " " + file;
  fbi::log::info("wrote%s", text.c_str());
}

/// Writes BASE.txt (.csv, .md, .tex) and prints the same.
void show(const Arguments& arguments, const std::string& base, const Table& table) {
  const TableFormat format = *table_format(arguments.format);
  const std::string text = format_table(table, format);
  fbi::io::write_text_file(base + file_ending(format), text);
  print(text);
  say_written({base + file_ending(format)});
}

std::vector<Run> read_runs(const Arguments& arguments) {
  std::vector<Run> runs;
  for (const std::string& file : arguments.files) runs.push_back(read_run(file));
  return runs;
}

}  // namespace

void tip(const Arguments& arguments) {
  const std::vector<Run> runs = read_runs(arguments);
  std::vector<TipSeries> tips;
  for (const Run& run : runs)
    for (TipSeries& series : read_tips(run, arguments.fibers)) tips.push_back(std::move(series));
  const std::string base = base_name(arguments, runs, "tip");
  show(arguments, base, tip_table(tips));
  if (arguments.no_plot) return;
  constexpr std::size_t most = 12;
  if (tips.size() > most)
    fbi::log::info("the plot shows the %zu fibers of %zu that move most; choose others with --fiber NAME", most,
                   tips.size());
  say_written(write_plot(base, tip_plot(tips, most)));
}

void picture(const Arguments& arguments) {
  for (const std::string& file : arguments.files) {
    const Run run = read_run(file);
    say_written(write_picture(base_name(arguments, {run}, "picture"), run, arguments.step));
  }
}

void info(const Arguments& arguments) {
  for (const std::string& file : arguments.files) print(describe_file(file));
}

namespace {

/// What a difference is taken from: another run, or formulas.
class Comparison {
 public:
  explicit Comparison(const Arguments& arguments) : arguments_(arguments) {
    if (!arguments.reference.empty()) reference_ = read_run(arguments.reference);
    if (!arguments.exact.empty()) exact_ = parse_formulas(arguments.exact, 3, "--exact");
    if (!arguments.exact_pressure.empty())
      exact_pressure_ = parse_formulas(arguments.exact_pressure, 1, "--exact-pressure");
    fields_ = arguments.fields;
    const bool formulas = !exact_.empty() || !exact_pressure_.empty();
    if (formulas && reference_)
      throw Error(ExitCode::usage, "a run is compared with another run or with formulas, not with both");
    if (!formulas && !reference_)
      throw Error(ExitCode::usage,
                  "nothing to compare with: give another run, or formulas with --exact \"u,v,w\" or --exact-pressure "
                  "\"p\"");
    if (fields_.empty() && !(formulas && exact_.empty())) fields_.push_back("velocity");
    if (fields_.empty() || (arguments.fields.empty() && !exact_pressure_.empty())) fields_.push_back("pressure");
  }

  const std::vector<std::string>& fields() const { return fields_; }

  Difference of(const Run& run, const std::string& field) const {
    DifferenceOptions options;
    options.field = field;
    options.at = {arguments_.step, arguments_.time};
    options.on_coarse = arguments_.on == "coarse";
    options.remove_mean = arguments_.remove_mean;
    options.points = arguments_.points;
    options.allowed_uncovered = arguments_.uncovered;
    for (const std::string& norm : arguments_.norms) options.with_gradient = options.with_gradient || norm == "h1";
    if (options.with_gradient && field == "centerline")
      throw Error(ExitCode::usage, "center lines have the norms l2 and max, not h1");
    if (reference_) return field_difference(run, *reference_, options);
    const std::vector<fbi::input::Expression>& exact = field == "pressure" ? exact_pressure_ : exact_;
    if (exact.empty())
      throw Error(ExitCode::usage, "no formula for the field \"" + field + "\"; give " +
                                       (field == "pressure" ? "--exact-pressure \"p\"" : "--exact \"u,v,w\""));
    return field_difference(run, exact, options);
  }

 private:
  const Arguments& arguments_;
  std::optional<Run> reference_;
  std::vector<fbi::input::Expression> exact_, exact_pressure_;
  std::vector<std::string> fields_;
};

/// Value and size of the reference in one norm.
std::pair<double, double> norm_of(const Difference& difference, const std::string& norm) {
  if (norm == "max") return {difference.largest, difference.largest_reference};
  if (norm == "h1") return {difference.h1, difference.h1_reference};
  return {difference.l2, difference.l2_reference};
}

}  // namespace

void l2(const Arguments& arguments) {
  Arguments chosen = arguments;
  if (chosen.files.size() > 2) throw Error(ExitCode::usage, "l2 compares two runs, or one run with formulas");
  if (chosen.files.size() == 2) chosen.reference = chosen.files[1];
  const Run run = read_run(chosen.files[0]);
  const Comparison comparison(chosen);
  Table table;
  table.columns = {"field", "norm", "time", "difference", "relative", "of reference", "uncovered"};
  for (const std::string& field : comparison.fields()) {
    const Difference difference = comparison.of(run, field);
    if (difference.uncovered > 0.0)
      fbi::log::warning("%.2g %% of the volume lies in only one of the runs and is left out",
                        100.0 * difference.uncovered);
    for (const std::string& norm : chosen.norms) {
      const auto [value, reference] = norm_of(difference, norm);
      table.rows.push_back({field, norm, difference.time, value,
                            reference > 0.0 ? Table::Cell(value / reference) : Table::Cell("-"), reference,
                            difference.uncovered});
    }
  }
  show(chosen, base_name(chosen, {run}, "l2"), table);
}

namespace {

/// One number from a column of the history.
double reduced(const Arguments& arguments, const Run& run, const std::string& quantity) {
  const Series series = read_series(run, quantity, arguments.from);
  const Statistics s = statistics(series);
  if (arguments.reduce == "max") return s.largest;
  if (arguments.reduce == "min") return s.smallest;
  if (arguments.reduce == "max_abs") return std::max(std::abs(s.largest), std::abs(s.smallest));
  if (arguments.reduce == "mean") return s.mean;
  if (arguments.reduce == "middle") return s.middle;
  if (arguments.reduce == "amplitude") return s.amplitude;
  if (arguments.reduce == "frequency") return s.frequency;
  return series.value.back();
}

}  // namespace

void convergence(const Arguments& arguments) {
  const std::vector<Run> runs = read_runs(arguments);
  std::vector<ErrorPoint> points;
  if (!arguments.quantities.empty()) {
    if (arguments.quantities.size() > 1)
      throw Error(ExitCode::usage, "convergence takes one --quantity, with its --reference-value");
    std::optional<double> reference = arguments.reference_value;
    if (!reference && !arguments.reference.empty())
      reference = reduced(arguments, read_run(arguments.reference), arguments.quantities[0]);
    if (!reference)
      throw Error(ExitCode::usage, "--quantity needs --reference-value V or --reference RUN to compare with");
    for (const Run& run : runs)
      points.push_back({run.name, arguments.quantities[0] + " " + arguments.reduce, resolution(run),
                        std::abs(reduced(arguments, run, arguments.quantities[0]) - *reference)});
  } else {
    const Comparison comparison(arguments);
    for (const std::string& field : comparison.fields())
      for (const Run& run : runs) {
        const Difference difference = comparison.of(run, field);
        for (const std::string& norm : arguments.norms)
          points.push_back({run.name, field + " " + norm, resolution(run), norm_of(difference, norm).first});
      }
  }
  const Against axis = *against(arguments.against_name);
  const std::string base = base_name(arguments, runs, "convergence");
  show(arguments, base, convergence_table(points, axis));
  if (arguments.no_plot) return;
  const std::string title = arguments.reference.empty() ? "Convergence" : "Convergence to " + arguments.reference;
  say_written(write_plot(base, convergence_plot(points, axis, title)));
  if (axis != Against::wall &&
      std::all_of(points.begin(), points.end(), [](const ErrorPoint& point) { return point.resolution.wall > 0.0; }))
    say_written(write_plot(base + ".wall", convergence_plot(points, Against::wall, title)));
}

void energy(const Arguments& arguments) {
  for (const Run& run : read_runs(arguments)) {
    const std::vector<Series> energies = read_energies(run);
    const std::string base = base_name(arguments, {run}, "energy");
    show(arguments, base, energy_table(energies));
    if (!arguments.no_plot) say_written(write_plot(base, energy_plot(run.name, energies)));
  }
}

void forces(const Arguments& arguments) {
  if (arguments.length.has_value() != arguments.speed.has_value())
    throw Error(ExitCode::usage, "a Strouhal number needs both --length and --speed");
  for (const Run& run : read_runs(arguments)) {
    const std::vector<Series> series = read_forces(run, arguments.quantities, arguments.from);
    const std::string base = base_name(arguments, {run}, "forces");
    show(arguments, base, forces_table(series, arguments.length, arguments.speed));
    constexpr std::size_t most = 12;
    if (!arguments.no_plot) say_written(write_plot(base, forces_plot(run.name, series, most)));
  }
}

void iterations(const Arguments& arguments) {
  const std::vector<Run> runs = read_runs(arguments);
  const std::string base = base_name(arguments, runs, "iterations");
  show(arguments, base, iterations_table(runs));
  if (!arguments.no_plot) say_written(write_panels(base, iterations_plots(runs)));
}

namespace {

std::optional<fbi::Vec3> corner(const std::vector<double>& numbers) {
  if (numbers.empty()) return std::nullopt;
  return fbi::Vec3(numbers[0], numbers[1], numbers[2]);
}

}  // namespace

void profiles(const Arguments& arguments) {
  for (const Run& run : read_runs(arguments)) {
    ProfileOptions options;
    options.axis = arguments.axis[0] - 'x';
    options.from = corner(arguments.from_corner);
    options.to = corner(arguments.to_corner);
    options.bins = arguments.bins;
    options.at = {arguments.step, arguments.time};
    options.instantaneous = arguments.instantaneous;
    const Profiles means = mean_profiles(run, options);
    const std::string base = base_name(arguments, {run}, "profiles");
    const Table table = profile_table(means);
    show(arguments, base, table);
    if (arguments.format != "csv") {
      fbi::io::write_text_file(base + ".csv", format_table(table, TableFormat::csv));
      say_written({base + ".csv"});
    }
    if (means.averaged_over > 0.0)
      fbi::log::info("means over %.6g, to time %.6g", means.averaged_over, means.time);
    else
      fbi::log::info("the flow at time %.6g; fluctuations are those about the mean over the plane", means.time);
    if (means.canopy) fbi::log::info("canopy height %.6g, at rest %.6g", means.canopy->current, means.canopy->rest);
    if (!arguments.no_plot) say_written(write_profile_plot(base, means));
  }
}

void render(const Arguments& arguments) {
  RenderOptions options;
  options.at = {arguments.step, arguments.time};
  options.view = arguments.view;
  if (!arguments.camera.empty()) {
    options.view.azimuth = arguments.camera[0];
    options.view.elevation = arguments.camera[1];
  }
  options.view.up = arguments.up[0] - 'x';
  options.from = corner(arguments.from_corner);
  options.to = corner(arguments.to_corner);
  for (const std::string& slice : arguments.slices) {
    options.middle_slice = false;
    if (slice != "none") options.slices.push_back(parse_slice(slice));
  }
  options.quantity = arguments.quantity;
  options.fibers = arguments.fiber_quantity;
  if (!arguments.range.empty()) options.range = {arguments.range[0], arguments.range[1]};
  if (!arguments.fiber_range.empty()) options.fiber_range = {arguments.fiber_range[0], arguments.fiber_range[1]};
  options.opacity = arguments.opacity;
  options.radius = arguments.radius;
  if (!arguments.size.empty()) options.width = arguments.size[0];
  if (arguments.size.size() > 1) options.height = arguments.size[1];
  for (const Run& run : read_runs(arguments))
    say_written(write_render(base_name(arguments, {run}, "render"), run, options));
}

void export_vtk(const Arguments& arguments) {
  for (const Run& run : read_runs(arguments)) {
    const std::vector<std::string> files =
        write_vtk(base_name(arguments, {run}, "export"), run, {{arguments.step, arguments.time}, arguments.single});
    fbi::log::info("wrote %s and %zu files in %s", files[0].c_str(), files.size() - 1,
                   std::filesystem::path(files.back()).parent_path().c_str());
  }
}

namespace {

/// The run that a series is compared with.
std::string reference_of(const Arguments& arguments, const std::string& series) {
  for (const auto& [name, run] : arguments.other_references)
    if (name == series) return run;
  return arguments.reference;
}

void check_series(const Arguments& arguments) {
  std::vector<std::string> names;
  for (const std::vector<std::string>& words : arguments.series) {
    if (words.size() < 2)
      throw Error(ExitCode::usage, "--series \"" + words[0] + "\" has no runs; say --series NAME RUN [RUN ...]");
    if (std::find(names.begin(), names.end(), words[0]) != names.end())
      throw Error(ExitCode::usage, "there are two series \"" + words[0] + "\"; give them different names");
    names.push_back(words[0]);
  }
  for (const auto& other : arguments.other_references)
    if (std::find(names.begin(), names.end(), other.first) == names.end())
      throw Error(ExitCode::usage, "--series-reference: there is no series \"" + other.first + "\"");
}

}  // namespace

void precision(const Arguments& arguments) {
  check_series(arguments);
  const std::vector<std::string> quantities =
      arguments.fields.empty() ? std::vector<std::string>{"tip"} : arguments.fields;
  std::vector<Run> all;
  std::vector<std::vector<Run>> runs;
  for (const std::vector<std::string>& words : arguments.series) {
    runs.emplace_back();
    for (std::size_t i = 1; i < words.size(); ++i) runs.back().push_back(read_run(words[i]));
    all.insert(all.end(), runs.back().begin(), runs.back().end());
  }
  const std::string base = base_name(arguments, all, "precision");
  Table table;
  std::vector<Plot> plots;
  for (const std::string& quantity : quantities) {
    std::vector<WorkSeries> series;
    for (std::size_t s = 0; s < runs.size(); ++s) {
      series.push_back({arguments.series[s][0], {}});
      const Run reference = read_run(reference_of(arguments, series.back().name));
      for (const Run& run : runs[s]) {
        WorkPoint point = work_of(run);
        point.error =
            quantity == "tip" ? tip_error(run, reference, arguments.fibers) : field_error(run, reference, quantity);
        series.back().points.push_back(point);
      }
    }
    const Table part = precision_table(series, quantity);
    table.columns = part.columns;
    table.rows.insert(table.rows.end(), part.rows.begin(), part.rows.end());
    if (!arguments.no_plot) plots.push_back(precision_plot(series, quantity, "Work and precision; slopes in brackets"));
  }
  show(arguments, base, table);
  for (std::size_t i = 0; i < plots.size(); ++i)
    say_written(write_plot(i == 0 ? base : base + "." + quantities[i], plots[i]));
}

void map(const Arguments& arguments) {
  for (const std::string& file : arguments.files) {
    std::filesystem::path base(file);
    base.replace_extension();
    if (!arguments.directory.empty()) {
      fbi::io::make_directory(arguments.directory);
      base = std::filesystem::path(arguments.directory) / base.filename();
    }
    say_written(write_map(base.string(), read_map(file, arguments.shown), arguments.shown));
  }
}

void verification(const Arguments& arguments) {
  const std::vector<VerificationRow> rows = read_rows(arguments.files);
  std::vector<std::string> empty;
  const std::string page = fill_tables(fbi::io::read_text_file(arguments.page), arguments.page, rows, empty);
  for (const std::string& section : empty) fbi::log::warning("no rows for the table \"%s\"", section.c_str());
  fbi::io::write_text_file(arguments.page, page);
  fbi::log::info("%zu rows", rows.size());
  say_written({arguments.page});
}

}  // namespace fbi::tools
