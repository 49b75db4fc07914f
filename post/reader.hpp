/// Results of a run, read by one process; also while the run goes on.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "io/history.hpp"
#include "io/run_paths.hpp"
#include "io/xdmf.hpp"

namespace fbi::post {

/// What there is of a run so far.
struct Run {
  io::RunPaths paths;
  std::string name;                         ///< NAME of NAME.run.h5
  bool complete = false;                    ///< the run reached its end
  std::vector<io::StepTime> outputs;        ///< ascending
  std::optional<io::HistoryTable> history;  ///< missing when the run has none (yet)
};

/// Reads index, folder and history: outputs that the index does not list yet are found in the folder, and a history
/// that is not in the index yet in NAME.run.csv. Throws Error(file) when there is no such run, Error(usage) for a name
/// without .h5.
Run read_run(const std::string& index_path);

/// The fiber names of a run in file order; empty without fibers. Throws Error(file).
std::vector<std::string> fiber_names(const Run& run);

}  // namespace fbi::post
