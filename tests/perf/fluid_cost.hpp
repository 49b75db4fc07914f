/// Arithmetic and memory traffic of the fluid operators, counted: the point equations by running them on numbers that
/// count, the transforms around them by their loops (fluid/hex8_transform.hpp, hex8_geometry.hpp).
#pragma once

#include "fluid/physics.hpp"
#include "mesh/hex_mesh.hpp"
#include "perf/measure.hpp"

namespace fbi::perf {

/// A number that counts the operations done with its kind.
struct Counting {
  static inline long operations = 0;
  Counting(double = 0.0) {}  // NOLINT: as numbers do
  friend Counting operator+(Counting, Counting) { return one(); }
  friend Counting operator-(Counting, Counting) { return one(); }
  friend Counting operator*(Counting, Counting) { return one(); }
  static Counting one() {
    ++operations;
    return {};
  }
};

/// Operations of the point equations with all terms of the default.
template <class T>
long point_operations() {
  constexpr fluid::Equations all{true, true, false};
  fluid::PointState<T> state;
  fluid::PointCoefficients<Counting> coefficients;
  fluid::PointFlux<T> flux;
  Counting::operations = 0;
  fluid::navier_stokes<all>(state, coefficients, flux);
  return Counting::operations;
}

/// Of a residual (or a tangent) on the cells of this rank.
inline Cost fluid_cost(const mesh::HexMesh& mesh, bool general, bool tangent) {
  // one component from corners to modes, values, first derivatives; the three velocities' mixed second derivatives
  const int field = 4 * (32 + 24 + 24) + 3 * 6, rest = 3 * (32 + 24), integrate = 4 * (24 + 60 + 32);
  const int setup = general ? 9 * (8 + 2) : 0;
  const int jacobian = general ? 27 + 5 + 1 + 9 + 1 : 0;
  const int gradient = 4 * (general ? 15 : 3), viscous = general ? 3 * (18 + 6 + 10 + 15) : 12;
  const int pull_back = 4 * (1 + (general ? 18 : 6));
  const int state = gradient + viscous + 6;
  double flops = field + rest + setup + integrate + 8 * (jacobian + state + pull_back);
  flops +=
      8.0 * static_cast<double>(tangent ? point_operations<fluid::Dual<Counting>>() : point_operations<Counting>());
  if (tangent) flops += field + 8 * (state + 3);
  // nodal arrays read once: state, acceleration (and direction), the result read and written; of a cell its nodes,
  // three tau and the geometry
  const double nodal = 8.0 * 4 * (tangent ? 5 : 4), cell = 8 * 4 + 3 * 8 + (general ? 24 * 8 : 4 * 8);
  return {nodal * mesh.local_nodes() + cell * mesh.local_cells(), flops * mesh.local_cells()};
}

/// Of a solve by TensorPoisson on this rank, mirrored lines across the axis: two products with half the work along each
/// of two directions, and the tridiagonal sweeps (9 flops and a pivot a node, read twice).
template <class Real>
Cost tensor_cost(const mesh::HexMesh& mesh, Index n1, Index n2) {
  return {sizeof(Real) * (6.0 * 2 + 2) * mesh.owned_nodes, (2.0 * n1 + 2.0 * n2 + 9) * mesh.owned_nodes};
}

}  // namespace fbi::perf
