/// Linear solves of the fluid with the multiplier term in single precision.
#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "coupling/coupling.hpp"
#include "coupling/interface_operator.hpp"
#include "fluid/fluid_field.hpp"
#include "fluid/single_tangent.hpp"
#include "fsi/pressure_convection.hpp"
#include "fsi/velocity_lines.hpp"
#include "linalg/minimal_residuals.hpp"
#include "linalg/multiplier_factor.hpp"
#include "linalg/pressure_solver.hpp"
#include "linalg/single_gmres.hpp"

namespace fbi::fsi {

/// What the preconditioner is made of; all of it belongs to FluidSolver.
struct SinglePreconditioner {
  linalg::PressureSolver* pressure = nullptr;
  double pressure_scale = 1.0;                       ///< p = pressure_scale P^-1 r_p + mass_scale r_p/V_a
  const std::vector<double>* mass_scale = nullptr;   ///< shape=(owned nodes)
  double continuity_scale = 1.0;                     ///< of the continuity rows
  const std::vector<double>* weight = nullptr;       ///< W, shape=(local nodes,3); null: V of the lines in its place
  const VelocityLines* lines = nullptr;              ///< beside W: V before every other sweep with W
  const linalg::MultiplierFactor* factor = nullptr;  ///< of S + M W M^T; without W of an earlier one with V's diagonal
};

/// FGMRES on (A_FF + M^T S^-1 M) x = b with the block-triangular preconditioner
///   p = P^-1 r_p,  u = (W^-1 + M^T S^-1 M)^-1 (r_u - G p),
/// everything in floats but the multipliers. V of VelocityLines may stand for W: then T = S + M V M^T is no small
/// matrix, and T lambda = M V (r_u - G p) is solved by a few steps of minimal residuals with the factor's T^-1.
/// G p is a part of both the preconditioner and the product, so that an iteration costs one pass over the velocity
/// columns and one over the (cheap) pressure columns. Where tight tolerances, fast or viscous flow make many
/// iterations, the velocity block is followed by more of them, with minimal residuals between them (a preconditioner
/// that varies, which FGMRES allows), and p has convection as well. Sweeps with W are better with V between them:
///   u = (W^-1 + B)^-1 (r + (W^-1 - A_uu) V r),  B = M^T S^-1 M,
/// is what a sweep with B alone has left after V r, without the large forces of B on V r.
///
/// Where viscosity is large, p knows of the fibers. With them the Schur complement is Z + E' T^-1 E, Z what P stands
/// for, E = M V G and E' = D V M^T, so that its inverse is, to first order in what fibers take from the pressure's,
///   p = p_0 - 1.4 Z^-1 E' T^-1 E p_0,  p_0 = Z^-1 r_p.
///
/// Rows and columns of unknowns that are not free are left out: b is zero there, and so is x.
class SingleSolver {
 public:
  /// How far the preconditioner solves its equations in every iteration: more makes fewer, longer iterations.
  struct Effort {
    int sweeps = 1;           ///< of the velocity block, at most
    bool convection = false;  ///< p = pressure_scale P^-1 r_p + (0.35 C P^-1 r_p + mass_scale r_p)/V_a
    bool fibers = false;      ///< p has a part of the fibers as well, where there are lines
    bool impatient = false;   ///< of SingleGmres: the caller has another way
  };

  /// `coupling` and `interface` are null without fibers. Collective.
  SingleSolver(fluid::FluidField& fluid, fluid::SingleTangent& tangent, const coupling::Coupling* coupling,
               const coupling::InterfaceOperator* interface, int restart);

  /// The weights of the next solves. The tangent is that of the object given above.
  void prepare(const SinglePreconditioner& preconditioner);
  /// Takes the parts along the normals of slip walls out of the first `nodes` nodes.
  void remove_normal(float* values, Index nodes) const { tangent_.remove_normal(values, nodes); }
  /// Steps for the multipliers of lines since the last reset, and how often they were solved for.
  struct MultiplierSteps {
    int steps = 0, solves = 0;
    double mean() const { return solves > 0 ? static_cast<double>(steps) / solves : 0.0; }
  };
  const MultiplierSteps& multiplier_steps() const { return multiplier_steps_; }
  void reset_multiplier_steps() { multiplier_steps_ = {}; }
  /// b: shape=(owned nodes,4) in scaled continuity rows, overwritten. x likewise. Collective.
  linalg::KrylovResult solve(float* b, float* x, double tolerance, int maximum, const Effort& effort);

