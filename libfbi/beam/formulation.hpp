/// What a beam formulation must give for one element, and the table of all formulations.
#pragma once

#include "beam/parameters.hpp"

namespace fbi::beam {

/// DoFs of one element: d_1, t_1, d_2, t_2, each with three components.
inline constexpr int element_dofs = 12;

/// Everything an element knows about itself.
struct ElementProperties {
  double length = 0.0;             ///< l_ele, reference arc length [length]
  double axial_stiffness = 0.0;    ///< EA [force]
  double bending_stiffness = 0.0;  ///< EI [force length^2]
  double mass_per_length = 0.0;    ///< rho_b A [mass/length]
};

/// Physics of one Hermite element as pure functions: plain arrays in and out, no allocation.
class ElementFormulation {
 public:
  virtual ~ElementFormulation() = default;

  /// Stored energy [force length] at the DoFs `q`, shape=(12).
  virtual double energy(const ElementProperties& element, const double* q) const = 0;
  /// residual = d energy/dq, shape=(12), and tangent = d residual/dq, shape=(12,12) row-major; `tangent` may be null.
  virtual void internal_force(const ElementProperties& element, const double* q, double* residual,
                              double* tangent) const = 0;
  /// Consistent mass, shape=(12,12) row-major, symmetric.
  virtual void mass(const ElementProperties& element, double* mass) const = 0;
};

/// The formulation behind a name; null for fibers that have no equations.
const ElementFormulation* element_formulation(Formulation formulation);

}  // namespace fbi::beam
