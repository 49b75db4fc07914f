/// Runs one case from its file to its results.
#pragma once

#include <optional>
#include <string>

#include "base/error.hpp"
#include "base/types.hpp"

namespace fbi::cases {

/// What the command line says.
struct RunOptions {
  std::string case_path;
  std::string output;         ///< result file; empty = NAME.run.h5 beside the case file
  std::string restart;        ///< empty, "last" or a step
  std::string command;        ///< for the record
  GlobalIndex steps = 0;      ///< stop after this many steps; 0 = go to the end
  double max_walltime = 0.0;  ///< minutes; 0 = no limit
  bool dry_run = false;
  bool quiet = false;
};

/// Reads the case, runs it, writes results, history and checkpoints. Returns the exit code of the program; throws Error
/// on all ranks for everything that is wrong before the first step and for files that cannot be written. Collective.
ExitCode run_case(const RunOptions& options);

}  // namespace fbi::cases
