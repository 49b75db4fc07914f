#include "beam/torsion_free.hpp"

#include <algorithm>
#include <cmath>

#include "beam/torsion_free_element.hpp"

namespace fbi::beam {

using namespace torsion_free;

double TorsionFree::energy(const ElementProperties& element, const double* q) const {
  const AxialStrain s = axial_strain(element, q);
  const std::array<double, 3> n = axial_forces(element, s.strain);
  double energy = 0.5 * (n[0] * s.strain[0] + n[1] * s.strain[1] + n[2] * s.strain[2]);
  for (int p = 0; p < gauss_points; ++p) {
    const Vector t = combine(first_weights(gauss_point[p], element.length), q);
    const Vector c = combine(second_weights(gauss_point[p], element.length), q);
    const Vector cross = {t[1] * c[2] - t[2] * c[1], t[2] * c[0] - t[0] * c[2], t[0] * c[1] - t[1] * c[0]};
    const double tt = dot(t, t);
    energy += 0.5 * element.bending_stiffness * gauss_weight[p] * 0.5 * element.length * dot(cross, cross) / (tt * tt);
  }
  return energy;
}

void TorsionFree::internal_force(const ElementProperties& element, const double* q, double* residual,
                                 double* tangent) const {
  std::fill_n(residual, element_dofs, 0.0);
  if (tangent != nullptr) std::fill_n(tangent, element_dofs * element_dofs, 0.0);
  add_axial(element, q, residual, tangent);
  add_bending(element, q, residual, tangent);
  if (tangent != nullptr) mirror(tangent);
}

void TorsionFree::mass(const ElementProperties& element, double* mass) const {
  double scalar[4][4];
  scalar_mass(element, scalar);
  std::fill_n(mass, element_dofs * element_dofs, 0.0);
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 3; ++k) mass[element_dofs * (3 * i + k) + 3 * j + k] = scalar[i][j];
}

}  // namespace fbi::beam
