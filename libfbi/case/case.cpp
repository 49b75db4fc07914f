#include "case/case.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "base/log.hpp"
#include "base/progress.hpp"
#include "base/signals.hpp"
#include "base/timer.hpp"
#include "base/version.hpp"
#include "case/checkpoints.hpp"
#include "case/expectations.hpp"
#include "case/probes.hpp"
#include "case/scene.hpp"
#include "case/setup.hpp"
#include "fsi/time_loop.hpp"
#include "io/case_file.hpp"
#include "io/history.hpp"
#include "io/result_file.hpp"

namespace fbi::cases {
namespace {

/// Writes one field output from the accepted state.
void write_fields(const Setup& setup, io::ResultWriter& writer, GlobalIndex step, double time) {
  Timed timed("output");
  std::vector<io::NodeField> fields;
  const double* values = nullptr;
  if (setup.fluid != nullptr) {
    FBI_PETSC(VecGetArrayRead(setup.fluid->accepted(), &values));
    fields.push_back({"velocity", 3, 4, 0, values});
    fields.push_back({"pressure", 1, 4, 3, values});
  }
  io::FiberState fibers;
  if (setup.beams != nullptr) {
    fibers.dofs = &setup.beams->accepted_dofs();
    fibers.velocity = &setup.beams->accepted_velocity();
    if (setup.system->is_coupled()) fibers.force = &setup.system->lambda_old();
  }
  writer.write_step(step, time, fields, fibers);
  if (setup.fluid != nullptr) FBI_PETSC(VecRestoreArrayRead(setup.fluid->accepted(), &values));
}

/// Everything that happens after an accepted step: progress, history, output, checkpoints, reasons to stop.
class Recorder {
 public:
  Recorder(Setup& setup, const RunOptions& options, const io::RunPaths& paths, const std::string& json, GlobalIndex first,
           GlobalIndex last, io::ResultWriter& writer, io::History& history, const ProbeSet& probes,
           Expectations& expectations)
      : setup_(setup),
        options_(options),
        paths_(paths),
        json_(json),
        last_(last),
        writer_(writer),
        history_(history),
        probes_(probes),
        expectations_(expectations),
        progress_(first, last),
        saved_(first) {}

  bool after_step(const fsi::StepClock& clock, const fsi::StepReport& report) {
    const Comm& comm = setup_.fiber_mesh->comm;
    const Output& output = setup_.parameters.output;
    last_clock_ = clock;
    const double cfl = setup_.fluid != nullptr ? setup_.fluid->cfl() : 0.0;
    const double violation = setup_.system->constraint_violation();
    std::vector<double> values = probes_.values(*setup_.system);
    const bool finite =
        std::isfinite(cfl) && std::isfinite(violation) &&
        std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
    const double seconds = comm.max(progress_.step_done(clock.step));
    std::vector<double> row = {static_cast<double>(clock.step), clock.time, clock.dt, static_cast<double>(report.newton),
                               static_cast<double>(report.krylov), static_cast<double>(report.coupling_iterations),
                               static_cast<double>(report.evaluations), report.residual, cfl, violation, seconds};
    row.insert(row.end(), values.begin(), values.end());
    history_.write(row);
    expectations_.add_row(clock.time, row);
    print_line(clock, report, cfl, violation, seconds);
    if (!finite) throw Error(ExitCode::diverged, log::format("step %lld holds a number that is not finite; the history shows "
                                                             "where; try a smaller time.step",
                                                             static_cast<long long>(clock.step)));
    if (clock.step == last_ || (output.every > 0 && clock.step % output.every == 0))
      write_fields(setup_, writer_, clock.step, clock.time);

    const bool signaled = comm.any(caught_signal() != 0);
    const bool late = options_.max_walltime > 0.0 && comm.max(progress_.seconds_total()) > 60.0 * options_.max_walltime;
    const bool by_clock = comm.max(progress_.seconds_total()) - saved_at_ > 60.0 * output.checkpoint_minutes;
    if (clock.step == last_ || signaled || late || by_clock ||
        (output.checkpoint > 0 && clock.step % output.checkpoint == 0))
      save(clock);
    if (clock.step == last_) return false;
    if (signaled) log::warning("stopped by signal %d after step %lld", caught_signal(), static_cast<long long>(clock.step));
    if (late && !signaled)
      log::warning("the wall-time limit of %g min is reached after step %lld", options_.max_walltime,
                   static_cast<long long>(clock.step));
    return signaled || late;
  }

  /// A checkpoint of the last accepted state, unless that is saved already.
  void save(const fsi::StepClock& clock) {
    if (saved_ == clock.step) return;
    save_checkpoint(setup_, paths_, json_, clock.step, clock.time);
    saved_ = clock.step;
    saved_at_ = setup_.fiber_mesh->comm.max(progress_.seconds_total());
  }
  const fsi::StepClock& last_clock() const { return last_clock_; }
  double seconds() const { return progress_.seconds_total(); }

 private:
  void print_line(const fsi::StepClock& clock, const fsi::StepReport& report, double cfl, double violation, double seconds) {
    const bool partitioned = setup_.acceleration != nullptr;
    std::string iterations = partitioned ? log::format("%3d coupling ", report.coupling_iterations) : "";
    iterations += log::format("%2d newton %3d krylov", report.newton, report.krylov);
    log::info("%5.1f %%  step %lld  t %.6g  %s  residual %.1e  CFL %.2f  slip %.1e  %.3f s/step  ETA %s", progress_.percent(),
              static_cast<long long>(clock.step), clock.time, iterations.c_str(), report.residual, cfl, violation, seconds,
              duration_text(progress_.seconds_left()).c_str());
  }

