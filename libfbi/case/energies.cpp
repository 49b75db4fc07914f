#include "case/energies.hpp"

#include "base/timer.hpp"

namespace fbi::cases {

std::vector<io::HistoryColumn> energy_columns(const fsi::System& system) {
  std::vector<io::HistoryColumn> columns;
  if (system.has_fluid()) columns.push_back({"energy:fluid_kinetic", "force length"});
  if (system.has_fibers()) {
    columns.push_back({"energy:fiber_kinetic", "force length"});
    columns.push_back({"energy:fiber_elastic", "force length"});
  }
  if (system.is_coupled()) {
    columns.push_back({"power:fiber", "force length/time"});
    columns.push_back({"power:penalty", "force length/time"});
  }
  return columns;
}

std::vector<double> energy_values(const fsi::System& system) {
  Timed timed("energies");
  std::vector<double> values;
  if (system.has_fluid()) values.push_back(system.fluid().kinetic_energy());
  double mine[4] = {0.0, 0.0, 0.0, 0.0};
  if (system.has_fibers()) {
    const beam::Energy energy = system.beams().energy();
    mine[0] = energy.kinetic;
    mine[1] = energy.internal;
  }
  if (system.is_coupled()) {
    const std::vector<double>&force = system.force_old(), &velocity = system.beams().accepted_velocity();
    for (std::size_t k = 0; k < force.size(); ++k) mine[2] += force[k] * velocity[k];
    const std::vector<double>& lambda = system.lambda();
    const std::vector<double> slip = system.slip();
    for (std::size_t k = 0; k < slip.size(); ++k) mine[3] += lambda[k] * slip[k];
  }
  if (!system.has_fibers()) return values;
  system.comm().sum(mine, 4);
  values.insert(values.end(), mine, mine + (system.is_coupled() ? 4 : 2));
  return values;
}

}  // namespace fbi::cases
