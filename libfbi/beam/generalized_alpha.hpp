/// Generalised-alpha time integration (Chung-Hulbert 1993) of second-order equations.
#pragma once

namespace fbi::beam {

/// Coefficients from the spectral radius at infinite frequency, and the updates of velocity and acceleration.
///
/// Equilibrium is asked for as M a_{n+1-alpha_m} + (1-alpha_f) F(d_{n+1}) + alpha_f F(d_n) = 0 (forces averaged, SPEC
/// section 2) with a_{n+1-alpha_m} = (1-alpha_m) a_{n+1} + alpha_m a_n.
struct GeneralizedAlpha {
  double alpha_m = 0.5, alpha_f = 0.5, beta = 0.25, gamma = 0.5;

  /// alpha_m = (2r-1)/(r+1), alpha_f = r/(r+1), beta = (1-alpha_m+alpha_f)^2/4, gamma = 1/2-alpha_m+alpha_f, r =
  /// `rho_inf`.
  explicit GeneralizedAlpha(double rho_inf);

  /// v_{n+1}, Hagemeyer, Mayr, Popp 2024, eq. (7a); `change` = d_{n+1} - d_n.
  double velocity(double change, double v, double a, double dt) const {
    return gamma / (beta * dt) * change - (gamma - beta) / beta * v - (gamma - 2 * beta) / (2 * beta) * dt * a;
  }
  /// a_{n+1}, eq. (7b).
  double acceleration(double change, double v, double a, double dt) const {
    return change / (beta * dt * dt) - v / (beta * dt) - (1 - 2 * beta) / (2 * beta) * a;
  }
  /// d v_{n+1}/d d_{n+1} = gamma/(beta dt) [1/time].
  double velocity_per_displacement(double dt) const { return gamma / (beta * dt); }
  /// d a_{n+1-alpha_m}/d d_{n+1} = (1-alpha_m)/(beta dt^2) [1/time^2].
  double inertia_per_displacement(double dt) const { return (1 - alpha_m) / (beta * dt * dt); }
};

}  // namespace fbi::beam
