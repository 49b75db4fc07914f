/// The fluid field: state, time integration, matrix-free residual and tangent, boundary conditions.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/types.hpp"
#include "fluid/parameters.hpp"
#include "fluid/time_scheme.hpp"
#include "linalg/petsc.hpp"
#include "mesh/hex_mesh.hpp"

namespace fbi::fluid {

class Boundaries;
class SingleTangent;

/// Velocity and pressure on a distributed mesh, four interleaved unknowns (vx, vy, vz, p) per node.
///
/// Vectors are PETSc ghosted vectors of block size 4: owned nodes first, then ghosts, in the order of the mesh's local
/// nodes. The equations of a step are R(u) = 0 at t_{n+1} with R of the stabilised weak form (internal minus external);
/// a coupling adds M^T lambda to R. Rows of given velocity components are Dirichlet rows: R is zero there and the
/// tangent is the identity. On slip walls that do not lie along the axes the same holds for the velocity along the
/// normals of a node: the residual has no part along them, the tangent is P A P + (I - P) with P v = v - n (n.v).
class FluidField {
 public:
  FluidField(const mesh::HexMesh& mesh, const FluidParameters& parameters, const BoundaryConditions& boundaries,
             const FluidTimeParameters& time);
  ~FluidField();

  const mesh::HexMesh& mesh() const;
  const FluidParameters& parameters() const;
  linalg::VecHandle create_vector() const;  ///< ghosted, zero

  /// Initial velocity by expression, boundary values at t = 0 on top, made divergence-free on request, pressure 0. With
  /// theta < 1: v'_0 = 0 where that is exact (rest, no forces, no moving boundary values); otherwise v'_0 = 0 and two
  /// steps with theta = 1, after which v' obeys the equations and the constraint, at a start error of second order.
  /// BDF2 starts with one step of theta = 1 for the same reason, two where the data do not fit together. An impulsive
  /// start is reported. Call once. Collective.
  void initialize();

  /// Starts the step to t_{n+1} = time: boundary values, tau from the extrapolated velocity, iterate = extrapolation of
  /// earlier steps with the boundary values of t_{n+1} on top. dt = 0 for steady. Calling it again restarts the same
  /// step. Collective.
  void begin_step(double time, double dt);
  /// dv'/dv of this step: 1/(theta dt), 3/(2 dt) for BDF2, that of pseudo-time for steady (0 without).
  double sigma() const;
  bool is_second_order() const;  ///< the error in time, or nearly: BDF2, theta < 0.6
  double theta() const;  ///< of this step (1 in start-up steps after an impulsive start, for BDF2 and for steady)
  RateFormula rate_formula() const;  ///< of this step
  bool is_steady() const;
  /// No term of the equations is nonlinear: the tangent changes with the time step only. The same on every rank.
  bool is_linear() const;

  /// How the convecting velocity is treated; newton if never called. Takes effect with the next begin_step or, between
  /// newton and picard, with the next tangent.
  void set_linearization(Linearization linearization);
  /// Renews tau from the iterate, which begin_step does from the extrapolated velocity. For steady flow. Collective.
  void update_tau();
  /// Steady flow: adds rho sigma times the distance from the present iterate to the equations, so that the residual of
  /// this iterate stays what it is and its tangent gains inertia; tau does not see sigma. Call it after every change of
  /// the iterate. Collective.
  void set_pseudo_time(double sigma);

  Vec iterate();   ///< u_{n+1}^i, ghosts up to date after every member function that changes it
  Vec accepted();  ///< u_n
  /// Adds an increment (owned part) to the iterate and updates the ghosts; with `tau_update` iteration tau follows, so
  /// that residual and tangent of an iterate have the same tau. Collective.
  void increment(Vec delta);

