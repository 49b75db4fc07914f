/// The fibers solved for a given velocity of the fluid, the penalty implicit in them.
#pragma once

#include <vector>

#include "fsi/system.hpp"

namespace fbi::fsi {

/// D^T S^-1 b with the S of the interface operator as it is, shape=(fiber nodes,6) [force]; b of
/// shape=(rows,3) [velocity length].
std::vector<double> spring_force(const System& system, std::vector<double> b);

/// Newton on G_b(d) = w (pull - D^T S^-1 D v_b(d)) + (1-w) f_n from the current iterate, S the interface law (kappa /
/// epsilon): the fibers held by the penalty to a fluid that does not change, `pull` = D^T S^-1 M v_f,
/// shape=(fiber nodes,6) [force]. With K_b + w c D^T S^-1 D inverted by K_b and S + w c D K_b^-1 D^T. Leaves the fibers
/// linearised at the solution. Returns false on all ranks when it does not converge. Collective.
bool solve_fibers(System& system, const std::vector<double>& pull);

/// change = (K_b + w c D^T S^-1 D)^-1 force, or K_b^-1 force without the penalty, in place, shape=(fiber nodes,6).
class FiberTangent {
 public:
  /// At the current iterate, which it linearises. `with_penalty`: keeps the penalty term. Collective.
  FiberTangent(System& system, bool with_penalty);
  /// False on all ranks when a block is singular.
  bool is_regular() const { return regular_; }
  /// Gaps of joints are closed on the way.
  void solve(std::vector<double>& force) const;

 private:
  System& system_;
  coupling::InterfaceOperator condensed_;
  bool with_penalty_, regular_ = true;
};

}  // namespace fbi::fsi
