/// What follows every accepted step: progress, history, output, checkpoints, reasons to stop.
#pragma once

#include <string>

#include "base/progress.hpp"
#include "case/case.hpp"
#include "case/crossing_fibers.hpp"
#include "case/expectations.hpp"
#include "case/probes.hpp"
#include "case/setup.hpp"
#include "fsi/time_loop.hpp"
#include "io/history.hpp"
#include "io/result_file.hpp"
#include "io/run_paths.hpp"

namespace fbi::cases {

/// Writes one field output from the accepted state. Throws Error(file). Collective.
void write_fields(const Setup& setup, io::ResultWriter& writer, GlobalIndex step, double time);

/// The observer of the time loop of one run.
class Recorder {
 public:
  /// Everything passed must outlive the recorder. `json`: text of the case, which checkpoints remember; the run goes
  /// from step `first` (done already, and saved unless it is 0) to `last`.
  Recorder(Setup& setup, const RunOptions& options, const io::RunPaths& paths, const std::string& json,
           GlobalIndex first, GlobalIndex last, io::ResultWriter& writer, io::History& history, const ProbeSet& probes,
           Expectations& expectations);

  /// Records an accepted step; returns whether the run shall stop before `last`. Throws Error(file), and
  /// Error(diverged) when a number is not finite. Collective.
  bool after_step(const fsi::StepClock& clock, const fsi::StepReport& report);

  /// After a failed step: the reason in the history; output and checkpoint of the last accepted state, where they are
  /// not there yet. Returns what a user should know about them, as the end of a sentence. Collective.
  std::string keep_last_state(const std::string& failure);

  /// The last step that was recorded; `first` before there is one.
  GlobalIndex last_step() const { return clock_.step; }
  /// Step of the newest checkpoint; 0: there is none.
  GlobalIndex saved_step() const { return saved_; }
  /// The last step met time.steady_tolerance: the run is complete.
  bool settled() const { return settled_; }
  double seconds() const { return progress_.seconds_total(); }
  /// "30 steps: 1.9 Newton and 4.2 Krylov iterations a step (most: 3 and 7)"; empty without steps.
  std::string iterations_text() const;

 private:
  void print_line(const fsi::StepClock& clock, const fsi::StepReport& report, double cfl, double violation,
                  double seconds);
  void output(const fsi::StepClock& clock);
  void save(const fsi::StepClock& clock);

  Setup& setup_;
  const RunOptions& options_;
  const io::RunPaths& paths_;
  const std::string& json_;
  GlobalIndex first_, last_;
  io::ResultWriter& writer_;
  io::History& history_;
  const ProbeSet& probes_;
  Expectations& expectations_;
  CrossingFibers crossings_;
  Progress progress_;
  fsi::StepClock clock_;  // of the last step recorded
  bool settled_ = false;
  bool sound_ = true;  // the accepted state is that of clock_
  GlobalIndex written_, saved_;
  double saved_at_ = 0.0;  // [s]
  long lines_ = 0;
  struct Count {
    long sum = 0;
    int most = 0;
    void add(int value);
  };
  Count newton_, krylov_, coupling_;
  long divided_ = 0, repeated_ = 0;  // steps done in parts, attempts that were repeated
  double smallest_dt_ = 0.0;
};

}  // namespace fbi::cases
