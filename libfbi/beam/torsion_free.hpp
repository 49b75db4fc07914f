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
};

}  // namespace fbi::beam
