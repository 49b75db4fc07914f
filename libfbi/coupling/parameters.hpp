/// Parameters of the coupling between fluid and fibers. Free of PETSc and MPI.
#pragma once

#include <string>

#include "base/types.hpp"

namespace fbi::coupling {

enum class Multiplier { linear };
enum class Outside {
  error,  ///< more than 1 % of a fiber's length outside the fluid ends the run
  allow
};

struct CouplingParameters {
  Multiplier multiplier = Multiplier::linear;
  double penalty = 100.0;      ///< epsilon [force/(length velocity)] per length
  Index gauss_points = 6;      ///< per segment
  Outside outside = Outside::error;
};

}  // namespace fbi::coupling
