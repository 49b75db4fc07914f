/// What is known to make a case unstable, said before it runs. The numbers are those of docs/stability.md.
#pragma once

#include <string>
#include <vector>

#include "case/scene.hpp"

namespace fbi::cases {

/// Dimensionless numbers that decide; 0 where they mean nothing for a case.
struct StabilityNumbers {
  double motion = 0.0;  ///< U dt/L: way of the fluid in a step over the length of the longest fiber, where fibers bend
  double cauchy = 0.0;  ///< rho U^2 d L^3/(2 EI) of the most flexible fiber
  Index elements = 0;   ///< of a fiber that moves, fewest
  double alternation = 0.0;  ///< factor of an alternating coupling force from step to step, -1 .. 1
  double iteration = 0.0;    ///< Dirichlet-Neumann: factor of the error in an iteration without relaxation
  double change = 0.0;       ///< largest change of the prescribed velocity in a step, over the largest speed
  double cfl = 0.0;          ///< U dt/h
  bool sudden = false;       ///< the boundary moves at t = 0 and the initial velocity does not know of it
};

/// Factor by which an alternating coupling force changes in a step. From rho A dv_b/dt = lambda, m dv_f/dt = -lambda
/// and lambda = eps (v_f - v_b), lambda weighted by w in the fiber and by theta in the fluid: (1/eps - (1-theta) dt/m -
/// (1-w) dt/(rho A))/(1/eps + theta dt/m + w dt/(rho A)); for theta = 1, w = 1/2 and eps -> infinity that is -1/(1 + 2
/// rho A/m). `penalty` eps [force time/length^2], `fluid` m, added mass of the mesh, `fiber` rho A [mass/length],
/// `step` dt [time], `weight` w, `theta`.
double alternation_factor(double penalty, double fluid, double fiber, double step, double weight, double theta);

/// Factor of the error of the interaction force in an iteration without relaxation, velocity to the fluid and force to
/// the fibers: w dt/(rho A) / (1/eps + theta dt/m). Arguments as above.
double iteration_factor(double penalty, double fluid, double fiber, double step, double weight, double theta);

/// The numbers of a case. Collective.
StabilityNumbers stability_numbers(const Setup& setup, const Scene& scene);

/// One text for each reason why a case with these numbers lies outside what was stable in the maps, with the remedy.
std::vector<std::string> stability_warnings(const StabilityNumbers& numbers, const CaseParameters& parameters);

}  // namespace fbi::cases
