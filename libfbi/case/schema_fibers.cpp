/// Tables of one entry of "fibers".
#include <numbers>
#include <optional>

#include "case/schema_tables.hpp"

namespace fbi::cases {

using namespace input;

namespace {

enum class Ends { none, start, end, both };

void describe_curve(Visitor& v, mesh::CurveParameters& p) {
  using mesh::CurveType;
  v.choice<CurveType>(
      field("type", "shape of the center line; nodes stand at equal distances along it").required("\"line\""), p.type,
      {{CurveType::line, "line", "straight, from `from` to `to`"},
       {CurveType::arc, "arc",
        "part of a circle or all of it: `from`, `center`, `normal` and `angle`, or `from`, `through` and `to`"},
       {CurveType::expression, "expression", "`position` as formulas of a parameter t between `begin` and `end`"},
       {CurveType::spline, "spline", "smooth (C2, natural cubic spline over the chords) through `points`"}});
  const bool line = p.type == CurveType::line, arc = p.type == CurveType::arc;
  const bool formulas = p.type == CurveType::expression, spline = p.type == CurveType::spline;
  const bool by_angle = v.given("center") || v.given("normal") || v.given("angle");
  p.through_points = arc && !by_angle;
  v.vector(field("from", "start of the fiber", "length").required("[0, 0, 0]").only("type", "line or arc", line || arc),
           p.from);
  v.vector(field("to", "end of the fiber", "length")
               .required("[0, 1, 0]")
               .only("type", "line, or arc given by \"through\"", line || p.through_points || !v.reading(),
                     arc ? "give either \"through\" and \"to\" or \"center\", \"normal\" and \"angle\"" : ""),
           p.to);
  v.vector(field("through", "a point of the arc between its ends", "length")
               .required("[0.7, 0.3, 0]")
               .only("type", "arc without \"center\"", p.through_points || !v.reading(),
                     arc ? "give either \"through\" and \"to\" or \"center\", \"normal\" and \"angle\"" : ""),
           p.through);
  const bool by_center = arc && by_angle;
  v.vector(field("center", "center of the circle; its radius is the distance to `from`", "length")
               .required("[0, 0, 0]")
               .only("type", "arc", by_center || !v.reading()),
           p.center);
  v.vector(field("normal", "axis of the circle, of any length; the arc turns about it by the right-hand rule")
               .required("[0, 0, 1]")
               .only("type", "arc", by_center || !v.reading()),
           p.normal);
  v.number(field("angle", "angle of the arc, at most a full circle: 2 pi", "rad")
               .required("\"pi/2\"")
               .only("type", "arc", by_center || !v.reading()),
           p.angle, between(-6.283185307179587, 6.283185307179587));
  v.formulas(field("position", "x, y, z as formulas of the parameter t, which must be smooth", "length")
                 .required("[\"cos(t)\", \"sin(t)\", \"t/10\"]")
                 .only("type", "expression", formulas),
             p.position);
  v.number(field("begin", "parameter t at the start").only("type", "expression", formulas), p.begin);
  v.number(field("end", "parameter t at the end").only("type", "expression", formulas), p.end);
  v.vectors(field("points", "points on the center line, from its start to its end", "length")
                .required("[[0, 0, 0], [0.5, 0.1, 0], [1, 0, 0]]")
                .only("type", "spline", spline),
            p.points);
  if (!v.reading() || v.failed("type")) return;
  if (by_center && !v.failed("angle") && v.given("angle") && p.angle == 0.0)
    v.error("angle", "must not be 0: the arc would have no length");
  if (formulas) {
    for (int i = 0; i < 3; ++i) {
      const std::string place = "position[" + std::to_string(i) + "]";
      if (!v.failed(place) && p.position[i].depends_on_space())
        v.error(place, "\"" + p.position[i].text() + "\": x, y and z are what it gives; write a formula of t alone");
    }
    if (!v.failed("begin") && !v.failed("end") && p.begin == p.end)
      v.error(v.given("end") ? "end" : "begin", "must differ from the other end of the range of t");
  }
  if (spline && v.given("points") && !v.failed("points")) {
    if (p.points.size() < 2) v.error("points", "needs at least 2 points, one for each end");
    for (std::size_t n = 1; n < p.points.size(); ++n)
      if (p.points[n] == p.points[n - 1])
        v.error("points[" + std::to_string(n) + "]", "is the same as the point before it; remove one");
  }
}

void describe_array(Visitor& v, mesh::ArrayParameters& p) {
  v.integers(field("counts", "number of fibers along x, y, z").required("[10, 1, 1]"), p.counts, at_least(1));
  v.vector(field("spacing", "distance between neighbors along x, y, z", "length").required("[0.1, 0, 0]"), p.spacing);
  if (!v.reading() || v.failed("counts") || v.failed("spacing") || !v.given("counts") || !v.given("spacing")) return;
  double total = 1.0;
  for (int i = 0; i < 3; ++i) {
    total *= p.counts[i];
    if (p.counts[i] > 1 && p.spacing[i] == 0.0) {
      v.error("spacing[" + std::to_string(i) + "]",
              "must not be 0: " + std::to_string(p.counts[i]) + " fibers of this direction would coincide");
    }
  }
  if (total > 1e8) v.error("counts", "more than 1e8 fibers");
}

void describe_section(Visitor& v, beam::Section& p, bool with_torsion) {
  v.number(field("radius", "radius a of a circular section: A = pi a^2, I = I2 = I3 = pi a^4/4, J = pi a^4/2", "length")
               .optional(),
           p.radius, positive());
  v.number(field("area", "area A, together with the other numbers of the section and instead of radius", "length^2")
               .optional(),
           p.area, positive());
  v.number(
      field("inertia", "second moment of area I, together with area; not for simo_reissner", "length^4").optional(),
      p.inertia, positive());
  v.number(field("inertia_2", "second moment of area about axis 2; only for simo_reissner", "length^4").optional(),
           p.inertia_2, positive());
  v.number(field("inertia_3", "second moment of area about axis 3; only for simo_reissner", "length^4").optional(),
           p.inertia_3, positive());
  v.number(field("torsion", "torsion constant J, GJ being the torsional stiffness; only for simo_reissner", "length^4")
               .optional(),
           p.torsion, positive());
  v.number(field("shear_correction",
                 "k of the shear stiffness k G A: 0.9 for round, 5/6 for rectangular sections; only for simo_reissner"),
           p.shear_correction, positive());
  v.vector(field("direction",
                 "axis 2 of the section at the start of the fiber, made normal to the tangent and carried along "
                 "without twist; matters for inertia_2 different from inertia_3; only for simo_reissner")
               .optional(),
           p.direction);
  if (!v.reading()) return;
  if (!with_torsion) {
    for (const char* key : {"inertia_2", "inertia_3", "torsion", "shear_correction", "direction"})
      if (v.given(key))
        v.error(key, "only for formulation simo_reissner; remove it or set \"formulation\": \"simo_reissner\"");
  } else if (v.given("inertia")) {
    v.error("inertia", "not for formulation simo_reissner; give \"inertia_2\" and \"inertia_3\" instead");
  }
  const std::vector<std::string> keys = with_torsion
                                            ? std::vector<std::string>{"area", "inertia_2", "inertia_3", "torsion"}
                                            : std::vector<std::string>{"area", "inertia"};
  std::string all, missing;
  std::size_t given = 0;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    all += (i == 0 ? "\"" : i + 1 < keys.size() ? ", \"" : " and \"") + keys[i] + "\"";
    if (v.given(keys[i]))
      ++given;
    else if (missing.empty())
      missing = keys[i];
  }
  const std::string choice = "give either \"radius\" or " + all;
  if (v.given("radius") && given > 0) {
    v.error("", "contradictory: " + choice);
  } else if (!v.given("radius") && !missing.empty()) {
    v.error("", "missing key \"" + (given == 0 ? "radius" : missing) + "\"; " + choice);
  } else if (v.given("radius")) {
    const double square = p.radius * p.radius;
    p.area = std::numbers::pi * square;
    p.inertia = p.inertia_2 = p.inertia_3 = 0.25 * std::numbers::pi * square * square;
    p.torsion = 2 * p.inertia;
    if (!v.failed("radius") && (p.inertia < 1e-300 || p.inertia > 1e300)) {
      v.error("radius", "is too small or too large: its second moment of area is no ordinary number");
    }
  }
}

void describe_material(Visitor& v, beam::Material& p, bool with_torsion, bool rigid) {
  v.number(
      field("young", "Young's modulus E", "force/area").required("1e7").only("formulation", "other than rigid", !rigid),
      p.young, positive());
  v.number(field("density", "density rho_b", "mass/length^3").required("10"), p.density, positive());
  double poisson = 0.0;
  v.number(field("poisson", "Poisson's ratio nu, G = E/(2 (1+nu)); only for simo_reissner").optional(), poisson,
           between(-0.999, 0.5));
  v.number(
      field("shear_modulus", "shear modulus G, instead of poisson; only for simo_reissner", "force/area").optional(),
      p.shear_modulus, positive());
  if (!v.reading()) return;
  const bool ratio = v.given("poisson"), modulus = v.given("shear_modulus");
  if (!with_torsion) {
    for (const char* key : {"poisson", "shear_modulus"})
      if (v.given(key))
        v.error(key, "only for formulation simo_reissner; remove it or set \"formulation\": \"simo_reissner\"");
  } else if (ratio == modulus) {
    v.error("", ratio ? "contradictory: give either \"poisson\" or \"shear_modulus\""
                      : "missing key \"poisson\"; give either \"poisson\" or \"shear_modulus\"");
  } else if (ratio) {
    p.shear_modulus = p.young / (2 * (1 + poisson));
  }
}

// "at" or "arc_length"; `kind` is "loaded" or "supported".
void describe_place(Visitor& v, beam::End& at, std::optional<double>& arc_length, const std::string& kind,
                    bool is_line) {
  Field end = field("at", "the " + kind + " end");
  Field arc =
      field("arc_length", "instead of at: the " + kind + " point, as reference arc length from the start", "length");
  if (kind == "loaded") {
    end.only("type", "force or moment", !is_line);
    arc.only("type", "force or moment", !is_line);
  }
  v.choice<beam::End>(end, at, {{beam::End::start, "start", ""}, {beam::End::end, "end", ""}});
  v.optional_number(arc, arc_length, at_least(0.0));
  if (v.reading() && v.given("at") && v.given("arc_length"))
    v.error("arc_length", "contradicts \"at\"; remove one of them");
}

void describe_load(Visitor& v, beam::Load& p) {
  v.choice<beam::LoadType>(field("type", "kind of load").required("\"force\""), p.type,
                           {{beam::LoadType::force, "force", "point force [force]"},
                            {beam::LoadType::moment, "moment", "point moment [force length]"},
                            {beam::LoadType::line, "line", "load per reference arc length [force/length]"}});
  describe_place(v, p.at, p.arc_length, "loaded", p.type == beam::LoadType::line);
  v.formulas(field("value",
                   "load as formulas of x, y, z, t at the reference position; statics multiply it by the load factor t")
                 .required("[0, 1, 0]"),
             p.value);
  v.flag(field("follower", "the load turns with the tangent, by the smallest rotations, as a pressure does"),
         p.follower);
}

void describe_support(Visitor& v, beam::Support& p) {
  describe_place(v, p.at, p.arc_length, "supported", false);
  p.type = beam::EndCondition::pinned;
  v.choice<beam::EndCondition>(
      field("type", "what is held").required("\"pinned\""), p.type,
      {{beam::EndCondition::pinned, "pinned", "the position"},
       {beam::EndCondition::clamped, "clamped", "position and direction"},
       {beam::EndCondition::guided, "guided", "direction, and position along it: free to move across"}});
  const bool clamped = p.type == beam::EndCondition::clamped;
  input::VectorExpression motion{}, direction{};
  v.formulas(field("motion", "displacement of the support as formulas of x, y, z, t, zero at t = 0", "length")
                 .optional()
                 .only("type", "pinned or clamped", p.type != beam::EndCondition::guided),
             motion);
  v.formulas(field("direction",
                   "direction of the held tangent as formulas of x, y, z, t, of any length; at t = 0 that "
                   "of the fiber")
                 .optional()
                 .only("type", "clamped", clamped),
             direction);
  if (v.given("motion")) p.motion = motion;
  if (v.given("direction")) p.direction = direction;
  if (v.reading() && !v.given("at") && !v.given("arc_length"))
    v.missing("at", "missing key \"at\": \"start\" or \"end\", or give \"arc_length\"");
}

void describe_damping(Visitor& v, beam::Damping& p) {
  v.number(field("mass", "a_M: force -a_M rho_b A v per length", "1/time"), p.mass, at_least(0.0));
  v.number(field("stiffness", "a_K: stresses a_K E times the strain rate (Kelvin-Voigt)", "time"), p.stiffness,
           at_least(0.0));
}

const std::vector<Option<Ends>> ends_options = {
    {Ends::start, "start", ""}, {Ends::end, "end", ""}, {Ends::both, "both", ""}};

bool has_start(Ends ends) { return ends == Ends::start || ends == Ends::both; }
bool has_end(Ends ends) { return ends == Ends::end || ends == Ends::both; }

}  // namespace

