/// fbi-post: tables, plots and pictures from the results of fbi-run.
#include <CLI/CLI.hpp>
#include <cstdio>
#include <filesystem>
#include <optional>

#include "base/error.hpp"
#include "base/log.hpp"
#include "base/version.hpp"
#include "io/pending_file.hpp"
#include "post/info.hpp"
#include "post/picture.hpp"
#include "post/plot.hpp"
#include "post/reader.hpp"
#include "post/table.hpp"
#include "post/tip.hpp"

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

void tip(const Arguments& arguments) {
  const TableFormat format = *table_format(arguments.format);
  std::vector<Run> runs;
  std::vector<TipSeries> tips;
  for (const std::string& file : arguments.files) {
    runs.push_back(read_run(file));
    for (TipSeries& series : read_tips(runs.back(), arguments.fibers)) tips.push_back(std::move(series));
  }
  const std::string base = base_name(arguments, runs, "tip");
  const std::string text = format_table(tip_table(tips), format);
  fbi::io::write_text_file(base + file_ending(format), text);
  print(text);
  say_written({base + file_ending(format)});
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

}  // namespace

int main(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Tables, plots and pictures from the results of fbi-run; also while a run goes on.", "fbi-post");
  app.set_version_flag("--version", fbi::version_text("fbi-post"));
  app.require_subcommand(1);
  app.footer("Exit codes: 0 ok, 1 usage, 6 file error.");

  CLI::App* tip_command = app.add_subcommand("tip", "displacement of fiber ends over time: table and plot");
  tip_command->add_option("runs", arguments.files, "results NAME.run.h5; several are compared")->required();
  tip_command
      ->add_option("--fiber", arguments.fibers, "name of a fiber, such as patch/112/7; may be repeated (default: all)")
      ->allow_extra_args(false);
  tip_command->add_option("--format", arguments.format, "of the table: text, csv, markdown, latex")
      ->check(CLI::IsMember({"text", "csv", "markdown", "latex"}));
  tip_command->add_flag("--no-plot", arguments.no_plot, "table only");

  CLI::App* picture_command =
      app.add_subcommand("picture", "speed in the middle plane of a box, with the fibers over it (PNG, SVG)");
  picture_command->add_option("runs", arguments.files, "results NAME.run.h5")->required();
  picture_command->add_option("--step", arguments.step, "step of an output (default: the last one)");

  CLI::App* info_command = app.add_subcommand("info", "what a case, result, step or checkpoint file holds");
  info_command->add_option("files", arguments.files, "HDF5 files of fbi-gen or fbi-run")->required();

  for (CLI::App* command : {tip_command, picture_command}) {
    command->add_option("-o,--output", arguments.directory, "directory for the files (default: beside the run)");
    command->add_flag("--quiet", arguments.quiet, "print the table, warnings and errors only");
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : static_cast<int>(ExitCode::usage);
  }
  try {
    fbi::log::configure(true, arguments.quiet);
    fbi::io::survive_file_size_limit();
    if (*tip_command) tip(arguments);
    if (*picture_command) picture(arguments);
    if (*info_command) info(arguments);
  } catch (const Error& error) {
    std::fprintf(stderr, "fbi-post: error: %s\n", error.what());
    return static_cast<int>(error.code());
  }
  return static_cast<int>(ExitCode::ok);
}
