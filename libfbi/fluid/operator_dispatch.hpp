/// Templates of Operator that its source files share: the choice of a kernel, and nodal arrays to batches and back.
#pragma once

#include "fluid/operator.hpp"

namespace fbi::fluid {

template <>
inline const std::vector<BoxCells>& Operator::geometry<BoxGeometry>() const {
  return box_;
}
template <>
inline const std::vector<GeneralCells>& Operator::geometry<GeneralGeometry>() const {
  return general_;
}

template <class Action>
void Operator::dispatch(const Action& action) const {
  const bool viscous = parameters_.viscous_residual == ViscousResidual::full;
  const auto with_options = [&]<class Geometry, bool Convection, bool Extended>() {
    if (viscous)
      action.template operator()<Geometry, Equations{Convection, true, Extended}>();
    else
      action.template operator()<Geometry, Equations{Convection, false, Extended}>();
  };
  const auto with_geometry = [&]<class Geometry>() {
    if (convection() && extended_)
      with_options.template operator()<Geometry, true, true>();
    else if (convection())
      with_options.template operator()<Geometry, true, false>();
    else if (extended_)
      with_options.template operator()<Geometry, false, true>();
    else
      with_options.template operator()<Geometry, false, false>();
  };
  if (!box_.empty())
    with_geometry.template operator()<BoxGeometry>();
  else
    with_geometry.template operator()<GeneralGeometry>();
}

inline void Operator::gather(const CellBatch& batch, const double* array, Batch (*out)[8]) const {
  for (int a = 0; a < 8; ++a) {
    Batch four[4];
    fem::gather_four(array, batch.node[a].data(), four);
    for (int c = 0; c < 4; ++c) out[c][a] = four[c];
  }
}

inline void Operator::scatter(const CellBatch& batch, const Batch (*in)[8], double* array) const {
  for (int a = 0; a < 8; ++a) {
    const Batch four[4] = {in[0][a], in[1][a], in[2][a], in[3][a]};
    fem::scatter_add_four(four, batch.node[a].data(), batch.lanes, array);
  }
}

}  // namespace fbi::fluid
