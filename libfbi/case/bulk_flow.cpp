#include "case/bulk_flow.hpp"

#include "base/timer.hpp"

namespace fbi::cases {

std::vector<io::HistoryColumn> bulk_flow_columns(const fsi::System& system) {
  std::vector<io::HistoryColumn> columns;
  if (!system.has_fluid()) return columns;
  for (const char* name : {"mean:velocity_x", "mean:velocity_y", "mean:velocity_z"})
    columns.push_back({name, "length/time"});
  return columns;
}

std::vector<double> bulk_flow_values(const fsi::System& system) {
  if (!system.has_fluid()) return {};
  Timed timed("mean velocity");
  fluid::FluidField& fluid = system.fluid();
  const std::vector<double>& lumped = fluid.lumped_volume();
  double volume = 0.0;
  for (Index n = 0; n < fluid.mesh().owned_nodes; ++n) volume += lumped[n];
  volume = system.comm().sum(volume);
  const Vec3 mean = fluid.momentum(fluid.accepted()) / (fluid.parameters().density * volume);
  return {mean[0], mean[1], mean[2]};
}

}  // namespace fbi::cases
