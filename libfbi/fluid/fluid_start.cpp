/// The state of a FluidField at t = 0.
#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/log.hpp"
#include "base/timer.hpp"
#include "fluid/divergence_free.hpp"
#include "fluid/fluid_field_parts.hpp"

namespace fbi::fluid {

namespace {

constexpr int startup_steps = 2;  // with theta = 1: v' after them obeys the equations and the constraint of t_2
constexpr double divergence_limit = 0.1;
constexpr double open_face_weight = 3.0;  // Robin coefficient of the projection's preconditioner, times 1/h

}  // namespace

void FluidField::Implementation::evaluate_initial_velocity() {
  std::string error;
  LocalArray u(accepted);
  for (Index n = 0; n < mesh.local_nodes(); ++n) {
    const double* x = mesh.node(n);
    for (int i = 0; i < 3; ++i) {
      const double v = parameters.initial_velocity[i](x[0], x[1], x[2], 0.0);
      if (!std::isfinite(v))
        error = log::format("the initial velocity is not finite at (%g, %g, %g)", x[0], x[1], x[2]);
      u[4 * static_cast<std::size_t>(n) + i] = v;
    }
  }
  agree_on_error(mesh.comm, ExitCode::usage, error);
}

void FluidField::make_divergence_free() {
  const Timed timed("projection of the initial velocity");
  Implementation& f = *implementation_;
  {
    LocalArray u(f.accepted);
    f.boundaries.apply(u.data());
  }
  const std::vector<double> one(f.mesh.local_cells(), 1.0);
  const Projection result =
      remove_divergence(f.mesh, f.cells, f.boundaries.is_dirichlet(), f.lumped_volume,
                        pressure_laplacian(one, open_face_weight), f.pressure_is_free, f.accepted);
  log::info("initial velocity projected: |div v| falls from %.2e to %.2e, %d iterations", result.before, result.after,
            result.iterations);
}

// Says when the data at t = 0 do not fit together: an impulsive start. Returns whether they do.
bool FluidField::Implementation::report_start() {
  const double speed = largest_speed(accepted);
  double mismatch = 0, total = 0;
  {
    LocalArray u(accepted), s(sum);
    mismatch = mesh.comm.max(boundaries.largest_mismatch(u.data()));
    std::fill_n(s.data(), unknowns(), 0.0);
    total = mesh.comm.sum(cells.add_divergence(u.data(), s.data()));
  }
  add_ghosts(sum);
  double divergence = 0;  // int of the squared lumped projection of div v
  {
    LocalArray s(sum);
    for (std::size_t n = 0; n < static_cast<std::size_t>(mesh.owned_nodes); ++n)
      divergence += s[4 * n + 3] * s[4 * n + 3] / lumped_volume[n];
  }
  divergence = mesh.comm.sum(divergence);
  const char* consequence = steady() ? "" : "; v' = 0 at t = 0 and the first two steps use theta = 1";
  const bool jump = mismatch > 1e-8 * std::max(speed, mismatch);
  const bool diverges = !jump && std::sqrt(divergence) > divergence_limit * std::sqrt(total);
  if (jump)
    log::info("impulsive start: boundary velocities at t = 0 differ from the initial field by up to %g%s", mismatch,
              consequence);
  else if (diverges)
    log::warning(
        "the initial velocity is not divergence-free (|div v| / |grad v| = %.2g in the mean)%s; "
        "\"project_initial_velocity\": true in \"fluid\" makes it so",
        std::sqrt(divergence / total), consequence);
  return !jump && !diverges;
}

void FluidField::initialize() {
  Implementation& f = *implementation_;
  f.evaluate_initial_velocity();
  update_ghosts(f.accepted);  // images of periodic faces
  f.boundaries.set_time(0.0);
  if (f.parameters.project_initial_velocity) make_divergence_free();
  const bool fits = f.steady() || f.report_start();
  bool at_rest;
  {
    LocalArray u(f.accepted), v(f.iterate), w(f.previous);
    f.boundaries.apply(u.data());
    std::copy_n(u.data(), f.unknowns(), v.data());
    std::copy_n(u.data(), f.unknowns(), w.data());
    at_rest = std::all_of(u.data(), u.data() + f.unknowns(), [](double x) { return x == 0; });
  }
  f.evaluate_body_force(0.0);
  const bool forced =
      f.boundaries.has_load() || std::any_of(f.body_force.begin(), f.body_force.end(), [](double b) { return b != 0; });
  // v' = 0 is exact when nothing moves and nothing pushes; otherwise two steps with theta = 1 give a v' that obeys the
  // semi-discrete equations and the constraint, at a local error of second order. With theta = 1 v' is not used at all.
  const bool exact = !f.mesh.comm.any(!at_rest || forced) && !f.boundaries.has_timed_velocity();
  if (f.time_parameters.scheme == TimeScheme::bdf2)
    f.startup_left = fits ? 1 : startup_steps;  // v_{n-1} is needed, and none that the equations did not shape
  else
    f.startup_left = exact || f.steady() || f.time_parameters.theta == 1.0 ? 0 : startup_steps;
  f.accepted_steps = 0;
  f.impulsive = fits ? 0 : 1;
}

}  // namespace fbi::fluid
