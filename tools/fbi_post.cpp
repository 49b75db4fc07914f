/// fbi-post: tables, plots and pictures from the results of fbi-run.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "base/error.hpp"
#include "base/log.hpp"
#include "base/version.hpp"
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
#include "post/render.hpp"
#include "post/table.hpp"
#include "post/tip.hpp"
#include "post/verification.hpp"
#include "post/vtk_export.hpp"

namespace {

using fbi::Error;
using fbi::ExitCode;
using namespace fbi::post;

struct Arguments {
  std::vector<std::string> files;
  std::vector<std::string> fibers;
  std::string format = "text";
  std::string directory;
  bool no_plot = false;
  bool quiet = false;
  std::optional<fbi::GlobalIndex> step;
  // differences
  std::vector<std::string> fields;
  std::vector<std::string> norms = {"l2"};
  std::optional<double> time;
  std::string on = "fine";
  bool remove_mean = false;
  int points = 3;
  double uncovered = 0.01;
  std::string exact, exact_pressure, reference;
  std::string against_name = "h";
  // histories
  std::vector<std::string> quantities;
  std::optional<double> reference_value, from, length, speed;
  std::string reduce = "last";
  // parts of the flow
  std::vector<double> from_corner, to_corner;
  std::string axis = "y";
  std::optional<fbi::Index> bins;
  bool instantaneous = false;
  // three dimensions
  View view;
  std::vector<double> camera, range, fiber_range;
  std::string up = "y", quantity = "speed", fiber_quantity = "displacement";
  std::vector<std::string> slices;
  double opacity = 1.0;
  std::optional<double> radius;
  std::vector<int> size;
  bool single = false;
  // maps
  std::vector<std::string> shown;
  // verification
  std::string page = "docs/verification.md";
  // work and precision: a name and its runs
  std::vector<std::vector<std::string>> series;
  std::vector<std::pair<std::string, std::string>> other_references;
};

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

std::optional<fbi::Vec3> corner(const std::vector<double>& numbers) {
  if (numbers.empty()) return std::nullopt;
  return fbi::Vec3(numbers[0], numbers[1], numbers[2]);
}

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

void add_difference_options(CLI::App& command, Arguments& arguments) {
  command
      .add_option("--field", arguments.fields,
                  "velocity (default), pressure, or centerline of the fibers; may be repeated")
      ->allow_extra_args(false);
  command.add_option("--norm", arguments.norms, "l2 (default), max (at the Gauss points), h1 (of the gradient)")
      ->allow_extra_args(false)
      ->check(CLI::IsMember({"l2", "max", "h1"}));
  CLI::Option* step = command.add_option("--step", arguments.step, "step of an output of the (first) run");
  command.add_option("--time", arguments.time, "time of an output (default: the last one that both have)")
      ->excludes(step);
  command.add_option("--exact", arguments.exact,
                     "three formulas of x, y, z, t: the velocity, or the position of the fiber point at (x, y, z)");
  command.add_option("--exact-pressure", arguments.exact_pressure, "one formula of x, y, z, t");
  command.add_flag("--remove-mean", arguments.remove_mean, "subtract the means, as for a pressure without level");
  command.add_option("--on", arguments.on, "integrate over the cells of the fine (default) or the coarse mesh")
      ->check(CLI::IsMember({"fine", "coarse"}));
  command.add_option("--points", arguments.points, "Gauss points in each direction of a cell (3)")
      ->check(CLI::Range(1, 10));
  command
      .add_option("--uncovered", arguments.uncovered,
                  "part of the volume that may lie in one of the meshes only (0.01)")
      ->check(CLI::Range(0.0, 1.0));
}

CLI::Option* add_output_choice(CLI::App& command, Arguments& arguments) {
  CLI::Option* step = command.add_option("--step", arguments.step, "step of an output (default: the last one)");
  return command.add_option("--time", arguments.time, "time of an output")->excludes(step);
}

void add_box_options(CLI::App& command, Arguments& arguments, const std::string& what) {
  command.add_option("--from", arguments.from_corner, "X Y Z: one corner of the box " + what)->expected(3);
  command.add_option("--to", arguments.to_corner, "X Y Z: the opposite corner, with larger coordinates")->expected(3);
}

void add_render_options(CLI::App& command, Arguments& arguments) {
  add_output_choice(command, arguments);
  command
      .add_option("--slice", arguments.slices,
                  "cut plane such as z=0.5, or none; may be repeated (default: one in the middle)")
      ->allow_extra_args(false);
  command.add_option("--quantity", arguments.quantity,
                     "on the slices: speed (default), velocity_x, pressure, mean_speed, reynolds_stress_xy ...");
  command.add_option("--range", arguments.range, "LOW HIGH: colors of the slices (default: of all nodes)")->expected(2);
  command.add_option("--opacity", arguments.opacity, "of the slices, 0 to 1 (1)")->check(CLI::Range(0.0, 1.0));
  command.add_option("--fibers", arguments.fiber_quantity,
                     "colors of the fibers: displacement (default), displacement_z, velocity_x, force_magnitude ..., "
                     "plain, or none to hide them");
  command.add_option("--fiber-range", arguments.fiber_range, "LOW HIGH: colors of the fibers")->expected(2);
  command.add_option("--radius", arguments.radius, "of the tubes (default: of the input)")->check(CLI::PositiveNumber);
  add_box_options(command, arguments, "that is shown (default: all)");
  command
      .add_option("--camera", arguments.camera,
                  "AZIMUTH ELEVATION of the eye in degrees (15 20); 0 0 looks straight at the x-y plane")
      ->expected(2);
  command.add_option("--up", arguments.up, "x, y (default), z: axis that points up")
      ->check(CLI::IsMember({"x", "y", "z"}));
  command
      .add_option("--perspective", arguments.view.opening, "opening angle of the camera in degrees (0: parallel rays)")
      ->check(CLI::Range(0.0, 150.0));
  command.add_option("--size", arguments.size, "WIDTH [HEIGHT] in pixels (1600, as high as needed)")
      ->expected(1, 2)
      ->check(CLI::Range(200, 8000));
}

/// Prints what is wrong and returns the exit code.
int run(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    std::fprintf(stderr, "fbi-post: error: %s\n", error.what());
    return static_cast<int>(error.code());
  }
  return static_cast<int>(ExitCode::ok);
}

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Tables, plots and pictures from the results of fbi-run; also while a run goes on.", "fbi-post");
  app.set_version_flag("--version", fbi::version_text("fbi-post"));
  app.require_subcommand(1);
  app.footer("Exit codes: 0 ok, 1 usage, 2 meshes that do not cover each other, 6 file error.");
  std::function<void()> action;
  const auto add = [&](const char* name, const char* about, void (*call)(const Arguments&)) {
    CLI::App* command = app.add_subcommand(name, about);
    command->callback([&action, &arguments, call] { action = [&arguments, call] { call(arguments); }; });
    return command;
  };

  CLI::App* tip_command = add("tip", "displacement of fiber ends over time: table and plot", tip);
  tip_command->add_option("runs", arguments.files, "results NAME.run.h5; several are compared")->required();
  tip_command
      ->add_option("--fiber", arguments.fibers, "name of a fiber, such as patch/112/7; may be repeated (default: all)")
      ->allow_extra_args(false);

  CLI::App* picture_command =
      add("picture", "speed in the middle plane of a box, with the fibers over it (PNG, SVG)", picture);
  picture_command->add_option("runs", arguments.files, "results NAME.run.h5")->required();
  picture_command->add_option("--step", arguments.step, "step of an output (default: the last one)");

  CLI::App* info_command = add("info", "what a case, result, step or checkpoint file holds", info);
  info_command->add_option("files", arguments.files, "HDF5 files of fbi-gen or fbi-run")->required();

  CLI::App* l2_command =
      add("l2", "difference of two runs on meshes that need not match, or of a run and formulas: table", l2);
  l2_command->add_option("runs", arguments.files, "results NAME.run.h5: one with formulas, or two")->required();
  add_difference_options(*l2_command, arguments);
  l2_command->footer(
      "The second run (the formula) is the reference of the relative difference. Example:\n"
      "  fbi-post l2 coarse.run.h5 fine.run.h5 --field velocity --field pressure --remove-mean --norm l2 --norm h1");

  CLI::App* convergence_command =
      add("convergence", "errors of several runs with observed orders: table and log-log plots", convergence);
  convergence_command->add_option("runs", arguments.files, "results NAME.run.h5")->required();
  convergence_command->add_option("--reference", arguments.reference, "the run that the others are compared with");
  convergence_command
      ->add_option("--against", arguments.against_name, "h (default), dt, elements, unknowns, wall (run time)")
      ->check(CLI::IsMember({"h", "dt", "elements", "unknowns", "wall"}));
  add_difference_options(*convergence_command, arguments);
  convergence_command
      ->add_option("--quantity", arguments.quantities,
                   "column of the history instead of a field, e.g. cylinder:force_x")
      ->allow_extra_args(false);
  convergence_command->add_option("--reference-value", arguments.reference_value, "what the quantity should be");
  convergence_command
      ->add_option("--reduce", arguments.reduce,
                   "of the quantity: last (default), max, min, max_abs, mean, middle, amplitude, frequency")
      ->check(CLI::IsMember({"last", "max", "min", "max_abs", "mean", "middle", "amplitude", "frequency"}));
  convergence_command->footer(
      "order: log(e1/e2)/|log(x1/x2)| of neighbours, x being what --against says. Example:\n"
      "  fbi-post convergence n8.run.h5 n16.run.h5 n32.run.h5 --exact \"y*(1-y),0,0\" --norm l2 --norm h1");

  CLI::App* energy_command =
      add("energy", "energies of fluid and fibers and work at the interface over time: table and plot", energy);
  energy_command->add_option("runs", arguments.files, "results NAME.run.h5")->required();

  CLI::App* forces_command =
      add("forces", "forces over time: mean, range, frequency, Strouhal number: table and plot", forces);
  forces_command->add_option("runs", arguments.files, "results NAME.run.h5")->required();
  forces_command
      ->add_option("--quantity", arguments.quantities, "columns of the history (default: all forces); may be repeated")
      ->allow_extra_args(false);
  forces_command->add_option("--length", arguments.length, "L of the Strouhal number f L/U")
      ->check(CLI::PositiveNumber);
  forces_command->add_option("--speed", arguments.speed, "U of the Strouhal number")->check(CLI::PositiveNumber);

  CLI::App* iterations_command =
      add("iterations", "iterations, evaluations and relaxation of each step, wall time: table and plot", iterations);
  iterations_command->add_option("runs", arguments.files, "results NAME.run.h5; several are compared")->required();

  CLI::App* profiles_command =
      add("profiles", "mean velocity and Reynolds stresses over a height, with the canopy height: table and plot",
          profiles);
  profiles_command->add_option("runs", arguments.files, "results NAME.run.h5")->required();
  profiles_command->add_option("--axis", arguments.axis, "x, y (default), z: direction of the height")
      ->check(CLI::IsMember({"x", "y", "z"}));
  add_box_options(*profiles_command, arguments, "that is averaged over (default: all of the fluid)");
  profiles_command
      ->add_option("--bins", arguments.bins,
                   "means over so many volumes (default: on the node layers of a box, else bins as high as cells)")
      ->check(CLI::Range(1, 100000));
  profiles_command->add_flag("--instantaneous", arguments.instantaneous,
                             "the flow of the output although the run has running means");
  add_output_choice(*profiles_command, arguments);
  profiles_command->footer(
      "Takes the running means of \"output\": { \"averages\": {} } when the run has them: reynolds_ij is the mean of\n"
      "v_i' v_j' in time, dispersive_ij the covariance of the means over the plane. Else the covariance of the "
      "velocity\n"
      "over the plane. Example:\n"
      "  fbi-post profiles canopy.run.h5 --from 6 0 0 --to 10 1 1");

  CLI::App* render_command =
      add("render", "fibers as tubes and cut planes of the flow in three dimensions (PNG)", render);
  render_command->add_option("runs", arguments.files, "results NAME.run.h5")->required();
  add_render_options(*render_command, arguments);
  render_command->footer(
      "Needs no display. Example:\n"
      "  fbi-post render canopy.run.h5 --slice z=0 --quantity velocity_x --fibers displacement_z --perspective 30");

  CLI::App* export_command =
      add("export", "VTK XML files (.vtu, .vtp, .pvd) that ParaView opens without HDF5 and XDMF", export_vtk);
  export_command->add_option("runs", arguments.files, "results NAME.run.h5")->required();
  CLI::Option* exported_step =
      export_command->add_option("--step", arguments.step, "step of an output (default: all outputs)");
  export_command->add_option("--time", arguments.time, "time of an output")->excludes(exported_step);
  export_command->add_flag("--single", arguments.single, "numbers of 4 bytes: half the size, 7 digits");
  CLI::App* precision_command =
      add("precision", "run time against error of series of runs, with slopes: table and log-log plot", precision);
  precision_command
      ->add_option("--series", arguments.series,
                   "a name and its runs, in the order of what differs; one line of the plot; may be repeated")
      ->required();
  precision_command->add_option("--reference", arguments.reference, "the finest run, with which all are compared")
      ->required();
  precision_command
      ->add_option("--series-reference", arguments.other_references,
                   "a name and a run: another reference for one series, such as one of meshes")
      ->allow_extra_args(false);
  precision_command
      ->add_option("--field", arguments.fields,
                   "what the error is of: tip (default, fiber ends over all steps), velocity, pressure, centerline (L2 "
                   "at the end); may be repeated, one plot each")
      ->allow_extra_args(false)
      ->check(CLI::IsMember({"tip", "velocity", "pressure", "centerline"}));
  precision_command->add_option("--fiber", arguments.fibers, "for tip: name of a fiber; may be repeated (default: all)")
      ->allow_extra_args(false);
  precision_command->footer(
      "slope: -log(e2/e1)/log(s2/s1) of neighbours, s being run times; that of least squares for a series. Example:\n"
      "  fbi-post precision --series \"time step\" a.run.h5 b.run.h5 --series bdf2 c.run.h5 --reference fine.run.h5");

  CLI::App* map_command = add("map", "what is stable for pairs of parameters: heat maps (PNG, SVG)", map);
  map_command->add_option("tables", arguments.files, "tables NAME.tsv of tools/stability")->required();
  map_command->add_option("--show", arguments.shown, "column whose numbers stand in the cells; may be repeated")
      ->allow_extra_args(false);

  CLI::App* verification_command =
      add("verification", "fills the tables of a page from what tests and cases recorded", verification);
  verification_command
      ->add_option("folders", arguments.files, "folders with rows (*.tsv): build/release/records, cases")
      ->required();
  verification_command->add_option("-o,--output", arguments.page, "the page to fill (docs/verification.md)");
  verification_command->add_flag("--quiet", arguments.quiet, "print warnings and errors only");

  for (CLI::App* command : {convergence_command, forces_command})
    command->add_option("--from", arguments.from, "leave out what is before this time");
  const std::vector<CLI::App*> plots = {tip_command,    convergence_command, energy_command,   forces_command,
                                        iterations_command, precision_command,   profiles_command};
  std::vector<CLI::App*> tables = plots;
  tables.push_back(l2_command);
  std::vector<CLI::App*> writers = tables;
  writers.insert(writers.end(), {picture_command, map_command, render_command, export_command});
  for (CLI::App* command : tables)
    command->add_option("--format", arguments.format, "of the table: text, csv, markdown, latex")
        ->check(CLI::IsMember({"text", "csv", "markdown", "latex"}));
  for (CLI::App* command : plots) command->add_flag("--no-plot", arguments.no_plot, "table only");
  for (CLI::App* command : writers) {
    command->add_option("-o,--output", arguments.directory, "directory for the files (default: beside the run)");
    command->add_flag("--quiet", arguments.quiet, "print the table, warnings and errors only");
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::usage);
  }
  return run([&] {
    fbi::log::configure(true, arguments.quiet);
    fbi::io::survive_file_size_limit();
    action();
  });
}
