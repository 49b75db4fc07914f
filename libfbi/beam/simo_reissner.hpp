/// Geometrically exact beam with shear, torsion and rotary inertia: cubic Hermite center line and three triads an
/// element.
#pragma once

#include <array>

#include "beam/parameters.hpp"
#include "beam/rotation.hpp"

namespace fbi::beam {

/// Unknowns of one element: d_1, t_1, a_1, a_m, d_2, t_2, a_2, each with three components; a_i turns triad i by
/// Lambda_i <- Lambda_i exp(a_i). Triads sit at x = -1, 0, 1.
inline constexpr int triad_element_dofs = 21;
/// Where the center-line functions and the triads are among them.
inline constexpr std::array<int, 4> center_line_place = {0, 3, 12, 15};
inline constexpr std::array<int, 3> triad_place = {6, 9, 18};

/// Stiffness and inertia in the axes of the section, axis 1 along the fiber.
struct TriadSection {
  Vec3 force = Vec3::Zero();   ///< EA, k G A, k G A [force]
  Vec3 moment = Vec3::Zero();  ///< G J, E I2, E I3 [force length^2]
  Vec3 rotary = Vec3::Zero();  ///< rho_b (I2 + I3), rho_b I2, rho_b I3 [mass length]

  TriadSection() = default;
  TriadSection(const Section& section, const Material& material);
};

/// Points at which curvatures are taken.
inline constexpr int curvature_points = 2;

/// Length and strains at rest of one element.
struct TriadElement {
  double length = 0.0;                           ///< l_ele, reference arc length [length]
  std::array<Vec3, 3> strain;                    ///< Lambda_0^T r_0' at the triads
  std::array<Vec3, curvature_points> curvature;  ///< K_0 [1/length]

  /// The element at rest at center-line DoFs `q`, shape=(12), with these triads.
  TriadElement(double element_length, const double* q, const std::array<Quaternion, 3>& triads);
};

/// Stored energy [force length], Simo and Vu-Quoc 1986:
///
///   1/2 int Gamma . C_F Gamma ds + 1/2 int (K - K_0) . C_M (K - K_0) ds ,   Gamma = Lambda^T r' - Lambda_0^T r_0'
///
/// Gamma is taken at the triads and interpolated quadratically (assumed natural strain), which removes membrane and
/// shear locking. Triads are interpolated as Lambda(x) = Lambda_m exp(N_1 psi_1 + N_2 psi_2), psi_i = log(Lambda_m^T
/// Lambda_i), objective and independent of the path (Crisfield and Jelenic 1999, three nodes); K is its material
/// curvature.
double triad_energy(const TriadSection& section, const TriadElement& element, const double* q,
                    const std::array<Quaternion, 3>& triads);

/// residual = exact variation of the energy, shape=(21), and tangent = its derivative, shape=(21,21) row-major, not
/// symmetric away from equilibrium; `tangent` may be null. Moments and turns have components in the axes of their
/// triad.
void triad_internal_force(const TriadSection& section, const TriadElement& element, const double* q,
                          const std::array<Quaternion, 3>& triads, double* residual, double* tangent);

/// Share of the length that each triad carries of the rotary inertia (Simpson's rule).
inline constexpr std::array<double, 3> triad_share = {1.0 / 6, 4.0 / 6, 1.0 / 6};

}  // namespace fbi::beam
