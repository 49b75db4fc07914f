#include "fluid/stabilization.hpp"

#include <algorithm>
#include <cmath>

namespace fbi::fluid {

CellTau franca_valentin(double density, double viscosity, double sigma, double speed, double streamline_length,
                        double cell_length) {
  constexpr double m = 1.0 / 3.0;
  const double diffusive = 4 * viscosity / m;
  const auto reynolds = [&](double h) { return m * density * speed * h / (2 * viscosity); };
  const auto tau_m = [&](double h) {
    // h^2 rho sigma max(Re1, 1) = max(4 mu/m, h^2 rho sigma): no division by sigma
    const double time = sigma > 0 ? std::max(diffusive, h * h * density * sigma) : 0.0;
    return h * h / (time + diffusive * std::max(reynolds(h), 1.0));
  };
  CellTau tau;
  tau.convection = tau_m(streamline_length);
  tau.pressure = tau_m(cell_length);
  tau.divergence = 0.5 * density * speed * cell_length * std::min(reynolds(cell_length), 1.0);
  return tau;
}

double streamline_length(const double* k, const double* e) {
  // grad N_a = (1/8) sum_d s_ad K_d at the center: the sum over the eight sign patterns, which come in pairs
  double x[3];
  for (int d = 0; d < 3; ++d) x[d] = k[3 * d] * e[0] + k[3 * d + 1] * e[1] + k[3 * d + 2] * e[2];
  const double sum = 0.25 * (std::abs(x[0] + x[1] + x[2]) + std::abs(x[0] + x[1] - x[2]) +
                             std::abs(x[0] - x[1] + x[2]) + std::abs(x[0] - x[1] - x[2]));
  return 2 / sum;
}

}  // namespace fbi::fluid
