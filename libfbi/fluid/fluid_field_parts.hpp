/// What a FluidField consists of; for its own source files.
#pragma once

#include <memory>
#include <vector>

#include "fluid/boundary_conditions.hpp"
#include "fluid/fluid_field.hpp"
#include "fluid/ghosted.hpp"
#include "fluid/node_matrix.hpp"
#include "fluid/operator.hpp"
#include "fluid/single_tangent.hpp"

namespace fbi::fluid {

struct FluidField::Implementation {
  Implementation(const mesh::HexMesh& mesh, const FluidParameters& p, const BoundaryConditions& conditions,
                 const FluidTimeParameters& t)
      : mesh(mesh),
        parameters(p),
        time_parameters(t),
        boundaries(mesh, conditions, p.density),
        cells(mesh, p),
        iterate(create_ghosted(mesh)),
        accepted(create_ghosted(mesh)),
        previous(create_ghosted(mesh)),
        rate(create_ghosted(mesh)),
        linearization(create_ghosted(mesh)),
        work(create_ghosted(mesh)),
        sum(create_ghosted(mesh)),
        rest(4 * static_cast<std::size_t>(mesh.local_nodes()), 0.0) {}

  std::size_t unknowns() const { return rest.size(); }
  std::size_t owned() const { return 4 * static_cast<std::size_t>(mesh.owned_nodes); }
  bool steady() const { return time_parameters.scheme == TimeScheme::steady; }

  void compute_lumped_volume();
  void compute_pressure_is_free();
  void compute_smallest_cell();
  void evaluate_initial_velocity();
  bool report_start();
  void evaluate_body_force(double t);
  void compute_rest();
  void update_tau();
  void sum_residual(const std::function<void(double*)>& add = nullptr, bool linearize = false);
  double largest_speed(Vec u);

  const mesh::HexMesh& mesh;
  FluidParameters parameters;
  FluidTimeParameters time_parameters;
  Boundaries boundaries;
  Operator cells;
  linalg::VecHandle iterate, accepted, previous;
  linalg::VecHandle rate;           // v' of the accepted state; the pressure entries are zero
  linalg::VecHandle linearization;  // state at which tangents are taken
  linalg::VecHandle work, sum;
  std::vector<double> rest;        // nodal dv/dt - b - sigma v of the step
  std::vector<double> body_force;  // nodal b, empty when zero
  std::vector<double> lumped_volume;
  std::unique_ptr<NodeMatrix> jacobian;
  std::unique_ptr<SingleTangent> single;
  bool single_is_new = false;  // it is that of the iterate
  bool pressure_is_free = false;
  double smallest_cell = 0.0;
  RateFormula formula;
  double theta = 1.0, dt = 0.0;
  double tau_sigma = -1.0, tau_dt = -1.0;  // that tau was computed for
  Linearization convection = Linearization::newton;
  // history beyond the vectors; doubles so that a restart can hold them
  double previous_dt = 0.0, accepted_steps = 0.0, startup_left = 0.0;
  double impulsive = 0.0;  // 1: v_0 does not fit the boundary values or has divergence
};

}  // namespace fbi::fluid
