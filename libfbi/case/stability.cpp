#include "case/stability.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/log.hpp"

namespace fbi::cases {
namespace {

// Limits, from the maps of docs/stability.md.
constexpr double stiff = 0.1, flexible = 100.0;                        // Cauchy numbers
constexpr double motion_of_others = 0.2, motion_in_fast_change = 0.1;  // U dt/L
constexpr double motion_of_flexible = 0.004;                           // U dt/L for each element of the fiber
constexpr double reversal = 0.3;                                       // change of the velocity in a step
constexpr double damping = 0.5;                                        // rho_inf
constexpr double slow_alternation = -0.95;
// Of relaxation times iteration factor: errors grow beyond 2, and the added mass may be 3.1 times the estimate below.
constexpr double most_constant = 2.0 / 3.1;
constexpr double most_aitken = 60.0, most_iqn_ils = 6000.0;
// Change of the velocity in a step, for rho_inf above 0.5, and for 0.1 to 0.5.
constexpr double fast_change = 0.06, fast_change_when_damped = 0.12, much_damping = 0.1;
constexpr double small_cfl = 0.01;
/// Mass of the fluid that a thin fiber drags along on a mesh, over rho h^2, h the cube root of the smallest cell: from
/// 0.38 on lines of nodes to 3.1 amid cells.
constexpr double mesh_added_mass = 1.0;

double section_area(const beam::Section& section) {
  return section.area > 0.0 ? section.area : std::numbers::pi * section.radius * section.radius;
}

bool moves(const FiberGroup& group) {
  return group.physics.formulation != beam::Formulation::fixed &&
         group.physics.formulation != beam::Formulation::prescribed;
}

/// Smallest mass per length of the fibers that move; 0: there are none.
double lightest_fiber(const CaseParameters& parameters) {
  double lightest = 0.0;
  for (const FiberGroup& group : parameters.fibers) {
    const double mass = group.physics.material.density * section_area(group.physics.section);
    if (moves(group) && (lightest == 0.0 || mass < lightest)) lightest = mass;
  }
  return lightest;
}

Index fewest_elements(const CaseParameters& parameters) {
  Index fewest = 0;
  for (const FiberGroup& group : parameters.fibers)
    if (moves(group) && (fewest == 0 || group.elements < fewest)) fewest = group.elements;
  return fewest;
}

}  // namespace

double alternation_factor(double penalty, double fluid, double fiber, double step, double weight, double theta) {
  return (1.0 / penalty - (1.0 - theta) * step / fluid - (1.0 - weight) * step / fiber) /
         (1.0 / penalty + theta * step / fluid + weight * step / fiber);
}

double iteration_factor(double penalty, double fluid, double fiber, double step, double weight, double theta) {
  return weight * step / fiber / (1.0 / penalty + theta * step / fluid);
}

StabilityNumbers stability_numbers(const Setup& setup, const Scene& scene) {
  StabilityNumbers numbers;
  const CaseParameters& parameters = setup.parameters;
  const double dt = setup.dt;
  if (setup.fluid == nullptr || !(dt > 0.0)) return numbers;
  numbers.cfl = scene.speed * dt / scene.smallest_cell;
  if (scene.speed > 0.0) numbers.change = scene.speed_change / scene.speed;
  const input::VectorExpression& initial = parameters.fluid->initial_velocity;
  const bool given = std::any_of(initial.begin(), initial.end(), [](const auto& v) { return !v.is_zero(); });
  numbers.sudden = !given && scene.start_speed > 0.0;
  const double mass = lightest_fiber(parameters);
  if (!setup.system->is_coupled() || !(mass > 0.0) || !(scene.fiber_length > 0.0)) return numbers;
  if (scene.stiffness > 0.0) {
    numbers.motion = scene.speed * dt / scene.fiber_length;
    numbers.elements = fewest_elements(parameters);
    numbers.cauchy = 0.5 * parameters.fluid->density * scene.speed * scene.speed * 2.0 * scene.largest_radius *
                     std::pow(scene.fiber_length, 3) / scene.stiffness;
  }
  const bool is_theta = parameters.fluid_time.scheme == fluid::TimeScheme::one_step_theta;
  const double theta = is_theta ? parameters.fluid_time.theta : 1.0;
  const double weight =
      parameters.scheme.coupling_weight == fsi::CouplingWeight::theta ? theta : 1.0 - setup.beams->alpha_f();
  const double added = mesh_added_mass * parameters.fluid->density * scene.smallest_cell * scene.smallest_cell;
  const double penalty =
      parameters.coupling.automatic ? std::numeric_limits<double>::infinity() : parameters.coupling.penalty;
  numbers.alternation = alternation_factor(penalty, added, mass, dt, weight, theta);
  if (parameters.scheme.scheme != fsi::Scheme::monolithic && !parameters.scheme.implicit_penalty &&
      parameters.scheme.direction == fsi::Direction::two_way)
    numbers.iteration = iteration_factor(penalty, added, mass, dt, weight, theta);
  return numbers;
}

std::vector<std::string> stability_warnings(const StabilityNumbers& numbers, const CaseParameters& parameters) {
  std::vector<std::string> warnings;
  const beam::BeamTimeParameters& beam = parameters.beam_time;
  const bool damped = beam.scheme == beam::TimeScheme::generalized_alpha && beam.rho_inf <= damping;
  const double usual = numbers.change > reversal ? motion_in_fast_change : motion_of_others;
  const double slim = std::min(usual, motion_of_flexible * static_cast<double>(numbers.elements));
  if (numbers.cauchy > flexible && numbers.motion > slim)
    warnings.push_back(log::format(
        "the fluid moves by up to %.2g fiber lengths in a step; fibers as flexible as these (Cauchy number %.3g) were "
        "unstable above %.2g with %lld elements; take smaller steps or more elements (docs/stability.md)",
        numbers.motion, numbers.cauchy, slim, static_cast<long long>(numbers.elements)));
  else if (numbers.cauchy > stiff && numbers.cauchy <= flexible && numbers.motion > usual && !damped)
    warnings.push_back(
        log::format("the fluid moves by up to %.2g fiber lengths in a step; with little damping fibers were unstable "
                    "above %.2g; take "
                    "smaller steps, or set \"rho_inf\" of time.beam to %g (docs/stability.md)",
                    numbers.motion, usual, damping));
  if (numbers.alternation < slow_alternation)
    warnings.push_back(log::format(
        "coupling forces that alternate from step to step lose only %.2g %% a step (fibers lighter than the fluid they "
        "move, \"theta\" %g, weight of the new force below one); use \"theta\": 1 with \"coupling_weight\": \"theta\" "
        "(docs/stability.md)",
        100.0 * (1.0 + numbers.alternation), parameters.fluid_time.theta));
  const fsi::SchemeParameters& scheme = parameters.scheme;
  const double most_iteration = scheme.scheme == fsi::Scheme::constant  ? most_constant / scheme.relaxation
                                : scheme.scheme == fsi::Scheme::aitken  ? most_aitken
                                : scheme.scheme == fsi::Scheme::iqn_ils ? most_iqn_ils
                                                                        : std::numeric_limits<double>::infinity();
  if (numbers.iteration > most_iteration)
    warnings.push_back(log::format(
        "fluid and fibers are solved in turns, and without relaxation an error of the force grows %.3g times in each "
        "turn (light fibers, large penalty); the scheme did not converge above about %.3g; use \"monolithic\" or "
        "\"newton_krylov\" for coupling.scheme (docs/stability.md)",
        numbers.iteration, most_iteration));
  const double most_change = damped ? fast_change_when_damped : fast_change;
  const bool strongly_damped = damped && beam.rho_inf < much_damping;
  if (parameters.solver.nonlinear == fluid::Linearization::extrapolated && numbers.motion > 0.0 && !strongly_damped &&
      numbers.change > most_change)
    warnings.push_back(log::format(
        "the prescribed velocity changes by up to %.0f %% of its largest value in a step; with \"nonlinear\": "
        "\"linearized\" fibers were unstable above %.0f %%; take smaller steps, set \"rho_inf\" of time.beam to 0 or "
        "use "
        "\"newton\" (docs/stability.md)",
        100.0 * numbers.change, 100.0 * most_change));
  if (numbers.sudden && numbers.cfl > 0.0 && numbers.cfl < small_cfl && parameters.fluid->tau_time &&
      parameters.fluid->pressure_stabilization == fluid::PressureStabilization::pspg)
    warnings.push_back(
        log::format("the flow starts suddenly and the time step is small (CFL %.2g, below %g): with PSPG the pressure "
                    "is rough; take "
                    "larger steps or let the inflow begin from rest (docs/stability.md)",
                    numbers.cfl, small_cfl));
  return warnings;
}

}  // namespace fbi::cases
