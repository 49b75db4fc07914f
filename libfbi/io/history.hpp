/// The history of a run, NAME.run.csv: one row a step.
///
///     # comment lines start with #
///     # units: -,time,...
///     step,time,dt,newton,...
///     1,0.0001,...
///     # failed: step 2 (t = 0.0002): ...
///     # work: linear solves = 2
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/comm.hpp"
#include "base/counters.hpp"
#include "base/types.hpp"

namespace fbi::io {

/// A named column with its unit ("-", "time", "length", ...); neither holds commas.
struct HistoryColumn {
  std::string name;
  std::string unit;
};

/// The columns every history begins with: step, time, dt, newton, krylov, coupling_iterations, evaluations, residual,
/// cfl, constraint_violation, wall_seconds.
const std::vector<HistoryColumn>& standard_history_columns();

/// Writes rows as they come; rank 0 holds the file.
class History {
 public:
  /// Starts a new file, or with `restart_step` goes on with the old one without its rows after that step (and without a
  /// last row that a kill left incomplete). Throws Error(file); when the columns of the old file differ, too.
  /// Collective.
  History(const Comm& comm, const std::string& path, const std::string& title,
          const std::vector<HistoryColumn>& columns, std::optional<GlobalIndex> restart_step = std::nullopt);
  ~History();
  History(const History&) = delete;
  History& operator=(const History&) = delete;

  /// Appends one row, one number per column, with 17 digits, and hands it to the system. Only the values of rank 0
  /// count. Throws Error(file) on all ranks when it cannot be written. Collective.
  void write(const std::vector<double>& row);
  /// Appends why the step after the last row failed, on one line; going on from a checkpoint drops it. Throws as write.
  /// Collective.
  void write_failure(const std::string& reason);
  /// Appends a comment line "# work: 'what' = 'number'" for each count of the run that ends here; going on from a
  /// checkpoint drops them. Throws as write. Collective.
  void write_work(const std::vector<Counted>& work);

 private:
  void append(const std::string& line);          // rank 0
  void append_on_root(const std::string& text);  // Collective.

  Comm comm_;
  std::string path_;
  std::size_t columns_;
  int descriptor_ = -1;
};

/// A history as read from a file.
struct HistoryTable {
  std::vector<std::string> columns;
  std::vector<std::string> units;
  std::vector<std::vector<double>> rows;  ///< shape=(rows,columns)
  std::string failure;                    ///< why the step after the last row failed; empty when none did
  std::vector<Counted> work;              ///< of the program run that wrote the last rows; empty while it goes on

  /// Number of a column, -1 when there is none of that name.
  int column(const std::string& name) const;
};

/// Reads a history, also of a run that is still going on: an incomplete last row is left out. Throws Error(file).
HistoryTable read_history(const std::string& path);

}  // namespace fbi::io
