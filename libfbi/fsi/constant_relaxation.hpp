/// Relaxation of the interaction force by a constant factor.
#pragma once

#include <vector>

#include "fsi/acceleration.hpp"

namespace fbi::fsi {

/// x_{k+1} = x_k + omega r_k. Converges where every eigenvalue of omega dH/dx + (1 - omega) is below one in size.
class ConstantRelaxation : public Acceleration {
 public:
  explicit ConstantRelaxation(double omega) : omega_(omega) {}

  void begin_step() override {}
  bool advance(std::vector<double>& x, const std::vector<double>& r, const NearbyMap& /*nearby*/) override {
    for (std::size_t k = 0; k < x.size(); ++k) x[k] += omega_ * r[k];
    return true;
  }
  double relaxation() const override { return omega_; }

 private:
  double omega_;
};

}  // namespace fbi::fsi
