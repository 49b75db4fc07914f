/// Parameters of the coupling between fluid and fibers. Free of PETSc and MPI.
#pragma once

#include <string>
#include <vector>

#include "base/types.hpp"

namespace fbi::coupling {

/// Basis of the Lagrange multipliers along a fiber.
enum class Multiplier {
  linear,
  quadratic,
  cubic,
  gauss_point  ///< one multiplier for each integration point
};
/// Where the velocity of the fluid is taken and the force put.
enum class Operator {
  centerline,  ///< the trace on the center line
  ring         ///< the mean over a circle around it, normal to it
};
enum class Integration {
  segments,  ///< Gauss rule on every piece of an element within one cell: exact up to the order of the rule
  element    ///< Gauss rule on the whole element, whatever the cells
};
enum class Outside {
  error,  ///< more than 1 % of a fiber's length outside the fluid ends the run
  allow
};

struct CouplingParameters {
  Multiplier multiplier = Multiplier::linear;
  Operator kernel = Operator::centerline;
  double penalty = 100.0;  ///< epsilon [force/(length velocity)] per length
  bool automatic = false;  ///< instead of a number: the tensor that keeps the fiber's own radius
  Index gauss_points = 6;  ///< per segment, or per element
  Integration integration = Integration::segments;
  Outside outside = Outside::error;
  // From the set-up, not from the input.
  std::vector<double> radius{};  ///< a of every fiber set, sqrt(A/pi), 0 where no section is given [length]
  double viscosity = 0.0;        ///< mu of the fluid [mass/(length time)]
  std::vector<Vec3> periods{};   ///< translations by which the flow repeats [length]
};

}  // namespace fbi::coupling
