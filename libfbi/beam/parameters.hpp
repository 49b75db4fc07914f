/// Parameters of the fibers: section, material, formulation, ends, loads, time scheme. Free of PETSc and MPI.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/types.hpp"
#include "input/expression.hpp"

namespace fbi::beam {

enum class Formulation {
  torsion_free,   ///< geometrically exact Kirchhoff beam without torsion
  simo_reissner,  ///< geometrically exact beam with shear, torsion and rotary inertia; may be curved at rest
  rigid,          ///< moves as one body
  prescribed,     ///< moves as formulas say: no beam solve
  fixed           ///< does not move: no beam solve
};

/// Cross-section: circular, from its radius, or from its numbers. Axis 1 is the tangent, axes 2 and 3 span the section.
struct Section {
  double radius = 0.0;   ///< a [length]
  double area = 0.0;     ///< A [length^2]; pi a^2 when the radius is given
  double inertia = 0.0;  ///< I, second moment of area [length^4]; pi a^4/4 when the radius is given
  // for simo_reissner
  double inertia_2 = 0.0;         ///< I2 about axis 2 [length^4]; pi a^4/4 when the radius is given
  double inertia_3 = 0.0;         ///< I3 about axis 3 [length^4]; pi a^4/4 when the radius is given
  double torsion = 0.0;           ///< J, torsion constant [length^4]; pi a^4/2 when the radius is given
  double shear_correction = 0.9;  ///< k: shear stiffness k G A
  Vec3 direction = Vec3::Zero();  ///< axis 2 at the start, made normal to the tangent; zero: any
};

struct Material {
  double young = 0.0;          ///< E [force/area]
  double density = 0.0;        ///< rho_b [mass/length^3]
  double shear_modulus = 0.0;  ///< G [force/area], for simo_reissner; E/(2 (1+nu)) when nu is given
};

enum class EndCondition {
  free,
  pinned,  ///< position fixed
  guided,  ///< direction fixed as by `clamped`, position fixed along it: free to move across
  clamped  ///< position and tangent direction fixed (both tangent components normal to it; the stretch stays free)
};

/// Which end (or both) of a fiber.
enum class End { start, end };

enum class LoadType {
  force,   ///< point force [force]
  moment,  ///< point moment [force length]
  line     ///< line load per reference arc length [force/length]
};

/// What is held at an end or at another node of a fiber, and how that is moved. Formulas see the reference position.
struct Support {
  End at = End::start;
  std::optional<double> arc_length;  ///< instead of `at`: where a node lies, in reference arc length [length]
  EndCondition type = EndCondition::pinned;
  std::optional<input::VectorExpression> motion;     ///< displacement of the held position, pinned or clamped [length]
  std::optional<input::VectorExpression> direction;  ///< held direction (of any length), clamped
};

/// Viscous forces within a torsion-free fiber.
struct Damping {
  double mass = 0.0;       ///< a_M: force -a_M rho_b A v per length [1/time]
  double stiffness = 0.0;  ///< a_K: stresses a_K E times the strain rate (Kelvin-Voigt) [time]
};

/// A load; value(x, y, z, t) is evaluated at the reference position. In statics t runs from 0 to 1 and scales nothing
/// by itself: statics multiply every load by the load factor t.
struct Load {
  LoadType type = LoadType::force;
  End at = End::end;  ///< for force and moment
  input::VectorExpression value{};
  std::optional<double> arc_length;  ///< instead of `at`: any point of the fiber [length]
  bool follower = false;             ///< turns with the tangent: by the smallest rotations, step after step
};

/// Everything about one entry of "fibers" except its geometry.
struct FiberParameters {
  std::string name;
  Formulation formulation = Formulation::torsion_free;
  Section section;
  Material material;
  EndCondition start = EndCondition::free;
  EndCondition end = EndCondition::free;
  std::vector<Load> loads;
  std::vector<Support> supports{};     ///< besides `start` and `end`
  input::VectorExpression motion{};    ///< of a prescribed fiber: displacement of the reference position [length]
  input::VectorExpression velocity{};  ///< at t = 0 of a fiber that has equations [length/time]
  Damping damping{};
  double displaced_density = 0.0;  ///< of the fluid whose weight is taken off that of the fiber; 0: no buoyancy
};

enum class TimeScheme {
  generalized_alpha,
  midpoint,  ///< conserves energy and momentum of torsion-free fibers
  static_
};

struct BeamTimeParameters {
  TimeScheme scheme = TimeScheme::generalized_alpha;
  double rho_inf = 1.0;       ///< spectral radius at infinity, in [0, 1]
  double tolerance = 1e-10;   ///< Newton: residual relative to the largest force, for beam-only runs
  Index max_iterations = 30;  ///< Newton
};

}  // namespace fbi::beam
