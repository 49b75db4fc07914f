#include "case/averages.hpp"

#include "base/timer.hpp"

namespace fbi::cases {
namespace {

constexpr const char *weight_name = "averages_weight", *pending_name = "averages_pending";
constexpr double slack = 1e-6;  // of a step: times are multiples of it up to round-off

}  // namespace

FlowAverages::FlowAverages(const Averages& parameters, const mesh::HexMesh& mesh)
    : parameters_(parameters), mean_(mesh.owned_nodes + mesh.written_images) {}

void FlowAverages::add(const fsi::StepClock& clock, Vec accepted) {
  if (clock.time - clock.dt < parameters_.from - slack * clock.dt) return;
  pending_ += clock.dt;
  if (clock.step % parameters_.every != 0) return;
  Timed timed("averages");
  Vec form = nullptr;  // with ghosts: images of periodic faces are among them
  const double* values = nullptr;
  FBI_PETSC(VecGhostGetLocalForm(accepted, &form));
  FBI_PETSC(VecGetArrayRead(form, &values));
  mean_.add(values, pending_);
  FBI_PETSC(VecRestoreArrayRead(form, &values));
  FBI_PETSC(VecGhostRestoreLocalForm(accepted, &form));
  pending_ = 0.0;
}

std::vector<io::NodeField> FlowAverages::fields() const {
  if (mean_.weight == 0.0) return {};
  const int stride = RunningMean::components;
  const double *data = mean_.values.data(), duration = mean_.weight;
  return {{"mean_velocity", 3, stride, RunningMean::velocity, data, duration},
          {"mean_pressure", 1, stride, RunningMean::pressure, data, duration},
          {"reynolds_stress", 6, stride, RunningMean::stress, data, duration}};
}

void FlowAverages::save(std::map<std::string, double>& numbers) const {
  numbers[weight_name] = mean_.weight;
  numbers[pending_name] = pending_;
}

bool FlowAverages::restore(const std::map<std::string, double>& numbers) {
  const auto weight = numbers.find(weight_name), pending = numbers.find(pending_name);
  if (weight == numbers.end() || pending == numbers.end()) return false;
  mean_.weight = weight->second;
  pending_ = pending->second;
  return true;
}

}  // namespace fbi::cases