  /// r = R(iterate) on owned rows, zero in Dirichlet rows. Collective.
  /// @param add  adds further forces to local nodes (owned, then ghosts), shape=(nodes,4); may be null
  /// @param linearize  the iterate will be linearised before it changes: single_tangent() has less to do then
  void residual(Vec r, const std::function<void(double*)>& add = nullptr, bool linearize = false);
  /// The consistent nodal reactions: R(iterate) on all rows, Dirichlet rows included. Collective.
  void reactions(Vec r);
  /// The same without tractions, pressures and backflow on faces: what cells and boundary exchange. Collective.
  void internal_forces(Vec r);
  const Boundaries& boundaries() const;
  /// Fixes the state at which apply_jacobian and the assembled tangents are taken: the iterate. Collective.
  void linearize();
  /// y = dR/du x for the exact tangent at fixed tau; identity in Dirichlet rows, Dirichlet columns dropped. Collective.
  void apply_jacobian(Vec x, Vec y);
  /// The same tangent in single precision, taken at the state of the last linearize(); null for equations that it does
  /// not have (SingleTangent). Every call takes it anew. Collective.
  SingleTangent* single_tangent();
  bool has_single_precision() const;  ///< these equations have it
  /// The same tangent as an AIJ matrix of block size 4 (block structure of the mesh), from the same kernel. Every call
  /// returns the same PETSc matrix with new values (pattern and communication are kept). Collective.
  linalg::MatHandle assemble_jacobian();

  /// 1 for Dirichlet unknowns, 0 elsewhere, shape=(local nodes,4).
  const std::vector<char>& is_dirichlet() const;
  /// Some node of this rank has a zero velocity along normals that are not axes.
  bool has_normal_constraints() const;
  /// P of a local node: the velocities that such normals leave free.
  Mat3 free_directions(Index node) const;
  /// values = P values: takes out the parts along such normals at the first `nodes` local nodes, shape=(nodes,4).
  void remove_normal(double* values, Index nodes) const;
  /// to = P to + (I - P) from, both shape=(nodes,4).
  void set_normal(const double* from, double* to, Index nodes) const;
  /// No face leaves the pressure level open: the constant pressure mode is in the kernel; the mean must be fixed to
  /// zero.
  bool pressure_is_free() const;
  /// Net flow out of the boundary sum_a v_a . int N_a n of the iterate, and its measure sum_a |v_a| |int N_a n| over
  /// the nodes of given velocity and over all nodes of faces, each face once [length^3/time]. Collective.
  std::array<double, 3> boundary_flow() const;
  /// Lumped mass sum_b int N_a N_b per local node (ghosts complete), shape=(local nodes) [length^3].
  const std::vector<double>& lumped_volume() const;
  /// tau_M of PSPG at each local cell for this step [time/density], shape=(local cells).
  const std::vector<double>& tau_m() const;
  /// tau_M of SUPG at a local cell [time/density].
  double tau_streamline(Index cell) const;
  /// tau_C at a local cell [viscosity].
  double tau_c(Index cell) const;
  /// Coefficient of the pressure projection in a local cell, 0 with PSPG [1/viscosity].
  double pressure_projection(Index cell) const;
  /// Volume of a local cell [length^3].
  double cell_volume(Index cell) const;
  /// (Pressure operator for preconditioning) AIJ matrix of int grad N_a . grad N_b with `coefficient` per local cell,
  /// plus `robin` times `coefficient` times the face mass int N_a N_b / h on open (traction, outflow) faces, h = the
  /// local cell size normal to the face.
  linalg::MatHandle pressure_laplacian(const std::vector<double>& coefficient, double robin) const;

  /// Sides of a box mesh (direction, low or high end) that leave the pressure open; all false for other meshes.
  /// Collective.
  std::array<std::array<bool, 2>, 3> open_sides() const;

  /// Makes the iterate the accepted state, updates v' and the history. Collective.
  void accept_step();

  /// Root mean square of v_{n+1} - v_n over dt and the root mean square of v_{n+1}, of the last accepted step [1/time];
  /// infinite when nothing moves. Collective.
  double relative_rate();
  /// Kinetic energy int 1/2 rho |v|^2, largest CFL number sum_d |dxi_d/dx . v| dt/2 at a cell center (on boxes
  /// sum_i |v_i| dt/h_i), largest nodal |v|; of the iterate. Collective.
  double kinetic_energy();
  double cfl();
  double max_velocity();
  /// rho int v of vector u (velocity part); momentum of the fluid. Collective.
  Vec3 momentum(Vec u);

  /// State vectors that a restart needs, by name, to save and to restore bitwise (owned part; ghosts are updated by
  /// `state_restored`), and named scalars (step control, start-up counter).
  std::vector<std::pair<std::string, Vec>> state();
  std::vector<std::pair<std::string, double*>> scalars();
  void state_restored();

  /// Smallest V^(1/3) over the cells of all ranks, for reports [length].
  double smallest_cell() const;

 private:
  void make_divergence_free();

  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace fbi::fluid
