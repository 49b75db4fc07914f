/// Projection of a velocity onto the fields without divergence in the weak sense.
#pragma once

#include <vector>

#include "fluid/operator.hpp"
#include "linalg/pressure_solver.hpp"

namespace fbi::fluid {

/// What remove_divergence did. The same on every rank.
struct Projection {
  int iterations = 0;
  double before = 0.0, after = 0.0;  ///< root of sum_a (int N_a div v)^2 / int N_a [velocity length^(1/2)]
  double change = 0.0;               ///< largest nodal change of the velocity [length/time]
};

/// Brings u to the nearest velocity, in the norm of the lumped mass, with int N_a div v = 0 and the same given
/// components: v - M^-1 D^T phi with A phi = D v, A = 0.95 D M^-1 D^T + 0.05 L by conjugate gradients, repeated until
/// what it can remove is removed. The Laplacian L makes A regular where equal-order pressures are not seen by D M^-1
/// D^T; what given velocities force on those stays. Collective.
/// @param is_dirichlet   given unknowns, shape=(local nodes,4)
/// @param lumped_volume  int N_a, shape=(local nodes) [length^3]
/// @param laplacian      int grad N_a . grad N_b with open faces closed by a Robin term
/// @param singular       the constant phi is in the kernel
/// @param u              ghosted vector of block size 4
Projection remove_divergence(const mesh::HexMesh& mesh, const Operator& cells, const std::vector<char>& is_dirichlet,
                             const std::vector<double>& lumped_volume, linalg::MatHandle laplacian, bool singular,
                             Vec u);

}  // namespace fbi::fluid
