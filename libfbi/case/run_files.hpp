/// Checks of the files a run reads and writes, before it touches any of them.
#pragma once

#include <string>

#include "base/comm.hpp"
#include "io/case_file.hpp"
#include "io/run_paths.hpp"

namespace fbi::cases {

/// Refuses what fbi-gen has not made yet, and says so. Throws Error(usage or file). Collective.
void check_case_path(const Comm& comm, const std::string& case_path);

/// Refuses to write where there is no folder, over the case file, or over files that no run has written. Throws
/// Error(file). Collective.
void check_result_paths(const Comm& comm, const std::string& case_path, const io::RunPaths& paths);

/// Warns where the JSON text beside the case file is not the one it was made from.
void warn_if_outdated(const Comm& comm, const std::string& case_path, const io::CaseHeader& header);

/// Warns that a run without restart replaces one that has not come to its end.
void warn_of_unfinished_run(const Comm& comm, const io::RunPaths& paths);

/// Writes what became of the expected values, or removes what an older run left when `rows` is empty. Throws
/// Error(file). Collective.
void write_expected(const Comm& comm, const io::RunPaths& paths, const std::string& rows);

}  // namespace fbi::cases
