/// fbi-run: solves a case file written by fbi-gen.
#include <mpi.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <new>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/log.hpp"
#include "base/signals.hpp"
#include "base/version.hpp"
#include "case/case.hpp"
#include "linalg/petsc.hpp"

namespace {

int parse_and_run(int argc, char** argv, int rank) {
  fbi::cases::RunOptions options;
  CLI::App app("Solves a case: fluid, fibers, or both together. On several cores: mpirun -n N fbi-run NAME.h5",
               "fbi-run");
  bool version = false;
  const CLI::Validator positive(
      [](const std::string& text) {
        double value = 0.0;
        return CLI::detail::lexical_cast(text, value) && value > 0.0 ? std::string()
                                                                     : "must be a number above 0, not " + text;
      },
      "> 0");
  app.add_flag("--version", version, "revision, build type and libraries");
  app.add_option("case", options.case_path, "case file written by fbi-gen (NAME.h5)");
  app.add_option("-o,--output", options.output, "result file; default NAME.run.h5 beside the case file");
  app.add_option("--restart", options.restart,
                 "go on from a checkpoint: 'last' or a step number; on any number of ranks");
  app.add_option("--steps", options.steps, "stop with a checkpoint after this many steps")->check(positive);
  app.add_option("--max-walltime", options.max_walltime, "stop with a checkpoint after this many minutes")
      ->check(positive);
  app.add_flag("--dry-run", options.dry_run, "say what would be done: sizes, memory, disk, dimensionless numbers");
  app.add_flag("--quiet", options.quiet, "only warnings and errors");
  app.footer(
      "SIGTERM, SIGINT (Ctrl-C) or SIGUSR1 stop after the current step, with a checkpoint; under mpirun send SIGUSR1 "
      "to\n"
      "mpirun: it kills its processes a moment after the other two.\n"
      "Exit codes: 0 ok, 1 usage or input, 2 geometry, 3 stopped early with a checkpoint, 4 diverged, 5 expected "
      "values\n"
      "missed, 6 file error.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (rank == 0) app.exit(error);
    return error.get_exit_code() == 0 ? 0 : static_cast<int>(fbi::ExitCode::usage);
  }
  fbi::log::configure(rank == 0, options.quiet);
  if (version) {
    if (rank == 0) std::printf("%s\n", fbi::version_text("fbi-run").c_str());
    return 0;
  }
  if (options.case_path.empty()) {
    fbi::log::error("no case file given; usage: fbi-run CASE.h5 (--help tells more)");
    return static_cast<int>(fbi::ExitCode::usage);
  }
  for (int k = 0; k < argc; ++k) options.command += std::string(k > 0 ? " " : "") + argv[k];
  return static_cast<int>(fbi::cases::run_case(options));
}

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  fbi::log::configure(rank == 0, false);
  int code = 0;
  try {
    fbi::catch_signals();
    code = parse_and_run(argc, argv, rank);
  } catch (const fbi::Error& error) {
    // Thrown on every rank or on none.
    fbi::log::error("%s", error.what());
    code = static_cast<int>(error.code());
  } catch (const std::exception& error) {
    // Nobody else knows of this one: the other ranks may wait in a collective call.
    const bool memory = dynamic_cast<const std::bad_alloc*>(&error) != nullptr;
    std::fprintf(stderr, "error: rank %d: %s\n", rank,
                 memory ? "not enough memory; fbi-run --dry-run tells how much the case needs" : error.what());
    int size = 1;
    MPI_Comm_size(MPI_COMM_WORLD, &size);
    if (size > 1) MPI_Abort(MPI_COMM_WORLD, static_cast<int>(fbi::ExitCode::diverged));
    code = static_cast<int>(fbi::ExitCode::diverged);
  }
  fbi::linalg::finalize_petsc();
  MPI_Finalize();
  return code;
}
