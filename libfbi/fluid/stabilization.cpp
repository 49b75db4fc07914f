#include "fluid/stabilization.hpp"

#include <algorithm>
#include <cmath>

#include "fem/hex8.hpp"

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

double streamline_length(const double* k, const double* e, const double* xi) {
  const Eigen::Matrix<double, 8, 3> slope = fem::hex8_gradient(Vec3(xi[0], xi[1], xi[2]));
  double along[3];  // dxi_d along e
  for (int d = 0; d < 3; ++d) along[d] = k[3 * d] * e[0] + k[3 * d + 1] * e[1] + k[3 * d + 2] * e[2];
  double sum = 0;
  for (int a = 0; a < 8; ++a) sum += std::abs(slope(a, 0) * along[0] + slope(a, 1) * along[1] + slope(a, 2) * along[2]);
  return 2 / sum;
}

Metric cell_metric(const double* k, const double* v) {
  Metric metric{0, 0, 0};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const double g = k[i] * k[j] + k[3 + i] * k[3 + j] + k[6 + i] * k[6 + j];
      metric.advection += v[i] * g * v[j];
      metric.square += g * g;
      if (i == j) metric.trace += g;
    }
  return metric;
}

namespace {

double tau_of_metric(double density, double viscosity, double rate, const Metric& metric) {
  return 1 /
         std::sqrt(density * density * (rate * rate + metric.advection) + 36 * viscosity * viscosity * metric.square);
}

}  // namespace

CellTau whiting_jansen(double density, double viscosity, double rate, const Metric& metric) {
  const double tau = tau_of_metric(density, viscosity, rate, metric);
  return {tau, tau, 1 / (tau * metric.trace)};
}

CellTau taylor_hughes_zarins(double density, double viscosity, double rate, const Metric& metric) {
  const double tau = tau_of_metric(density, viscosity, rate, metric);
  return {tau, tau, density * std::sqrt(metric.advection) / metric.trace};
}

double projection_coefficient(double density, double viscosity, double speed, double cell_length) {
  return 1 / std::max(viscosity, density * speed * cell_length / 6);
}

}  // namespace fbi::fluid
