/// Names of the files of a run.
#pragma once

#include <string>
#include <vector>

#include "base/types.hpp"

namespace fbi::io {

/// NAME.run.h5 and what lies beside it.
struct RunPaths {
  std::string index;      ///< NAME.run.h5
  std::string directory;  ///< NAME.run
  std::string xdmf;       ///< NAME.run.xdmf
  std::string csv;        ///< NAME.run.csv

  std::string mesh() const { return directory + "/mesh.h5"; }
  std::string expected() const { return directory + ".expected.tsv"; }  ///< what became of the expected values
  std::string step(GlobalIndex step) const;        ///< NAME.run/000050.h5
  std::string checkpoint(GlobalIndex step) const;  ///< NAME.run/restart-000050.h5
  std::string folder_name() const;                 ///< NAME.run without the directories above it

  /// Steps of the output (or checkpoint) files in the folder, ascending.
  std::vector<GlobalIndex> steps() const;
  std::vector<GlobalIndex> checkpoints() const;
};

/// From the path of the index, NAME.run.h5. Throws Error(usage) for a name that does not end in .h5.
RunPaths run_paths(const std::string& index);

/// From the path of a case file NAME.h5: the run lies beside it, or in `directory` when that is not empty.
RunPaths run_paths_of_case(const std::string& case_file, const std::string& directory = "");

}  // namespace fbi::io
