/// Geometrically exact Kirchhoff beam without torsion: cubic Hermite center line, initially straight, isotropic
/// section.
#pragma once

#include "beam/formulation.hpp"

namespace fbi::beam {

/// Energy of SPEC section 2 with ' = d/ds:
///
///   EA/2 int eps_h^2 ds + EI/2 int |r' x r''|^2/|r'|^4 ds ,   eps_h = sum_c L_c(x) (|r'(x_c)| - 1),  x_c = -1, 0, 1
///
/// The axial strain is assumed natural: collocated at x_c and interpolated by the quadratic Lagrange functions L_c,
/// which removes membrane locking. Its integral is exact; the bending integral uses Gauss points. Elements are straight
/// in the reference state, so ds = (l_ele/2) dx.
class TorsionFree final : public ElementFormulation {
 public:
  double energy(const ElementProperties& element, const double* q) const override;
  void internal_force(const ElementProperties& element, const double* q, double* residual,
                      double* tangent) const override;
  /// rho_b A int H_i H_j ds for each direction, integrated exactly.
  void mass(const ElementProperties& element, double* mass) const override;
  /// Strains averaged, their gradients replaced by difference quotients: the work over a step is exactly the change of
  /// the energy, and resultant and moment are zero (Simo, Tarnow 1992; Gonzalez 1996).
  void conserving_force(const ElementProperties& element, const double* q_n, const double* q, double* residual,
                        double* tangent) const override;
  /// Kelvin-Voigt: EA and EI times the rates of strain and of the curvature vector seen from the turning tangent,
  /// which is taken not to spin about itself.
  void viscous_force(const ElementProperties& element, const double* q, const double* v, double* force, double* by_q,
                     double* by_v) const override;
};

}  // namespace fbi::beam
