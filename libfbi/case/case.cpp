#include "case/case.hpp"

#include <algorithm>

#include "base/counters.hpp"
#include "base/log.hpp"
#include "base/progress.hpp"
#include "base/timer.hpp"
#include "base/version.hpp"
#include "case/bulk_flow.hpp"
#include "case/checkpoints.hpp"
#include "case/energies.hpp"
#include "case/recorder.hpp"
#include "case/run_files.hpp"
#include "case/scene.hpp"
#include "case/stability.hpp"

namespace fbi::cases {
namespace {

std::vector<io::HistoryColumn> history_columns(const ProbeSet& probes, const Setup& setup) {
  std::vector<io::HistoryColumn> columns = io::standard_history_columns();
  if (setup.acceleration != nullptr) columns.insert(columns.end(), {{"relaxation", "-"}, {"interface_krylov", "-"}});
  for (std::size_t k = 0; k < probes.columns().size(); ++k) columns.push_back({probes.columns()[k], probes.units()[k]});
  for (const io::HistoryColumn& column : bulk_flow_columns(*setup.system)) columns.push_back(column);
  for (const io::HistoryColumn& column : energy_columns(*setup.system)) columns.push_back(column);
  for (const io::HistoryColumn& column : CrossingFibers::columns(setup)) columns.push_back(column);
  return columns;
}

/// Error at the end of a run: the texts joined, with the exit code.
[[noreturn]] void fail(ExitCode code, const std::string& what, const std::string& remedy) {
  throw Error(code, remedy.empty() ? what : what + "; " + remedy);
}

/// NAME of NAME.run.h5.
std::string case_name(const io::RunPaths& paths) {
  const std::string folder = paths.folder_name();
  return folder.substr(0, folder.rfind(".run"));
}

void print_columns(const Setup& setup) {
  if (setup.fluid == nullptr) return;
  log::info("columns       residual: relative, at the end of the step (0: round-off); CFL: largest |v| dt / h");
  if (setup.system->is_coupled())
    log::info("              slip: largest |v_fluid - v_fiber| along the fibers over the largest |v|");
}

void print_end(const Setup& setup, const Recorder& recorder, const std::vector<Counted>& work) {
  const Comm& comm = setup.fiber_mesh->comm;
  const double all = comm.sum(peak_memory()), largest = comm.max(peak_memory());
  log::info("\ntimes of rank 0\n%s", timer_report().c_str());
  log::info("work of all ranks\n%s", counter_report(work).c_str());
  const std::string iterations = recorder.iterations_text();
  if (!iterations.empty()) log::info("%s", iterations.c_str());
  log::info("wall time %s, peak memory %s (largest rank %s)", duration_text(recorder.seconds()).c_str(),
            memory_text(all).c_str(), memory_text(largest).c_str());
}

/// Steps to `end`; a failed step leaves the last good state in an output and a checkpoint, and throws.
fsi::LoopEnd step_to_the_end(Setup& setup, const RunOptions& options, Recorder& recorder, GlobalIndex end) {
  std::string failure;
  ExitCode code = ExitCode::diverged;
  fsi::LoopEnd ended = fsi::LoopEnd::failed;
  try {
    ended = fsi::run_time_loop(
        *setup.system, setup.acceleration.get(), setup.step_control, recorder.last_step(), end, setup.dt,
        [&recorder](const fsi::StepClock& clock, const fsi::StepReport& report) {
          return recorder.after_step(clock, report);
        },
        failure);
  } catch (const Error& error) {
    if (error.code() == ExitCode::file) {
      std::string remedy;
      if (recorder.saved_step() > 0)
        remedy =
            log::format("what was written before is complete, and fbi-run %s --restart last goes on from step %lld",
                        options.case_path.c_str(), static_cast<long long>(recorder.saved_step()));
      fail(error.code(), error.what(), remedy);
    }
    const GlobalIndex step = recorder.last_step() + 1;
    failure = log::format("step %lld (t = %.6g): %s", static_cast<long long>(step),
                          static_cast<double>(step) * setup.dt, error.what());
    code = error.code();
  }
  if (ended == fsi::LoopEnd::failed) fail(code, failure, recorder.keep_last_state(failure));
  return ended;
}

}  // namespace

ExitCode run_case(const RunOptions& options) {
  const Comm comm;
  check_case_path(comm, options.case_path);
  const io::RunPaths paths =
      options.output.empty() ? io::run_paths_of_case(options.case_path) : io::run_paths(options.output);
  const io::CaseHeader header = io::read_case_header(comm, options.case_path);
  Setup setup = read_setup(comm, options.case_path);
  const CaseParameters& parameters = setup.parameters;
  if (!parameters.title.empty()) log::info("%s", parameters.title.c_str());
  if (setup.dt > 0.0)
    log::info("%d rank%s, %lld step%s of %g", comm.size(), comm.size() > 1 ? "s" : "",
              static_cast<long long>(setup.steps), setup.steps > 1 ? "s" : "", setup.dt);
  else
    log::info("%d rank%s, steady", comm.size(), comm.size() > 1 ? "s" : "");
  warn_if_outdated(comm, options.case_path, header);
  ProbeSet probes(parameters.output.probes, *setup.fiber_mesh, setup.fluid_mesh.get());
  probes.add_forces(parameters.output.forces, setup.fluid.get());
  const std::vector<io::HistoryColumn> columns = history_columns(probes, setup);
  std::vector<std::string> names;
  for (const io::HistoryColumn& column : columns) names.push_back(column.name);
  Expectations expectations(parameters.expect, names);
  const Scene scene = inspect(setup);
  if (!options.quiet) {
    print_scene(scene, setup);
    print_skipped(parameters, *setup.system, setup.fluid_mesh != nullptr && setup.fluid_mesh->box.has_value(),
                  scene.direct);
  }
  for (const std::string& text : stability_warnings(stability_numbers(setup, scene), parameters))
    log::warning("%s", text.c_str());
  const std::string memory = memory_warning(setup, scene.memory);
  if (!memory.empty()) log::warning("%s", memory.c_str());
  if (options.dry_run) return ExitCode::ok;

  check_result_paths(comm, options.case_path, paths);
  GlobalIndex first = 0;
  std::optional<GlobalIndex> restart;
  if (!options.restart.empty()) {
    first = load_checkpoint(setup, paths, header.json, options.restart);
    restart = first;
    log::info("restarted from step %lld", static_cast<long long>(first));
    if (first >= setup.steps) log::info("the run is complete already; nothing is left to do");
  } else {
    warn_of_unfinished_run(comm, paths);
    write_expected(comm, paths, "");
    initialize(setup);
  }
  const io::Provenance provenance{header.json, header.json_name, version_text("fbi-run"), options.command, comm.size()};
  io::ResultWriter writer(comm, paths, setup.fluid_mesh.get(),
                          setup.beams != nullptr ? setup.fiber_mesh.get() : nullptr, provenance,
                          parameters.output.fiber_points, restart);
  io::History history(comm, paths.csv, parameters.title, columns, restart);
  if (restart)
    for (const std::vector<double>& row : io::read_history(paths.csv).rows) expectations.add_row(row[1], row);
  else
    write_fields(setup, writer, 0, 0.0);

  const GlobalIndex end = options.steps > 0 ? std::min(setup.steps, first + options.steps) : setup.steps;
  Recorder recorder(setup, options, paths, header.json, first, end, writer, history, probes, expectations);
  if (first < end) print_columns(setup);
  const fsi::LoopEnd ended = step_to_the_end(setup, options, recorder, end);
  const bool complete = recorder.settled() || (ended == fsi::LoopEnd::finished && end == setup.steps);
  const std::vector<Counted> work = counted_work(comm);
  history.write_work(work);
  if (complete) writer.finish();
  if (!options.quiet) print_end(setup, recorder, work);
  log::info("results in %s", paths.index.c_str());
  if (!complete) log::info("go on with: fbi-run %s --restart last", options.case_path.c_str());
  if (ended == fsi::LoopEnd::stopped && !recorder.settled()) return ExitCode::stopped;
  if (!complete) return ExitCode::ok;
  const bool met = expectations.report();
  if (!expectations.empty()) write_expected(comm, paths, expectations.rows(case_name(paths)));
  return met ? ExitCode::ok : ExitCode::expectation;
}

}  // namespace fbi::cases
