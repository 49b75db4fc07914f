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

/// 2/sum_a |e . grad N_a| at the center of a hexahedron, from K_d = dxi_d/dx (shape=(3,3), row d) and the unit vector
/// e.
double streamline_length(const double* inverse_jacobian, const double* direction);

}  // namespace fbi::fluid
