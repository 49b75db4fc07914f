#include "beam/formulation.hpp"

#include "beam/torsion_free.hpp"

namespace fbi::beam {

const ElementFormulation* element_formulation(Formulation formulation) {
  static const TorsionFree torsion_free;
  switch (formulation) {
    case Formulation::torsion_free:
    case Formulation::simo_reissner:
      return &torsion_free;
    case Formulation::fixed:
      return nullptr;
  }
  return nullptr;
}

}  // namespace fbi::beam
