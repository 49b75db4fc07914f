#include "case/force_outputs.hpp"

namespace fbi::cases {

ForceOutputs::ForceOutputs(const std::vector<ForceOutput>& outputs, const fluid::FluidField* fluid)
    : outputs_(outputs) {
  if (outputs_.empty() || fluid == nullptr) return;
  std::vector<fluid::ForceSet> sets;
  const auto add = [&](const std::string& name, const char* unit) {
    for (const char* component : {"_x", "_y", "_z"}) {
      columns_.push_back(name + component);
      units_.emplace_back(unit);
    }
  };
  for (const ForceOutput& output : outputs_) {
    sets.push_back({output.faces, output.about.value_or(Vec3::Zero())});
    add(output.name + ":force", "force");
    if (output.about) add(output.name + ":moment", "force length");
    if (output.speed > 0.0) add(output.name + ":coefficient", "1");
  }
  forces_ = std::make_unique<fluid::BoundaryForces>(*fluid, sets);
}

std::vector<double> ForceOutputs::values(const fsi::System& system) const {
  std::vector<double> values;
  if (forces_ == nullptr) return values;
  fluid::FluidField& fluid = system.fluid();
  const linalg::VecHandle balance = fluid.create_vector();
  fluid.internal_forces(balance);
  if (system.fluid_feels_fibers()) system.solver().add_spread(system.lambda_old(), balance, true);
  const std::vector<fluid::BoundaryForce> forces = forces_->evaluate(fluid.iterate(), balance);
  for (std::size_t k = 0; k < outputs_.size(); ++k) {
    const auto add = [&](const Vec3& v) { values.insert(values.end(), v.data(), v.data() + 3); };
    add(forces[k].force);
    if (outputs_[k].about) add(forces[k].moment);
    const double scale = 0.5 * fluid.parameters().density * outputs_[k].speed * outputs_[k].speed * outputs_[k].area;
    if (scale > 0.0) add(forces[k].force / scale);
  }
  return values;
}

}  // namespace fbi::cases
