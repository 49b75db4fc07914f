/// Supported nodes of a fiber and their prescribed motion.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "beam/differences.hpp"
#include "beam/end_conditions.hpp"
#include "beam/generalized_alpha.hpp"
#include "beam/parameters.hpp"
#include "mesh/fiber_mesh.hpp"

namespace fbi::beam {

/// One supported node: what is held, and where it is at the ends of the current step.
///
/// A moved position is x = X + u(t) with velocity u' and acceleration u'' taken from the formulas, not from the time
/// scheme: Newmark's updates of a given displacement ring without damping. A moved direction leaves the stretch s of
/// the tangent t = s g(t) free; its rates follow the scheme, and t' = s' g + s g', t'' = s'' g + C with C = 2 s' g' + s
/// g''.
struct NodeSupport {
  Index node = 0;  ///< of the fiber
  NodeConstraint constraint;
  std::optional<input::VectorExpression> motion, direction;
  Vec3 reference = Vec3::Zero();
  Motion position_n, position;  ///< u(t) at t_n and t_{n+1}
  Motion axis_n, axis;          ///< g(t), a unit vector

  bool moves() const { return motion.has_value() || direction.has_value(); }
  /// Evaluates the motion for the step to `time`, forces balancing at the level `alpha_f`; dt = 0: statics, or the
  /// initial state.
  void begin_step(double time, double dt, double alpha_f);
  /// Writes the position, and the direction with the present stretch, into the DoFs q of the node, shape=(6).
  void place(double* q) const;
  /// Held parts of velocity and acceleration at t_{n+1} of the node; arrays of shape=(6).
  void set_rates(const GeneralizedAlpha& scheme, double dt, const double* q_n, const double* v_n, const double* a_n,
                 const double* q, double* v, double* a) const;
  /// What the held parts add to the acceleration at the level of the scheme, (alpha_m - alpha_f)(a_{n+1} - a_n),
  /// because they are accelerations at t_{n+1} and t_n while those of the scheme lag by alpha_f - alpha_m; shape=(6).
  void shift(const GeneralizedAlpha& scheme, const double* q_n, const double* v_n, const double* a_n, const double* q,
             const double* v, const double* a, double* out) const;
  /// Held parts of velocity and acceleration at the start of the step.
  void initial_rates(const double* q, double* v, double* a) const;
};

/// The supports of fiber `f`, the ends first. Throws Error(geometry) when a support lies on no node, when a node is
/// supported twice or when a moved support does not start at rest at the reference position.
std::vector<NodeSupport> supports_of(const FiberParameters& group, const mesh::FiberMesh& mesh, Index f, bool dynamic);

}  // namespace fbi::beam
