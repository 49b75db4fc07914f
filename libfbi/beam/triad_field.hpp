/// Triads of the fibers of one rank that have them: state, rotational equations, tangents of center line and triads.
#pragma once

#include <vector>

#include "base/types.hpp"
#include "beam/band_lu.hpp"
#include "beam/simo_reissner.hpp"

namespace fbi::beam {

struct FiberEquations;

/// Rotations of the sections at the nodes and in the middle of the elements, with the equations
///
///   J A_level + [ M_int + Omega x J Omega - Lambda^T m ]_{1-alpha_f} = 0
///
/// in the axes of each triad: rotary inertia J lumped at the triads, angular velocity Omega and acceleration A in their
/// axes, end moments m. In time Lambda_{n+1} = Lambda_n exp(Delta) with the updates of generalised-alpha applied to
/// Delta, Omega and A (Bruels and Cardona 2010).
///
/// Arrays of shape=(nodes,6) hold three components of the triad of a node, then three of the triad in the middle of
/// the element behind it; those behind last nodes are unused and zero. In vectors of all unknowns of a fiber the
/// center line, shape=(6 nodes), comes before the triads, shape=(6 nodes).
struct TriadField {
  // state at t_n
  std::vector<double> rotation_n;           // rotation vector from the axes x, y, z to the triad
  std::vector<double> spin_n, spin_rate_n;  // Omega, A
  std::vector<double> moment_n;             // internal + gyroscopic - external
  std::vector<double> external_n, work_n;   // moments of loads and their work
  // iterate at t_{n+1}
  std::vector<Quaternion> triad_n, triad;  // two a node
  std::vector<double> spin, spin_rate, moment, external;
  std::vector<double> residual;     // with held triads projected out
  std::vector<double> held_moment;  // residual of held triads: what their supports exert
  std::vector<double> turn;         // Delta

  /// Reference triads: first axes along the center line, second axes carried along without twist from `direction`.
  explicit TriadField(FiberEquations& equations);

  bool is_condensed(Index f) const { return condensed_[f] != 0; }
  /// A support holds the triad of a node of this rank.
  bool is_held(Index node) const { return held_[2 * static_cast<std::size_t>(node)] != 0; }
  /// Moment that the support exerts on the held triad of a node, in the axes x, y, z.
  Vec3 support_moment(Index node) const {
    const std::size_t t = 2 * static_cast<std::size_t>(node);
    return triad[t] * Vec3(&held_moment[3 * t]);
  }
  bool has(Index f) const { return band_begin_[f + 1] > band_begin_[f]; }
  /// Sets the iterate to the state.
  void begin_step();
  void accept_step();
  /// Adds dt Omega_n to the turn of one fiber.
  void predict(FiberEquations& equations, Index f);

  /// As FiberEquations::evaluate, for center line and triads; the tangent stays available for `condense`.
  void evaluate(FiberEquations& equations, Index f, bool with_tangent);
  /// Mass of center line and triads instead of the tangent.
  void assemble_mass(FiberEquations& equations, Index f);
  bool factorize(FiberEquations& equations, Index f);
  /// Eliminates the triads: residual of the center line becomes G_c - K_cr K_rr^-1 G_r, so that a solve with it gives
  /// the center-line part of the increment of all unknowns.
  void condense(FiberEquations& equations, Index f);
  /// x = K^-1 [b; 0], of which the center line is kept: b of shape=(6 nodes,columns) row-major.
  void solve(const FiberEquations& equations, Index f, double* b, Index columns) const;
  /// x = K^-1 b for all unknowns with supports projected out, b of shape=(12 nodes,columns) row-major.
  void solve_all(const FiberEquations& equations, Index f, double* b, Index columns = 1) const;
  /// Adds to one diagonal entry of the tangent, before it is factorised; `unknown` of center line or turns.
  void add_to_diagonal(const FiberEquations& equations, Index f, Index unknown, double value);
  /// Turns that belong to an increment of the center line at the last condensation, -K_rr^-1 (G_r + K_rc delta).
  std::vector<double> turns(const FiberEquations& equations, Index f, const double* delta) const;
  /// Turns the triads by factor * turns, shape=(6 nodes), and updates spins.
  void add_turns(const FiberEquations& equations, Index f, const double* turns, double factor);
  void update_rates(const FiberEquations& equations, Index f);
  /// Spins that turn the center line as its velocity says, without twist; of joined fibers, whose sections turn each
  /// other, with the twist that half the curl of the formulas has.
  void set_initial_spin(const FiberEquations& equations, Index f, const input::VectorExpression& given);
  /// Angular acceleration from equilibrium.
  void initialize(const FiberEquations& equations, Index f);

  /// Sum of the squared residuals of the triads, moments divided by the shortest element length [force^2].
  double squared_residual(const FiberEquations& equations, Index f) const;
  double internal_energy(const FiberEquations& equations, Index f) const;  ///< of the state
  double rotary_energy(const FiberEquations& equations, Index f) const;
  double moment_work(const FiberEquations& equations, Index f) const;
  /// Spatial angular momentum of the rotary inertia of the state.
  Vec3 rotary_momentum(const FiberEquations& equations, Index f) const;

  std::vector<TriadSection> section;  // of each fiber

 private:
  std::array<Quaternion, 3> element_triads(const std::vector<Quaternion>& triads, Index node) const;
  /// Point moments on the triads, forces that follow on the center line; with their derivatives in the tangent.
  void add_point_loads(FiberEquations& equations, Index f, bool with_tangent);
  void constrain(const FiberEquations& equations, Index f);

  std::vector<char> held_;              // triads that supports hold, two a node
  std::vector<Quaternion> reference_;   // triads at rest, two a node
  std::vector<TriadElement> elements_;  // of all fibers; those of fibers without triads are not used
  std::vector<double> share_;           // length that each triad carries, two a node
  std::vector<std::size_t> band_begin_, turn_band_begin_;
  std::vector<double> tangent_, band_, turn_band_;
  std::vector<Index> pivot_, turn_pivot_;
  std::vector<char> singular_, condensed_;
};

}  // namespace fbi::beam
