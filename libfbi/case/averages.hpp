/// Running means of the flow over a run, on request (output.averages).
#pragma once

#include <map>
#include <string>
#include <vector>

#include "base/running_mean.hpp"
#include "case/schema.hpp"
#include "fsi/time_loop.hpp"
#include "io/checkpoint.hpp"
#include "io/result_file.hpp"
#include "linalg/petsc.hpp"
#include "mesh/hex_mesh.hpp"

namespace fbi::cases {

/// Mean velocity, mean pressure and covariance of the velocity at every node, weighted by time.
///
/// A step counts when it begins at `from` or later; one in `every` steps is taken in and stands for the time since the
/// one before. Nothing is communicated: a rank holds its own nodes and the images that it writes.
class FlowAverages {
 public:
  FlowAverages(const Averages& parameters, const mesh::HexMesh& mesh);

  /// Takes in an accepted step.
  /// @param accepted  velocity and pressure with ghosts up to date
  void add(const fsi::StepClock& clock, Vec accepted);

  /// The fields mean_velocity, mean_pressure and reynolds_stress for an output; empty before the first sample.
  std::vector<io::NodeField> fields() const;

  /// What a checkpoint holds: one array and some numbers.
  io::StateArray state() { return {"averages", RunningMean::components, &mean_.values, true}; }
  void save(std::map<std::string, double>& numbers) const;
  /// Restores the numbers; false when there are none, because the run that was saved took no means.
  bool restore(const std::map<std::string, double>& numbers);

  const RunningMean& mean() const { return mean_; }

 private:
  Averages parameters_;
  RunningMean mean_;
  double pending_ = 0.0;  // since the last sample [time]
};

}  // namespace fbi::cases
