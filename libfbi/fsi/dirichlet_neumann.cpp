#include "fsi/dirichlet_neumann.hpp"

#include <algorithm>
#include <cmath>

#include "base/timer.hpp"
#include "fsi/monolithic.hpp"

namespace fbi::fsi {

StepReport solve_dirichlet_neumann(System& system, Acceleration& acceleration, double time, double dt) {
  StepReport report;
  const SchemeParameters& scheme = system.scheme();
  const Comm& comm = system.comm();
  beam::BeamField& beams = system.beams();
  coupling::Coupling& coupling = system.coupling();
  coupling::InterfaceOperator& interface = system.interface();

  bool geometry_changed = system.update_geometry(beams.accepted_dofs());
  interface.reset(coupling);
  acceleration.begin_step();
  // Force predicted linearly in time.
  std::vector<double> x(system.force_old().size()), force(x.size()), r(x.size()), h(x.size()), lambda, g;
  for (std::size_t k = 0; k < x.size(); ++k) x[k] = 2.0 * system.force_old()[k] - system.force_older()[k];
  const double w = system.weight();
  const double size = static_cast<double>(comm.sum(static_cast<GlobalIndex>(x.size())));
  double fluid_reference = 0.0;
  bool first = true;

  for (int iteration = 0; iteration < scheme.max_iterations; ++iteration) {
    ++report.coupling_iterations;
    ++report.evaluations;
    {
      Timed timed("fiber solve");
      beams.begin_step(time, dt);
      for (std::size_t k = 0; k < x.size(); ++k) force[k] = w * x[k] + (1.0 - w) * system.force_old()[k];
      if (beams.solve_step(force) < 0) break;
    }
    if (scheme.geometry_update == GeometryUpdate::iterated && system.update_geometry(beams.dofs())) {
      geometry_changed = true;
      interface.reset(coupling);
    }
    g.resize(3 * static_cast<std::size_t>(coupling.rows()));
    coupling.apply_d(beams.velocity(), g.data());
    const bool solved = solve_fluid(system, &g, lambda, report, geometry_changed || first, fluid_reference);
    geometry_changed = first = false;
    if (!solved) break;
    std::fill(h.begin(), h.end(), 0.0);
    coupling.add_d_transposed(lambda.data(), h, 1.0);
    double sums[2] = {0.0, 0.0};
    for (std::size_t k = 0; k < x.size(); ++k) {
      r[k] = h[k] - x[k];
      sums[0] += r[k] * r[k];
      sums[1] += h[k] * h[k];
    }
    comm.sum(sums, 2);
    const double change = std::sqrt(sums[0]), magnitude = std::sqrt(sums[1]);
    report.residual = magnitude > 0.0 ? change / magnitude : change;
    report.history.push_back({fluid_reference, report.residual, 0.0});
    if (!std::isfinite(change)) break;
    if (change <= scheme.tolerance * magnitude || change <= scheme.absolute_tolerance * std::sqrt(size)) {
      report.converged = true;
      break;
    }
    acceleration.advance(x, r);
    report.relaxation = acceleration.relaxation();
  }
  system.lambda() = lambda;
  return report;
}

}  // namespace fbi::fsi
