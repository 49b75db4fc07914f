/// Aitken's dynamic relaxation of the interaction force.
#pragma once

#include <vector>

#include "fsi/acceleration.hpp"

namespace fbi::fsi {

/// x_{k+1} = x_k + omega_k r_k with omega_k = -omega_{k-1} r_{k-1}.(r_k - r_{k-1}) / |r_k - r_{k-1}|^2 (Irons and Tuck
/// 1969). The first factor of a step is the last one of the step before, limited to the initial relaxation in size.
class Aitken : public Acceleration {
 public:
  Aitken(const Comm& comm, double initial) : comm_(comm), initial_(initial), omega_(initial) {}

  void begin_step() override { previous_.clear(); }
  bool advance(std::vector<double>& x, const std::vector<double>& r, const NearbyMap& nearby) override;
  double relaxation() const override { return omega_; }
  std::vector<double> history() const override { return {omega_}; }
  void set_history(const std::vector<double>& values) override { omega_ = values.at(0); }

 private:
  Comm comm_;
  double initial_;
  double omega_;
  std::vector<double> previous_;
};

}  // namespace fbi::fsi