  Setup& setup_;
  const RunOptions& options_;
  const io::RunPaths& paths_;
  const std::string& json_;
  GlobalIndex last_;
  io::ResultWriter& writer_;
  io::History& history_;
  const ProbeSet& probes_;
  Expectations& expectations_;
  Progress progress_;
  fsi::StepClock last_clock_;
  GlobalIndex saved_;
  double saved_at_ = 0.0;
};

std::vector<io::HistoryColumn> history_columns(const ProbeSet& probes) {
  std::vector<io::HistoryColumn> columns = io::standard_history_columns();
  for (std::size_t k = 0; k < probes.columns().size(); ++k) columns.push_back({probes.columns()[k], probes.units()[k]});
  return columns;
}

void print_end(const Setup& setup, const Recorder& recorder) {
  const Comm& comm = setup.fiber_mesh->comm;
  const double all = comm.sum(peak_memory()), largest = comm.max(peak_memory());
  log::info("\ntimes of rank 0");
  log::info("%s", timer_report().c_str());
  log::info("wall time %s, peak memory %s (largest rank %s)", duration_text(recorder.seconds()).c_str(),
            memory_text(all).c_str(), memory_text(largest).c_str());
}

}  // namespace

ExitCode run_case(const RunOptions& options) {
  const Comm comm;
  const io::RunPaths paths =
      options.output.empty() ? io::run_paths_of_case(options.case_path) : io::run_paths(options.output);
  const io::CaseHeader header = io::read_case_header(comm, options.case_path);
  Setup setup = read_setup(comm, options.case_path);
  const CaseParameters& parameters = setup.parameters;
  if (!parameters.title.empty()) log::info("%s", parameters.title.c_str());
  log::info("%d rank%s, %lld step%s of %g", comm.size(), comm.size() > 1 ? "s" : "", static_cast<long long>(setup.steps),
            setup.steps > 1 ? "s" : "", setup.dt);
  const ProbeSet probes(parameters.output.probes, *setup.fiber_mesh, setup.fluid_mesh.get());
  const std::vector<io::HistoryColumn> columns = history_columns(probes);
  std::vector<std::string> names;
  for (const io::HistoryColumn& column : columns) names.push_back(column.name);
  Expectations expectations(parameters.expect, names);
  if (options.dry_run || !options.quiet)
    print_scene(inspect(parameters, setup.fluid_mesh.get(), *setup.fiber_mesh, setup.fluid.get(), setup.beams.get()), parameters);
  print_skipped(parameters, *setup.system, setup.fluid_mesh != nullptr && setup.fluid_mesh->box.has_value());
  if (options.dry_run) return ExitCode::ok;

  GlobalIndex first = 0;
  std::optional<GlobalIndex> restart;
  if (!options.restart.empty()) {
    first = load_checkpoint(setup, paths, header.json, options.restart);
    restart = first;
    log::info("restarted from step %lld", static_cast<long long>(first));
    if (first >= setup.steps) log::info("the run is complete already; nothing to do");
  } else {
    initialize(setup);
  }
  const io::Provenance provenance{header.json, header.json_name, version_text("fbi-run"), options.command, comm.size()};
  io::ResultWriter writer(comm, paths, setup.fluid_mesh.get(), setup.beams != nullptr ? setup.fiber_mesh.get() : nullptr,
                          provenance, parameters.output.fiber_points, restart);
  io::History history(comm, paths.csv, parameters.title, columns, restart);
  if (restart)
    for (const std::vector<double>& row : io::read_history(paths.csv).rows) expectations.add_row(row[1], row);
  else
    write_fields(setup, writer, 0, 0.0);

  const GlobalIndex end = options.steps > 0 ? std::min(setup.steps, first + options.steps) : setup.steps;
  Recorder recorder(setup, options, paths, header.json, first, end, writer, history, probes, expectations);
  std::string failure;
  fsi::LoopEnd ended = fsi::LoopEnd::finished;
  try {
    ended = fsi::run_time_loop(
        *setup.system, setup.acceleration.get(), first, end, setup.dt,
        [&recorder](const fsi::StepClock& clock, const fsi::StepReport& report) { return recorder.after_step(clock, report); },
        failure);
  } catch (const Error& error) {
    if (error.code() != ExitCode::diverged && error.code() != ExitCode::geometry) throw;
    // The last accepted state is sound: keep it.
    failure = error.what();
    if (recorder.last_clock().step > first && error.code() == ExitCode::geometry) recorder.save(recorder.last_clock());
    writer.finish();
    throw Error(error.code(), failure);
  }
  if (ended == fsi::LoopEnd::failed) {
    if (recorder.last_clock().step > first) {
      write_fields(setup, writer, recorder.last_clock().step, recorder.last_clock().time);
      recorder.save(recorder.last_clock());
      failure += log::format("; the state after step %lld is saved: fbi-run %s --restart last goes on from it",
                             static_cast<long long>(recorder.last_clock().step), options.case_path.c_str());
    }
    throw Error(ExitCode::diverged, failure);
  }
  if (ended == fsi::LoopEnd::finished) writer.finish();
  if (!options.quiet) print_end(setup, recorder);
  log::info("results in %s", paths.index.c_str());
  if (ended == fsi::LoopEnd::stopped) {
    log::info("go on with: fbi-run %s --restart last", options.case_path.c_str());
    return ExitCode::stopped;
  }
  if (end == setup.steps && !expectations.report()) return ExitCode::expectation;
  return ExitCode::ok;
}

}  // namespace fbi::cases
