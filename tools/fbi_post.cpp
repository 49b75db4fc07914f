/// fbi-post: tables, plots and pictures from the results of fbi-run.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <functional>

#include "base/error.hpp"
#include "base/log.hpp"
#include "base/version.hpp"
#include "io/pending_file.hpp"
#include "tools/fbi_post_actions.hpp"

namespace {

using fbi::Error;
using fbi::ExitCode;
using namespace fbi::tools;

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
  const std::vector<CLI::App*> plots = {tip_command,        convergence_command, energy_command,  forces_command,
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
