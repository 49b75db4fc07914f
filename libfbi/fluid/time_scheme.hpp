/// Time integration: the rate of the velocity as a combination of what is known of it.
#pragma once

namespace fbi::fluid {

/// v'_{n+1} = sigma (v_{n+1} - v_n) + before (v_{n-1} - v_n) + rate v'_n; all zero: steady.
struct RateFormula {
  double sigma = 0.0;   ///< [1/time]
  double before = 0.0;  ///< [1/time]
  double rate = 0.0;
};

/// v' = (v_{n+1} - v_n)/(theta dt) - (1/theta - 1) v'_n.
inline RateFormula one_step_theta(double theta, double dt) { return {1 / (theta * dt), 0.0, 1 - 1 / theta}; }

/// v' = (3 v_{n+1} - 4 v_n + v_{n-1})/(2 dt) (Curtiss, Hirschfelder 1952), for steps of different size the derivative
/// at t_{n+1} of the parabola through the three: with r = dt/dt_before the factor of v_{n+1} - v_n is (1 + 2 r)/((1 +
/// r) dt) and that of v_{n-1} - v_n is r^2/((1 + r) dt). Stable for r < 1 + sqrt(2).
inline RateFormula bdf2(double dt, double dt_before) {
  const double r = dt / dt_before;
  return {(1 + 2 * r) / ((1 + r) * dt), r * r / ((1 + r) * dt), 0.0};
}

}  // namespace fbi::fluid
