/// Joints between fibers: constraints with multipliers, eliminated exactly from the factors of each fiber.
#pragma once

#include <Eigen/LU>
#include <memory>
#include <string>
#include <vector>

#include "beam/fiber_equations.hpp"

namespace fbi::beam {

/// Groups of fibers that hang together, and what their joints demand.
///
/// A group solves  [K F; L Q] [dx; dy] = [r; -c],  K the block diagonal of its fibers' K_b, y the multipliers mu of the
/// constraints c(x) = 0 and the turns of rigid joints:  dx = K^-1 r - X dy,  (L X - Q) dy = L K^-1 r + c,  X = K^-1 F.
/// A position joint demands r_a - r_b = const. A rigid joint has a rotation R of its own that turns the reference
/// tangents g: R n . t = 0 for the two n normal to each g, mu for it the couple that bends the fiber; the moments of
/// all couples on R are in balance. Forces of joints act in the mean of their directions at t_n and t_{n+1}, weighted
/// as internal forces are. Where two fibers of one section continue each other, a rigid joint demands equal tangents.
/// Fibers with triads take part with their sections: log((R G)^T Lambda) = 0 for the triad G at rest, mu a moment in
/// the axes of Lambda; their tangents are free to shear unless two such fibers of one section continue each other.
///
/// Vectors of all unknowns hold those of the group's fibers one after the other: of each the center line,
/// shape=(6 nodes), then, with triads, the turns, shape=(6 nodes).
class Joints {
 public:
  /// Text of what cannot be computed goes to `error`: joints of fibers of other formulations.
  Joints(const FiberEquations& equations, std::string& error);
  ~Joints();

  Index groups() const;
  /// Number of multipliers and turns of a group.
  Index unknowns(Index group) const;
  Index dofs(Index group) const;  ///< of all its fibers
  /// First unknown of each fiber of a group in vectors of all unknowns, shape=(fibers+1).
  const std::vector<Index>& first_unknowns(Index group) const;

  /// Values of the group's fibers, one after the other, shape=(dofs), out of and into a nodal field.
  std::vector<double> gather(Index group, const NodalField& field) const;
  void scatter(Index group, const std::vector<double>& values, NodalField& field) const;

  /// Forgets multipliers, and takes the turn of every joint from the tangents at t_n.
  void begin_step(const FiberEquations& equations);
  void begin_step(const FiberEquations& equations, Index group);
  /// Turns of the joints that fit the tangents of the iterate, multipliers zero: after the fibers of a group were
  /// moved.
  void fit(const FiberEquations& equations, Index group);
  /// Adds the forces of the joints to `full` and `residual` of the group's fibers, which hold those of the fibers
  /// alone.
  void add_forces(FiberEquations& equations, Index group) const;
  /// Statics: springs at joints, added to the bands of the fibers before they are factorised and taken out again by
  /// solve(), so that fibers held by nothing but joints have a K_b^-1.
  void add_springs(FiberEquations& equations, Index group) const;
  /// Prepares solve() from the factors of the group's fibers; false when the group is singular or not finite.
  bool factorize(const FiberEquations& equations, Index group);
  /// Forces on all unknowns of the group become increments, including what closes the gaps of the constraints; the
  /// increments of multipliers and turns of joints wait for advance().
  void solve_all(const FiberEquations& equations, Index group, std::vector<double>& b);
  /// The same for forces on center lines, shape=(dofs), after the triads were eliminated from the residual
  /// (FiberEquations::condense); turns() then has the increments of the triads.
  void solve(const FiberEquations& equations, Index group, std::vector<double>& b);
  /// Turns of the triads of fiber `f` that belong to the last solve(), shape=(6 nodes).
  const double* turns(const FiberEquations& equations, Index f) const;
  /// Adds factor times what the last solve() found to multipliers and turns.
  void advance(Index group, double factor);
  /// D K^-1 D^T of the group, rows of its fibers one after the other; `d[i]`, shape=(rows[i], 2 nodes), of fiber i.
  void compliance(const FiberEquations& equations, Index group, const std::vector<const double*>& d,
                  const std::vector<Index>& rows,
                  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>& block) const;
  /// Largest gap of the constraints as a force on a fiber as stiff as the stiffest of the group [force].
  double gap_force(const FiberEquations& equations, Index group) const;
  /// Multipliers and turns, to go back to.
  struct State;
  std::shared_ptr<const State> state(Index group) const;
  void restore(Index group, const State& state);

  /// Adds what the joints do to initial accelerations, from the mass factors of the fibers in their bands. Text when
  /// the initial velocities tear a joint apart.
  std::string balance_acceleration(FiberEquations& equations);
  /// The same for the groups whose supports begin to move, after FiberEquations::start_moving_supports.
  std::string start_moving_supports(FiberEquations& equations);

 private:
  struct Group;
  std::string balance_acceleration(FiberEquations& equations, Index group);
  std::vector<Group> groups_;
};

/// Sets the first iterate of a step in time of a group: d_n + dt v_n, or d_n where that gives the smaller residual.
void predict_group(FiberEquations& equations, Joints& joints, Index group);

/// Newton's method for the fibers of a group together, as solve_fiber() does it for one fiber.
int solve_group(FiberEquations& equations, Joints& joints, Index group, const std::vector<double>& force);

}  // namespace fbi::beam
