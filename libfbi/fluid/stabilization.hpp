/// Stabilisation parameters of a cell.
#pragma once

namespace fbi::fluid {

/// tau_M of SUPG and PSPG [time/density] and tau_C of grad-div [viscosity].
struct CellTau {
  double convection = 0.0;
  double pressure = 0.0;
  double divergence = 0.0;
};

/// Parameters of Franca-Barrenechea-Valentin-Frey-Wall with m_K = 1/3 at the cell center (SPEC section 1):
///   tau_M = h^2 / (h^2 rho sigma max(Re1, 1) + (4 mu/m_K) max(Re2, 1)), Re1 = 4 mu/(m_K rho sigma h^2),
///   Re2 = m_K rho |v| h/(2 mu); tau_C = rho |v| h min(Re2, 1)/2 with the h of PSPG. Without sigma the first term is
///   absent.
/// @param density, viscosity  rho, mu > 0
/// @param sigma             1/(theta dt), or 0 for no time-step term [1/time]
/// @param speed             |v| at the cell center; 0 for Stokes flow [length/time]
/// @param streamline_length h of SUPG, 2/sum_a |e_v . grad N_a| [length]
/// @param cell_length       h of PSPG, V^(1/3) [length]
CellTau franca_valentin(double density, double viscosity, double sigma, double speed, double streamline_length,
                        double cell_length);

/// v.G v, G:G and tr G of the metric G_ij = sum_k dxi_k/dx_i dxi_k/dx_j.
struct Metric {
  double advection;  ///< v.G v [1/time^2]
  double square;     ///< G:G [1/length^4]
  double trace;      ///< tr G [1/length^2]
};

/// @param inverse_jacobian  dxi_d/dx_i with xi in [-1,1], shape=(3,3), row d [1/length]
/// @param velocity          v, shape=(3) [length/time]
Metric cell_metric(const double* inverse_jacobian, const double* velocity);

/// Whiting and Jansen (2001): tau_M = (rho^2 rate^2 + rho^2 v.G v + 36 mu^2 G:G)^(-1/2), tau_C = 1/(tau_M tr G).
/// @param rate  2/dt, or 0 for no time-step term [1/time]
CellTau whiting_jansen(double density, double viscosity, double rate, const Metric& metric);

/// Taylor, Hughes and Zarins (1998): tau_M as whiting_jansen, tau_C = rho sqrt(v.G v)/tr G.
CellTau taylor_hughes_zarins(double density, double viscosity, double rate, const Metric& metric);

/// Coefficient of the pressure projection, 1/(mu max(Re2, 1)) with Re2 = rho |v| h/(6 mu): 1/mu of Dohrmann and Bochev
/// (2004) where diffusion rules a cell; where convection does, 6/(rho |v| h), the limit that Braack, Burman, John and
/// Lube (2007) give for Oseen's equations, so that the leak of mass stays small at high Reynolds numbers. On smooth
/// pressures it acts as PSPG with the steady tau_M of franca_valentin does. Free of the time step.
double projection_coefficient(double density, double viscosity, double speed, double cell_length);

/// 2/sum_a |e . grad N_a| at the center of a hexahedron, from K_d = dxi_d/dx (shape=(3,3), row d) and the unit vector
/// e.
double streamline_length(const double* inverse_jacobian, const double* direction);
/// The same at a point xi of the cell.
double streamline_length(const double* inverse_jacobian, const double* direction, const double* xi);

}  // namespace fbi::fluid