void describe_fiber_group(Visitor& v, FiberGroup& p) {
  beam::FiberParameters& physics = p.physics;
  v.text(
      field("name",
            "name of the fiber; those of an array are called name/I/J, zero-based, one index for each direction with "
            "several fibers")
          .required("\"patch\""),
      physics.name);
  v.object(field("curve", "center line of the fiber, or of the first one of an array")
               .required("{ \"type\": \"line\", \"from\": [0, 0, 0], \"to\": [0, 1, 0] }"),
           "Curve", [&](Visitor& inner) { describe_curve(inner, p.curve); });
  v.object(field("array", "copies of the fiber").optional(), "Array",
           [&](Visitor& inner) { describe_array(inner, p.array); });
  v.integer(field("elements", "beam elements of one fiber").required("3"), p.elements, at_least(1));
  v.choice<beam::Formulation>(
      field("formulation", "how the fiber moves"), physics.formulation,
      {{beam::Formulation::torsion_free, "torsion_free", "geometrically exact Kirchhoff beam without torsion"},
       {beam::Formulation::simo_reissner, "simo_reissner",
        "geometrically exact beam with shear, torsion and rotary inertia; may be curved at rest"},
       {beam::Formulation::rigid, "rigid", "moves as one body"},
       {beam::Formulation::prescribed, "prescribed", "moves as motion says; needs neither section nor material"},
       {beam::Formulation::fixed, "fixed", "does not move; needs neither section nor material"}});
  const bool prescribed = physics.formulation == beam::Formulation::prescribed;
  const bool moves = physics.formulation != beam::Formulation::fixed && !prescribed;  // has equations
  const bool rigid = physics.formulation == beam::Formulation::rigid;
  const bool torsion_free = physics.formulation == beam::Formulation::torsion_free;
  const std::string with_equations = "torsion_free, simo_reissner or rigid";
  const bool with_torsion = physics.formulation == beam::Formulation::simo_reissner;
  v.object(field("section", "cross-section; required unless formulation is fixed or prescribed").optional(), "Section",
           [&](Visitor& inner) { describe_section(inner, physics.section, with_torsion); });
  v.object(field("material", "linear elastic material; required unless formulation is fixed or prescribed").optional(),
           "Material", [&](Visitor& inner) { describe_material(inner, physics.material, with_torsion, rigid); });
  Ends clamped = Ends::none, pinned = Ends::none;
  v.choice<Ends>(
      field("clamped", "end where position and direction are held; a fiber without ends given is free").optional(),
      clamped, ends_options);
  v.choice<Ends>(field("pinned", "end where the position is held").optional(), pinned, ends_options);
  v.list_of(field("supports", "what else is held, and supports that move").only("formulation", with_equations, moves),
            "Support", physics.supports, describe_support);
  v.list_of(field("loads", "loads on each fiber").only("formulation", with_equations, moves), "Load", physics.loads,
            describe_load);
  v.object(field("damping", "viscous damping").optional().only("formulation", "torsion_free", torsion_free), "Damping",
           [&](Visitor& inner) { describe_damping(inner, physics.damping); });
  v.formulas(field("velocity", "velocity at t = 0 as formulas of x, y, z", "length/time")
                 .optional()
                 .only("formulation", with_equations, moves),
             physics.velocity);
  v.formulas(
      field("motion", "displacement of every point as formulas of its reference position x, y, z and of t", "length")
          .required("[0, \"0.1*sin(t)\", 0]")
          .only("formulation", "prescribed", prescribed),
      physics.motion);

  if (has_start(pinned)) physics.start = beam::EndCondition::pinned;
  if (has_end(pinned)) physics.end = beam::EndCondition::pinned;
  if (has_start(clamped)) physics.start = beam::EndCondition::clamped;
  if (has_end(clamped)) physics.end = beam::EndCondition::clamped;

  if (!v.reading()) return;
  if ((has_start(clamped) && has_start(pinned)) || (has_end(clamped) && has_end(pinned))) {
    v.error("pinned", std::string("contradicts \"clamped\": the ") +
                          (has_start(clamped) && has_start(pinned) ? "start" : "end") + " cannot be both; remove one");
  }
  for (const char* key : {"clamped", "pinned"})
    if (prescribed && v.given(key)) v.error(key, "a prescribed fiber moves as \"motion\" says; remove it");
  if (rigid && (physics.supports.size() + (physics.start != beam::EndCondition::free ? 1 : 0) +
                    (physics.end != beam::EndCondition::free ? 1 : 0) >
                1))
    v.error("formulation", "a rigid fiber takes one support at most; remove the others, or use torsion_free");
  for (std::size_t i = 0; with_torsion && i < physics.supports.size(); ++i)
    if (physics.supports[i].direction)
      v.error("supports[" + std::to_string(i) + "].direction",
              "not for formulation simo_reissner, whose clamps hold the section as it is; remove it");
  for (std::size_t i = 0; rigid && i < physics.supports.size(); ++i)
    if (physics.supports[i].direction)
      v.error("supports[" + std::to_string(i) + "].direction",
              "a rigid fiber cannot be turned by its support; use \"formulation\": \"prescribed\"");
  if (!v.failed("formulation") && physics.formulation == beam::Formulation::torsion_free &&
      p.curve.type == mesh::CurveType::arc && !v.failed("curve")) {
    v.error(v.given("formulation") ? "formulation" : "curve",
            "torsion_free needs a fiber that is straight at rest; set \"formulation\": \"simo_reissner\"");
  }
  if (!v.failed("formulation") && moves) {
    if (!v.given("section"))
      v.missing("section", "missing key \"section\"; add for example \"section\": { \"radius\": 0.01 }");
    if (!v.given("material")) {
      v.missing("material",
                "missing key \"material\"; add for example \"material\": { \"young\": 1e7, \"density\": 10 }");
    }
  }
  check_name(v, physics.name, "names become columns of tables and / counts the fibers of an array");
}

void check_name(Visitor& v, const std::string& name, const std::string& why) {
  if (!v.given("name") || v.failed("name")) return;
  if (name.empty()) {
    v.error("name", "must not be empty");
  } else if (name.find_first_of("/:,;#\"'\\\t\n\r") != std::string::npos) {
    v.error("name", "\"" + name + "\" must not hold any of / : , ; # quotes or backslashes: " + why);
  }
}

}  // namespace fbi::cases
