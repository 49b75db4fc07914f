/// One pass through both fields as a map of the interaction force onto itself.
#pragma once

#include <memory>
#include <vector>

#include "fsi/fiber_solve.hpp"
#include "fsi/monolithic.hpp"
#include "fsi/system.hpp"

namespace fbi::fsi {

/// x -> H(x): fibers under x, their velocity D v_b to the fluid, lambda = S^-1 (M v_f - D v_b) of the fluid (Hagemeyer,
/// Mayr, Popp 2024, eqs. 13 and 14). x = D^T lambda; with the penalty implicit x = D^T S^-1 M v_f, and the fibers keep
/// -D^T S^-1 D v_b in their own equations. H(x) - x is a force in both cases, shape=(fiber nodes,6).
class InterfaceMap {
 public:
  /// For the step to `time` that begin_step was called for. Counts what it does in `report`. Collective.
  InterfaceMap(System& system, StepReport& report, double time, double dt);

  /// The x of the force predicted in time. Empty on all ranks when a field could not be solved. Collective.
  std::vector<double> predict();
  /// h = H(x), with all nonlinearities; leaves the fields at this x. False when a field did not converge. Collective.
  bool evaluate(const std::vector<double>& x, std::vector<double>& h);
  /// h = H(x) near the x of the last evaluate(), with the fields linearised there or solved again; leaves the fields of
  /// the fluid as they were. False when a field did not converge. Collective.
  bool difference(const std::vector<double>& x, std::vector<double>& h);

  /// D^T lambda of the last evaluate(): 2-norm. Collective.
  double force_norm() const;
  /// Relative residual the fluid started the step with.
  double fluid_reference() const { return fluid_reference_; }

 private:
  bool solve_fields(const std::vector<double>& x, std::vector<double>& h, double& reference,
                    const FluidTolerance& tolerance);
  bool linearized(const std::vector<double>& x, std::vector<double>& h);
  bool nonlinear(const std::vector<double>& x, std::vector<double>& h);

  System& system_;
  StepReport& report_;
  double time_, dt_;
  bool implicit_, geometry_changed_ = true;
  double fluid_reference_ = 0.0;
  double share_ = 1.0;  // change of force over change of pull in the last linear difference
  std::vector<double> lambda_;
  std::vector<double> x_, h_;              // of the last evaluate()
  std::unique_ptr<FiberTangent> tangent_;  // at the fields of the last evaluate(), null: not made yet
  linalg::VecHandle right_, change_, fluid_;
};

}  // namespace fbi::fsi
