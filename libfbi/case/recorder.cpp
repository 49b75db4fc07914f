#include "case/recorder.hpp"

#include <algorithm>
#include <cmath>

#include "base/counters.hpp"
#include "base/error.hpp"
#include "base/log.hpp"
#include "base/signals.hpp"
#include "base/timer.hpp"
#include "case/bulk_flow.hpp"
#include "case/checkpoints.hpp"
#include "case/energies.hpp"

namespace fbi::cases {
namespace {

constexpr long lines_between_headers = 50;

bool is_finite(double cfl, double violation, const std::vector<double>& values) {
  return std::isfinite(cfl) && std::isfinite(violation) &&
         std::all_of(values.begin(), values.end(), [](double value) { return std::isfinite(value); });
}

}  // namespace

void write_fields(const Setup& setup, io::ResultWriter& writer, GlobalIndex step, double time) {
  Timed timed("output");
  count("outputs");
  std::vector<io::NodeField> fields;
  Vec form = nullptr;  // with ghosts: images of periodic faces are among them
  const double* values = nullptr;
  if (setup.fluid != nullptr) {
    FBI_PETSC(VecGhostGetLocalForm(setup.fluid->accepted(), &form));
    FBI_PETSC(VecGetArrayRead(form, &values));
    fields.push_back({"velocity", 3, 4, 0, values});
    fields.push_back({"pressure", 1, 4, 3, values});
    if (setup.averages != nullptr)
      for (const io::NodeField& field : setup.averages->fields()) fields.push_back(field);
  }
  io::FiberState fibers;
  std::vector<double> force;
  if (setup.beams != nullptr) {
    fibers.dofs = &setup.beams->accepted_dofs();
    fibers.velocity = &setup.beams->accepted_velocity();
    if (setup.system->is_coupled()) {
      force = setup.system->line_force();
      fibers.force = &force;
    }
  }
  writer.write_step(step, time, fields, fibers);
  if (setup.fluid == nullptr) return;
  FBI_PETSC(VecRestoreArrayRead(form, &values));
  FBI_PETSC(VecGhostRestoreLocalForm(setup.fluid->accepted(), &form));
}

void Recorder::Count::add(int value) {
  sum += value;
  most = std::max(most, value);
}

Recorder::Recorder(Setup& setup, const RunOptions& options, const io::RunPaths& paths, const std::string& json,
                   GlobalIndex first, GlobalIndex last, io::ResultWriter& writer, io::History& history,
                   const ProbeSet& probes, Expectations& expectations)
    : setup_(setup),
      options_(options),
      paths_(paths),
      json_(json),
      first_(first),
      last_(last),
      writer_(writer),
      history_(history),
      probes_(probes),
      expectations_(expectations),
      crossings_(setup),
      progress_(first, last),
      clock_{first, static_cast<double>(first) * setup.dt, setup.dt},
      written_(first),
      saved_(first) {
  crossings_.values();  // what crosses from the beginning is said at once
}

bool Recorder::after_step(const fsi::StepClock& clock, const fsi::StepReport& report) {
  const Comm& comm = setup_.fiber_mesh->comm;
  const Output& parameters = setup_.parameters.output;
  const double cfl = setup_.fluid != nullptr ? setup_.fluid->cfl() : 0.0;
  const double violation = setup_.system->constraint_violation();
  std::vector<double> values = probes_.values(*setup_.system);
  const std::vector<double> flow = bulk_flow_values(*setup_.system);
  values.insert(values.end(), flow.begin(), flow.end());
  const std::vector<double> energies = energy_values(*setup_.system);
  values.insert(values.end(), energies.begin(), energies.end());
  if (!is_finite(cfl, violation, values)) {
    sound_ = false;
    throw Error(ExitCode::diverged, "a velocity, force or probe is not finite; try a smaller time.step");
  }
  const std::vector<double> crossing = crossings_.values();
  values.insert(values.end(), crossing.begin(), crossing.end());
  clock_ = clock;
  if (setup_.averages != nullptr) setup_.averages->add(clock, setup_.fluid->accepted());
  const double seconds = comm.max(progress_.step_done(clock.step));
  std::vector<double> row = {static_cast<double>(clock.step),
                             clock.time,
                             clock.dt,
                             static_cast<double>(report.newton),
                             static_cast<double>(report.krylov),
                             static_cast<double>(report.coupling_iterations),
                             static_cast<double>(report.evaluations),
                             report.residual,
                             cfl,
                             violation,
                             seconds};
  if (setup_.acceleration != nullptr)
    row.insert(row.end(), {report.relaxation, static_cast<double>(report.interface_krylov)});
  row.insert(row.end(), values.begin(), values.end());
  history_.write(row);
  expectations_.add_row(clock.time, row);
  newton_.add(report.newton);
  krylov_.add(report.krylov);
  coupling_.add(report.coupling_iterations);
  repeated_ += report.failures;
  if (report.parts > 1) {
    ++divided_;
    smallest_dt_ = smallest_dt_ > 0.0 ? std::min(smallest_dt_, clock.dt) : clock.dt;
  }
  print_line(clock, report, cfl, violation, seconds);
  const double tolerance = setup_.parameters.time.steady_tolerance;
  const double rate = tolerance > 0.0 ? setup_.fluid->relative_rate() : 0.0;
  settled_ = tolerance > 0.0 && rate < tolerance;
  const bool end = settled_ || clock.step == last_;
  if (end || (parameters.every > 0 && clock.step % parameters.every == 0)) output(clock);

  const int signal = static_cast<int>(comm.max(static_cast<GlobalIndex>(caught_signal())));
  const double elapsed = comm.max(progress_.seconds_total());
  const bool late = options_.max_walltime > 0.0 && elapsed > 60.0 * options_.max_walltime;
  const bool by_clock =
      parameters.checkpoint_minutes > 0.0 && elapsed - saved_at_ > 60.0 * parameters.checkpoint_minutes;
  if (end || signal != 0 || late || by_clock || (parameters.checkpoint > 0 && clock.step % parameters.checkpoint == 0))
    save(clock);
  if (settled_)
    log::info("steady after step %lld: the velocity changes by %.3g of itself a unit of time",
              static_cast<long long>(clock.step), rate);
  if (end) return settled_;
  if (signal != 0)
    log::warning("stopped by %s after step %lld", signal_name(signal), static_cast<long long>(clock.step));
  else if (late)
    log::warning("stopped after step %lld: the wall-time limit of %g min is reached",
                 static_cast<long long>(clock.step), options_.max_walltime);
  return signal != 0 || late;
}

std::string Recorder::keep_last_state(const std::string& failure) {
  history_.write_failure(failure);
  history_.write_work(counted_work(setup_.fiber_mesh->comm));
  const std::string restart = "fbi-run " + options_.case_path + " --restart last";
  if (clock_.step == first_)
    return first_ > 0
               ? log::format("the checkpoint of step %lld is kept: %s", static_cast<long long>(first_), restart.c_str())
               : "no step was finished";
  if (!sound_)
    return saved_ > 0 ? log::format("%s goes on from step %lld", restart.c_str(), static_cast<long long>(saved_))
                      : "there is no checkpoint";
  output(clock_);
  save(clock_);
  return log::format("the state after step %lld is saved; %s goes on from it", static_cast<long long>(clock_.step),
                     restart.c_str());
}

void Recorder::output(const fsi::StepClock& clock) {
  if (written_ == clock.step) return;
  write_fields(setup_, writer_, clock.step, clock.time);
  written_ = clock.step;
}

void Recorder::save(const fsi::StepClock& clock) {
  if (saved_ == clock.step) return;
  save_checkpoint(setup_, paths_, json_, clock.step, clock.time);
  saved_ = clock.step;
  saved_at_ = setup_.fiber_mesh->comm.max(progress_.seconds_total());
}

std::string Recorder::iterations_text() const {
  const GlobalIndex steps = clock_.step - first_;
  if (steps <= 0) return "";
  std::string mean, most;
  const auto add = [&](bool wanted, const char* name, const Count& count) {
    if (!wanted) return;
    mean += log::format("%s%.1f %s", mean.empty() ? "" : ", ",
                        static_cast<double>(count.sum) / static_cast<double>(steps), name);
    most += log::format("%s%d", most.empty() ? "" : ", ", count.most);
  };
  add(setup_.acceleration != nullptr, "coupling", coupling_);
  add(true, "Newton", newton_);
  add(setup_.fluid != nullptr, "Krylov", krylov_);
  std::string text = log::format("%lld step%s, iterations a step: %s (most: %s)", static_cast<long long>(steps),
                                 steps > 1 ? "s" : "", mean.c_str(), most.c_str());
  if (repeated_ + divided_ > 0)
    text += log::format(
        "\n%ld attempt%s did not converge and %s repeated with a smaller dt; %ld step%s done in parts, "
        "the smallest of %.6g",
        repeated_, repeated_ == 1 ? "" : "s", repeated_ == 1 ? "was" : "were", divided_,
        divided_ == 1 ? " was" : "s were", divided_ > 0 ? smallest_dt_ : setup_.dt);
  return text;
}

// One line a step, in columns; those that mean nothing for this case are left out.
void Recorder::print_line(const fsi::StepClock& clock, const fsi::StepReport& report, double cfl, double violation,
                          double seconds) {
  if (options_.quiet) return;
  const bool fluid = setup_.fluid != nullptr, coupled = setup_.system->is_coupled();
  std::string header = "      %      step            t", line;
  line = log::format("%7.1f %9lld %12.6g", progress_.percent(), static_cast<long long>(clock.step), clock.time);
  const auto add = [&](bool wanted, int width, const char* name, const std::string& value) {
    if (!wanted) return;
    header += log::format(" %*s", width, name);
    line += log::format(" %*s", width, value.c_str());
  };
  add(setup_.acceleration != nullptr, 8, "coupling", std::to_string(report.coupling_iterations));
  add(true, 6, "newton", std::to_string(report.newton));
  add(fluid, 6, "krylov", std::to_string(report.krylov));
  add(fluid, 8, "residual", log::format("%.1e", report.residual));
  add(fluid, 8, "CFL", log::format("%.2g", cfl));
  add(coupled, 8, "slip", log::format("%.1e", violation));
  add(true, 8, "s/step", log::format("%.3f", seconds));
  add(true, 10, "ETA", duration_text(progress_.seconds_left()));
  if (lines_++ % lines_between_headers == 0) log::info("%s", header.c_str());
  log::info("%s", line.c_str());
}

}  // namespace fbi::cases
