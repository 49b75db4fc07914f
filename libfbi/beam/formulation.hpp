/// What a beam formulation must give for one element, and the table of all formulations.
#pragma once

#include "beam/parameters.hpp"

namespace fbi::beam {

/// DoFs of one element: d_1, t_1, d_2, t_2, each with three components.
inline constexpr int element_dofs = 12;

/// Everything an element knows about itself. T: double, or a batch of elements.
template <class T>
struct ElementPropertiesOf {
  T length = 0.0;             ///< l_ele, reference arc length [length]
  T axial_stiffness = 0.0;    ///< EA [force]
  T bending_stiffness = 0.0;  ///< EI [force length^2]
  T mass_per_length = 0.0;    ///< rho_b A [mass/length]
};
using ElementProperties = ElementPropertiesOf<double>;

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
  /// Internal force of the midpoint scheme for the step from the DoFs `q_n` to `q`, shape=(12) each, and its derivative
  /// by `q`, shape=(12,12) row-major and not symmetric, or null. Unless a formulation has better: the average of both.
  virtual void conserving_force(const ElementProperties& element, const double* q_n, const double* q, double* residual,
                                double* tangent) const;
  /// Force of stresses that are the stiffness times strain rates (time constant 1) at DoFs `q` with rates `v`, and its
  /// derivatives by both, shape=(12,12) row-major, or null. Zero for formulations without.
  virtual void viscous_force(const ElementProperties& element, const double* q, const double* v, double* force,
                             double* by_q, double* by_v) const;
};

/// The formulation behind a name; null for fibers that have no equations.
const ElementFormulation* element_formulation(Formulation formulation);

}  // namespace fbi::beam
