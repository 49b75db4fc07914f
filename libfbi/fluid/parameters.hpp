/// Parameters of the fluid: material, stabilisation, boundary conditions, time scheme. Free of PETSc and MPI.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>

#include "base/types.hpp"
#include "input/expression.hpp"

namespace fbi::fluid {

enum class ConvectiveForm { advective, conservative, skew, none };
enum class ViscousResidual { full, none };
enum class Tau { franca_valentin, whiting_jansen, taylor_hughes_zarins };
enum class TauAt { center, quadrature_points };
enum class TauUpdate { step, iteration };
enum class PressureStabilization { pspg, projection };

struct FluidParameters {
  double density = 1.0;    ///< rho [mass/length^3]
  double viscosity = 1.0;  ///< dynamic viscosity mu [mass/(length time)]
  ConvectiveForm convective_form = ConvectiveForm::advective;
  ViscousResidual viscous_residual = ViscousResidual::full;
  Tau tau = Tau::franca_valentin;
  bool tau_time = true;  ///< time-step term in tau_M
  bool grad_div = true;  ///< tau_C term
  TauAt tau_at = TauAt::center;
  TauUpdate tau_update = TauUpdate::step;  ///< from the extrapolated velocity, or from every iterate
  PressureStabilization pressure_stabilization = PressureStabilization::pspg;
  input::VectorExpression body_force{};        ///< b [length/time^2], an acceleration: the force is rho b
  input::VectorExpression initial_velocity{};  ///< v(t=0) [length/time]
  bool project_initial_velocity = false;       ///< make v(t=0) divergence-free in the weak sense
};

enum class BoundaryType {
  inflow,    ///< all velocity components given
  no_slip,   ///< zero velocity
  slip,      ///< zero normal velocity, zero tangential traction
  outflow,   ///< zero traction; optional backflow stabilisation
  traction,  ///< traction given; optional backflow stabilisation
  pressure,  ///< traction -p n of a given pressure; optional backflow stabilisation
  mixed,     ///< some velocity components given, traction on the others
  periodic   ///< the same flow as on the face `with`, by translation
};

/// Condition on one named face set.
struct BoundaryCondition {
  BoundaryType type = BoundaryType::no_slip;
  /// Prescribed velocity per component [length/time]; for `mixed` a missing component carries the traction instead.
  std::array<std::optional<input::Expression>, 3> velocity{};
  input::VectorExpression traction{};  ///< h [force/area], for `traction` and the free components of `mixed`
  input::Expression pressure{};        ///< p [force/area], for `pressure`
  bool backflow = false;               ///< adds -beta rho min(v.n,0) (w,v) on the face
  double backflow_beta = 0.5;          ///< in [0.5, 1]
  std::string with{};                  ///< for `periodic`: the other face
};

using BoundaryConditions = std::map<std::string, BoundaryCondition>;  ///< by face-set name

enum class TimeScheme { one_step_theta, bdf2, steady };

struct FluidTimeParameters {
  TimeScheme scheme = TimeScheme::one_step_theta;
  double theta = 1.0;  ///< in [0.5, 1], of one_step_theta
};

/// How the convecting velocity a of rho (a.grad) v, of SUPG and of the backflow terms enters the equations of a step.
enum class Linearization {
  newton,       ///< a = v, with its derivative in the tangent
  picard,       ///< a = v, without it
  extrapolated  ///< a from earlier steps, second order: the equations of a step are linear
};

}  // namespace fbi::fluid
