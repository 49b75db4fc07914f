#include "fsi/one_way.hpp"

#include <cmath>

#include "base/timer.hpp"
#include "fsi/condensation.hpp"
#include "fsi/fiber_solve.hpp"
#include "fsi/monolithic.hpp"

namespace fbi::fsi {

StepReport solve_fiber_only(System& system) {
  StepReport report = solve_monolithic(system);
  if (!report.converged) return report;
  report.converged = false;
  const SolverParameters& parameters = system.solver_parameters();
  const bool moving = system.fibers_follow();
  const bool iterated = moving && system.scheme().geometry_update == GeometryUpdate::iterated;
  beam::BeamField& beams = system.beams();
  std::vector<double>& lambda = system.lambda();
  std::vector<double> undisturbed, g, force, last;
  system.update_geometry(system.first_positions());
  report.coupling_iterations = 0;
  do {
    ++report.coupling_iterations;
    if (iterated) system.update_geometry(beams.dofs());
    system.interface().reset(system.coupling());
    system.interpolate(system.fluid().iterate(), undisturbed);
    if (moving && !solve_fibers(system, spring_force(system, undisturbed))) return report;
    g.resize(undisturbed.size());
    system.coupling().apply_d(beams.velocity(), g.data());
    multipliers(system, g, lambda);
    force.assign(system.force_old().size(), 0.0);
    system.coupling().add_d_transposed(lambda.data(), force, 1.0);
    last.resize(force.size(), 0.0);  // the first time: no force
    for (std::size_t k = 0; k < force.size(); ++k) last[k] -= force[k];
    const double change = interface_norm(system.comm(), last), size = interface_norm(system.comm(), force);
    if (!std::isfinite(size)) return report;
    report.converged = !iterated || change <= parameters.newton_tolerance * size;
    last = force;
  } while (!report.converged && report.coupling_iterations <= parameters.newton_iterations);
  return report;
}

StepReport solve_fluid_only(System& system) {
  StepReport report;
  {
    Timed timed("fiber solve");
    report.newton = system.beams().solve_step(std::vector<double>(system.force_old().size(), 0.0));
  }
  if (report.newton < 0) {
    report.newton = 0;
    return report;
  }
  return solve_monolithic(system);
}

}  // namespace fbi::fsi