 private:
  void step(const float* v, float factor, float* z, float* w);
  void velocity_block(const float* v, float factor, const float* gradient, float* velocity);
  void line_block(const float* v, float factor, const float* gradient, float* velocity);
  /// velocity -= V M^T lambda with T lambda = M velocity, about. Collective.
  void add_constraint(float* velocity);
  /// x = V r with ghosts, zero where the velocity is given; r likewise. Fourth entries stay. Collective.
  void apply_lines(float* r, float* x, const std::vector<char>* only = nullptr);
  void find_touched();
  void find_reached();
  /// product += M^T S^-1 M z; with lines alone z is what velocity_block gave.
  void add_multipliers(const float* z, float* product);
  void apply_velocity(const float* z, float* w);
  /// velocity_block after a step with V alone; w and the fourth entries of z, shape=(nodes,4), are zero before and
  /// after. Collective.
  void smoothed_block(const float* r, float* z, float* w);
  /// The part of fibers in the fourth entries of z, whose G p is w; w becomes that of the sum. Overwrites rows_.
  /// Collective.
  void add_fibers(float* z, float* w);
  bool has_lines_alone() const { return parts_.weight == nullptr; }
  /// Fourth entries of z for right_; uses w, shape=(nodes,4). Collective.
  void solve_pressure(float* z, float* w);
  /// Minimal residuals with the velocity block on A_uu u = rest_: adds u to z, its product to w, and takes the latter
  /// from the velocities of rest_. The fourth entries of u are zero.
  void sweep(float* z, float* w);
  bool has_multipliers() const { return coupling_ != nullptr && coupling_->global_rows() > 0; }

  fluid::FluidField& fluid_;
  fluid::SingleTangent& tangent_;
  const coupling::Coupling* coupling_;
  const coupling::InterfaceOperator* interface_;
  SinglePreconditioner parts_;
  std::size_t owned_, nodes_;            ///< nodes: owned, local
  std::vector<float> weight_;            ///< W for the four unknowns of a node, 0 for the pressure, shape=(nodes,4)
  std::vector<float> mass_;              ///< mass_scale/V_a, shape=(owned nodes)
  std::vector<float> force_;             ///< M^T of multipliers, zero between uses, shape=(nodes,4)
  std::vector<Index> touched_;           ///< owned nodes where it may not be zero
  std::vector<float> right_, solution_;  ///< of the pressure, shape=(owned nodes)
  std::vector<double> rows_;             ///< shape=(rows,3); with lines alone S^-1 M of the last velocity block
  std::vector<std::size_t> given_;       ///< given velocities of owned nodes
  std::vector<float> line_right_;        ///< shape=(owned nodes,4)
  struct Direction {
    std::vector<double> multipliers;  ///< z, shape=(rows,3)
    std::vector<float> velocity;      ///< V M^T z, shape=(nodes,4)
  };
  linalg::MinimalResiduals residuals_;
  MultiplierSteps multiplier_steps_;
  std::vector<Direction> directions_;                               ///< of the multipliers, as many as were needed
  int reached_version_ = -1;                                        ///< of the lines of reached_
  std::vector<char> reached_;                                       ///< lines that forces of multipliers reach
  std::vector<std::pair<std::size_t, std::size_t>> reached_nodes_;  ///< [first, end) of their nodes and ghosts
  std::vector<std::size_t> reached_given_;                          ///< of given_
  std::vector<double> law_;                                         ///< S z, shape=(rows,3)
  struct Sweep {
    std::vector<float> z, w;  ///< a direction and its product, shape=(nodes,4)
    double squared_norm = 0.0;
  };
  Effort effort_;
  std::unique_ptr<PressureConvection> convection_;  ///< null until needed
  std::vector<Sweep> sweeps_;                       ///< as many as were needed
  std::vector<float> rest_;                         ///< what the velocities leave, shape=(owned nodes,4)
  std::vector<float> first_pressure_;               ///< p_0, shape=(owned nodes)
  std::vector<float> answer_;                       ///< velocities of forces of fibers, shape=(nodes,4)
  linalg::SingleGmres krylov_;
};

}  // namespace fbi::fsi
