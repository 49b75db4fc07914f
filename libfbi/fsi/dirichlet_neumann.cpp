#include "fsi/dirichlet_neumann.hpp"

#include <cmath>

#include "fsi/condensation.hpp"
#include "fsi/interface_map.hpp"

namespace fbi::fsi {

StepReport solve_dirichlet_neumann(System& system, Acceleration& acceleration, double time, double dt) {
  StepReport report;
  const SchemeParameters& scheme = system.scheme();
  const Comm& comm = system.comm();
  InterfaceMap map(system, report, time, dt);
  acceleration.begin_step();
  std::vector<double> x = map.predict(), h, r(x.size());
  if (x.size() != system.force_old().size()) return report;
  const double root = std::sqrt(static_cast<double>(comm.sum(static_cast<GlobalIndex>(x.size()))));
  const NearbyMap nearby = [&map](const std::vector<double>& at, std::vector<double>& value) {
    return map.difference(at, value);
  };

  for (int iteration = 0; iteration < scheme.max_iterations; ++iteration) {
    ++report.coupling_iterations;
    if (!map.evaluate(x, h)) break;
    for (std::size_t k = 0; k < x.size(); ++k) r[k] = h[k] - x[k];
    const double change = interface_norm(comm, r), magnitude = map.force_norm();
    report.residual = magnitude > 0.0 ? change / magnitude : change;
    report.history.push_back({map.fluid_reference(), report.residual, 0.0});
    if (!std::isfinite(change)) break;
    if (change <= scheme.tolerance * magnitude || change <= scheme.absolute_tolerance * root) {
      report.converged = true;
      break;
    }
    if (!acceleration.advance(x, r, nearby)) break;
    report.relaxation = acceleration.relaxation();
    report.interface_krylov += acceleration.krylov_iterations();
  }
  return report;
}

}  // namespace fbi::fsi
