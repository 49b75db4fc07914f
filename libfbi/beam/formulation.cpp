#include "beam/formulation.hpp"

#include <algorithm>

#include "beam/torsion_free.hpp"

namespace fbi::beam {

void ElementFormulation::conserving_force(const ElementProperties& element, const double* q_n, const double* q,
                                          double* residual, double* tangent) const {
  double last[element_dofs];
  internal_force(element, q_n, last, nullptr);
  internal_force(element, q, residual, tangent);
  for (int i = 0; i < element_dofs; ++i) residual[i] = 0.5 * (residual[i] + last[i]);
  if (tangent != nullptr)
    for (int i = 0; i < element_dofs * element_dofs; ++i) tangent[i] *= 0.5;
}

void ElementFormulation::viscous_force(const ElementProperties& /*element*/, const double* /*q*/, const double* /*v*/,
                                       double* force, double* by_q, double* by_v) const {
  std::fill_n(force, element_dofs, 0.0);
  if (by_q != nullptr) std::fill_n(by_q, element_dofs * element_dofs, 0.0);
  if (by_v != nullptr) std::fill_n(by_v, element_dofs * element_dofs, 0.0);
}

const ElementFormulation* element_formulation(Formulation formulation) {
  static const TorsionFree torsion_free;
  switch (formulation) {
    case Formulation::torsion_free:
    case Formulation::simo_reissner:  // its center line has the same mass; strains need the triads: TriadField
    case Formulation::rigid:          // only its mass is used
      return &torsion_free;
    case Formulation::prescribed:
    case Formulation::fixed:
      return nullptr;
  }
  return nullptr;
}

}  // namespace fbi::beam
