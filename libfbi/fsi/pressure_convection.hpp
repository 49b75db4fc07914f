/// Convection of a pressure by the flow, for the preconditioner.
#pragma once

#include <vector>

#include "fluid/fluid_field.hpp"

namespace fbi::fsi {

/// C with C_ab = rho sum_K int_K N_a v . grad N_b by one point in the middle of each cell, at the present iterate.
class PressureConvection {
 public:
  explicit PressureConvection(fluid::FluidField& fluid);

  /// Takes the velocity of the iterate.
  void renew();
  /// y += C q: the fourth entries of arrays of local nodes, shape=(nodes,4). q has its ghosts [pressure], y
  /// [density volume pressure/time] lacks what other ranks add to its owned nodes.
  void add(const float* q, float* y) const;

 private:
  fluid::FluidField& fluid_;
  std::vector<float> flow_;  // rho V/64 times v in reference coordinates, shape=(local cells,3)
};

}  // namespace fbi::fsi
