#include "case/schema.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "base/error.hpp"
#include "base/log.hpp"
#include "case/schema_tables.hpp"
#include "input/float_traps.hpp"
#include "input/reader.hpp"
#include "input/reference_writer.hpp"
#include "input/schema_writer.hpp"
#include "input/suggest.hpp"

namespace fbi::cases {

using namespace input;

namespace {

bool can_turn(beam::EndCondition end) { return end == beam::EndCondition::free || end == beam::EndCondition::pinned; }

bool is_moving(const FiberGroup& group) { return group.physics.formulation != beam::Formulation::fixed; }
bool has_equations(const FiberGroup& group) {
  return is_moving(group) && group.physics.formulation != beam::Formulation::prescribed;
}

void check_parts(Visitor& v, const CaseParameters& p) {
  const bool fibers = !p.fibers.empty() || v.failed("fibers");
  const bool fluid = v.given("fluid");
  const bool channel = v.given("channel"), mesh = v.given("mesh");
  const bool place = channel || mesh;
  if (fluid && !place) v.missing("channel", "missing key \"channel\": the fluid needs a place to be");
  if (channel && mesh) v.error("mesh", "contradicts \"channel\": the fluid fills one of them; remove the other");
  if (!fluid && place) {
    v.missing("fluid", std::string("missing key \"fluid\": the ") + (channel ? "channel" : "mesh") +
                           " is empty; add \"fluid\": { \"density\": ..., \"viscosity\": ... }");
  }
  if (!fluid && !place && !fibers)
    v.error("", "nothing to compute: give \"fluid\" and \"channel\", \"fibers\", or all");
  const auto useless = [&](const char* path, const char* needs) {
    if (v.given(path)) v.error(path, std::string("has no effect without ") + needs + "; remove it");
  };
  if (!fluid && !place) {
    useless("coupling", "fluid");
    useless("time.fluid", "fluid");
    useless("solver", "fluid");
  }
  if (!fluid) useless("buoyancy", "fluid");
  if (fluid && fibers && p.gravity.squaredNorm() > 0.0 && !v.given("buoyancy") && !v.failed("buoyancy")) {
    v.missing(
        "buoyancy",
        "missing key \"buoyancy\": with a fluid, say true (fibers weigh (rho_b - rho_f) g A, as bodies in a fluid "
        "at rest do) or false (rho_b g A)");
  }
  if (!fibers) {
    useless("buoyancy", "fibers");
    useless("coupling", "fibers");
    useless("time.beam", "fibers");
    useless("joints", "fibers");
    useless("gravity", "fibers (the fluid takes \"body_force\")");
  }
  if (!fluid && !p.fibers.empty() && std::none_of(p.fibers.begin(), p.fibers.end(), has_equations)) {
    v.error("fibers", "nothing to compute: there is no fluid and every fiber is fixed or prescribed");
  }
  for (std::size_t i = 0; i < p.fibers.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      if (p.fibers[i].physics.name != p.fibers[j].physics.name || p.fibers[i].physics.name.empty()) continue;
      v.error("fibers[" + std::to_string(i) + "].name", "\"" + p.fibers[i].physics.name +
                                                            "\" is already the name of fibers[" + std::to_string(j) +
                                                            "]; names must differ");
      break;
    }
  }
  for (std::size_t i = 0; i < p.output.probes.size(); ++i) {
    const std::string path = "output.probes[" + std::to_string(i) + "]";
    if (v.given(path + ".point") && !fluid) v.error(path + ".point", "there is no fluid to observe; remove the probe");
    if (v.given(path + ".fiber") && !fibers)
      v.error(path + ".fiber", "there are no fibers to observe; remove the probe");
  }
  if (p.output.averages && !fluid) v.error("output.averages", "there is no fluid to take means of; remove it");
  for (std::size_t i = 0; i < p.output.forces.size(); ++i) {
    const std::string path = "output.forces[" + std::to_string(i) + "]";
    if (!fluid) v.error(path, "there is no fluid to exert a force; remove it");
    for (std::size_t j = 0; j < i; ++j)
      if (p.output.forces[i].name == p.output.forces[j].name && !p.output.forces[i].name.empty()) {
        v.error(path + ".name", "\"" + p.output.forces[i].name + "\" is already the name of output.forces[" +
                                    std::to_string(j) + "]; names must differ");
        break;
      }
    if (!p.channel && !p.mesh) continue;
    std::vector<std::string> known;
    for (const auto& [name, condition] : p.channel ? p.channel->boundaries : p.mesh->boundaries) known.push_back(name);
    for (std::size_t j = 0; j < p.output.forces[i].faces.size(); ++j) {
      const std::string& face = p.output.forces[i].faces[j];
      if (std::find(known.begin(), known.end(), face) == known.end())
        v.error(path + ".faces[" + std::to_string(j) + "]",
                "there is no face \"" + face + "\"" + did_you_mean(face, known));
    }
  }
}

/// Which time scheme needs which of "step" and "end", and that both fields agree about time.
void check_time(Visitor& v, CaseParameters& p) {
  const bool moving = std::any_of(p.fibers.begin(), p.fibers.end(), is_moving);
  const bool static_fibers = moving && p.beam_time.scheme == beam::TimeScheme::static_;
  const bool dynamic_fibers = moving && !static_fibers;
  const bool steady = p.fluid && p.fluid_time.scheme == fluid::TimeScheme::steady;
  const bool unsteady = p.fluid && !steady;
  if (steady && moving) {
    v.error("time.fluid.scheme",
            "steady flow does not go with fibers that move; set \"formulation\": \"fixed\" for every fiber, or use "
            "\"one_step_theta\"");
    return;
  }
  if (steady && p.output.averages)
    v.error("output.averages", "steady flow has no means over time; remove it");
  if (steady && p.scheme.direction != fsi::Direction::two_way)
    v.error("coupling.direction", "steady flow goes with two_way only; remove it");
  if (unsteady && static_fibers) {
    v.error("time.beam.scheme", "static goes with fibers alone, without fluid; use \"generalized_alpha\"");
    return;
  }
  if (v.failed("time.step") || v.failed("time.end") || v.failed("time.fluid") || v.failed("time.beam")) return;
  if (unsteady || dynamic_fibers) {
    if (!v.given("time")) {
      v.missing("time", "missing key \"time\"; add for example \"time\": { \"step\": 1e-3, \"end\": 1 }");
      return;
    }
    if (!v.given("time.step")) v.error("time", "missing key \"step\", the time step; add for example \"step\": 1e-3");
    if (!v.given("time.end")) v.error("time", "missing key \"end\", the end time; add for example \"end\": 1");
  } else if (static_fibers) {
    if (!v.given("time.end")) p.time.end = 1.0;
    if (!v.given("time.step")) p.time.step = p.time.end;
  }
  if (p.time.step > 0.0 && p.time.end > 0.0) {
    const double steps = p.time.end / p.time.step;
    const double whole = std::max(1.0, std::round(steps));
    if (std::abs(steps - whole) > 1e-6 * whole) {
      v.error("time.end", "must be a whole number of steps, not " + log::format("%.6g", steps) + "; use for example " +
                              log::format("%.6g", whole * p.time.step));
    } else if (whole > 2e9) {
      v.error("time.step", "makes more than 2e9 steps");
    }
  }
  for (std::size_t i = 0; i < p.expect.size(); ++i) {
    if (p.expect[i].time && p.time.end > 0.0 && *p.expect[i].time > p.time.end * (1 + 1e-9)) {
      v.error("expect[" + std::to_string(i) + "].time", "lies after the end time " + number_text(p.time.end));
    }
  }
  if (p.output.averages && p.time.end > 0.0 && p.output.averages->from >= p.time.end * (1 - 1e-9))
    v.error("output.averages.from",
            "no step begins that late: the end time is " + number_text(p.time.end) + "; use an earlier time");
  if (!static_fibers) return;
  for (std::size_t i = 0; i < p.fibers.size(); ++i) {
    const beam::FiberParameters& fiber = p.fibers[i].physics;
    if (fiber.formulation == beam::Formulation::rigid) {
      v.error("fibers[" + std::to_string(i) + "].formulation",
              "rigid fibers have no statics; set \"scheme\": \"generalized_alpha\" for time.beam");
      continue;
    }
    if (!p.joints.empty()) continue;  // another fiber may hold it
    if (fiber.start == beam::EndCondition::free && fiber.end == beam::EndCondition::free && fiber.supports.empty() &&
        has_equations(p.fibers[i])) {
      v.error("fibers[" + std::to_string(i) + "]",
              "a free fiber has no static equilibrium; add for example \"clamped\": \"start\"");
    } else if (fiber.formulation == beam::Formulation::simo_reissner && can_turn(fiber.start) && can_turn(fiber.end) &&
               std::all_of(fiber.supports.begin(), fiber.supports.end(),
                           [](const beam::Support& support) { return can_turn(support.type); })) {
      v.error("fibers[" + std::to_string(i) + "]",
              "a fiber with torsion that is pinned or free at both ends can turn about its axis: it has no static "
              "equilibrium; use for example \"clamped\": \"start\"");
    }
  }
}

/// Fibers that cannot have joints, where they are named.
void check_joints(Visitor& v, const CaseParameters& p) {
  for (std::size_t i = 0; i < p.joints.size(); ++i)
    for (std::size_t side = 0; side < 2; ++side) {
      const std::string& name = p.joints[i].fiber[side];
      for (const FiberGroup& group : p.fibers) {
        const beam::Formulation formulation = group.physics.formulation;
        if (name.substr(0, name.find('/')) != group.physics.name ||
            (formulation != beam::Formulation::rigid && formulation != beam::Formulation::prescribed))
          continue;
        v.error("joints[" + std::to_string(i) + (side == 0 ? "].a" : "].b"),
                "fiber \"" + name + "\" is " + (formulation == beam::Formulation::rigid ? "rigid" : "prescribed") +
                    "; joints go with the formulations torsion_free, simo_reissner and fixed");
      }
    }
}

/// Options of different objects that exclude each other.
void check_nonlinear(Visitor& v, const CaseParameters& p) {
  const bool steady = p.fluid && p.fluid_time.scheme == fluid::TimeScheme::steady;
  const bool linearized = p.solver.nonlinear == fluid::Linearization::extrapolated;
  if (linearized && steady)
    v.error("solver.nonlinear", "linearized needs earlier steps, steady flow has none; use \"newton\" or \"picard\"");
  if (linearized && p.scheme.scheme == fsi::Scheme::monolithic &&
      p.scheme.geometry_update == fsi::GeometryUpdate::iterated)
    v.error(
        "solver.nonlinear",
        "linearized solves once a step, so that \"iterated\" geometry has nothing to follow; use \"geometry_update\": "
        "\"lagged\" in \"coupling\", or \"newton\"");
  if (linearized && p.fluid && p.fluid->tau_update == fluid::TauUpdate::iteration)
    v.error("solver.nonlinear",
            "linearized has no iterates that \"tau_update\": \"iteration\" could follow; use \"step\"");
  if (p.time.steady_tolerance > 0.0 && (steady || !v.given("fluid")))
    v.error("time.steady_tolerance", steady ? "steady flow has no rate of change; remove it, or use another scheme"
                                            : "needs a fluid; remove it");
}

/// What the fiber's own radius needs.
void check_coupling(Visitor& v, const CaseParameters& p) {
  if (!p.coupling.automatic) return;
  if (p.coupling.kernel != coupling::Operator::ring)
    v.error("coupling.penalty",
            "\"auto\" keeps the radius of a fiber by averaging over a ring; add \"operator\": \"ring\", or give a "
            "number");
  if (p.fluid && p.fluid->pressure_stabilization != fluid::PressureStabilization::pspg)
    v.error("coupling.penalty",
            "\"auto\" is calibrated for \"pressure_stabilization\": \"pspg\" only; use that, or give a number");
  if (p.scheme.direction == fsi::Direction::fiber_only)
    v.error("coupling.penalty",
            "\"auto\" is the resistance to a flow that feels the fiber; with \"direction\": \"fiber_only\" give a "
            "number");
  for (std::size_t i = 0; i < p.fibers.size(); ++i) {
    const std::string path = "fibers[" + std::to_string(i) + "]";
    if (p.fluid && !(p.fibers[i].physics.section.area > 0.0) && !v.failed(path + ".section"))
      v.error(path,
              "\"penalty\": \"auto\" needs the radius of every fiber; add for example \"section\": { "
              "\"radius\": 0.01 }");
  }
}

}  // namespace

void describe_case(Visitor& v, CaseParameters& p) {
  v.text(field("title", "one line about the case"), p.title);
  v.optional_object(field("fluid", "the fluid; missing: fibers alone"), "Fluid", p.fluid, describe_fluid);
  v.optional_object(field("channel", "box filled with the fluid, and its boundary conditions"), "Channel", p.channel,
                    describe_channel);
  v.optional_object(field("mesh", "mesh file filled with the fluid, instead of a channel"), "Mesh file", p.mesh,
                    describe_mesh);
  v.list_of(field("fibers", "fibers and arrays of fibers; missing: fluid alone"), "Fibers", p.fibers,
            describe_fiber_group);
  v.list_of(field("joints", "joints between fibers, or within one"), "Joint", p.joints, describe_joint);
  v.vector(field("gravity",
                 "acceleration g of the fibers; the fluid takes it as body_force, which only shifts its "
                 "pressure",
                 "length/time^2"),
           p.gravity);
  v.flag(field("buoyancy",
               "fibers weigh (rho_b - rho_f) g A instead of rho_b g A per length; to be said where gravity, fluid and "
               "fibers meet")
             .optional(),
         p.buoyancy);
  v.object(field("coupling", "between fluid and fibers").optional(), "Coupling",
           [&](Visitor& inner) { describe_coupling(inner, p.coupling, p.scheme); });
  v.object(field("solver", "tolerances of the fluid and of the monolithic scheme").optional(), "Solver",
           [&](Visitor& inner) { describe_solver(inner, p.solver); });
  v.object(field("time", "time steps and time schemes").optional(), "Time",
           [&](Visitor& inner) { describe_time(inner, p); });
  v.object(field("output", "what is written").optional(), "Output",
           [&](Visitor& inner) { describe_output(inner, p.output); });
  v.list_of(field("expect", "numbers the run must reproduce; it ends with exit code 5 if it does not"),
            "Expected value", p.expect, describe_expectation);
  if (!v.reading()) return;
  check_parts(v, p);
  check_time(v, p);
  check_joints(v, p);
  check_nonlinear(v, p);
  check_coupling(v, p);
}

CaseParameters parse_case(const std::string& text, const std::string& name) {
  const FloatTrapsOff traps_off;  // senseless numbers are reported, not trapped
  std::vector<Complaint> complaints;
  const Node root = parse_document(text, complaints);
  CaseParameters parameters;
  if (complaints.empty() || root.kind == Node::Kind::object) {
    Reader::read(
        root, [&](Visitor& v) { describe_case(v, parameters); }, complaints);
  }
  if (complaints.empty()) return parameters;
  const auto place = [](const Complaint& c) { return std::tie(c.position.line, c.position.column); };
  std::stable_sort(complaints.begin(), complaints.end(),
                   [&](const Complaint& a, const Complaint& b) { return place(a) < place(b); });
  std::string all;
  for (const Complaint& complaint : complaints) {
    if (!all.empty()) all += "\n";
    all += name + ":" + std::to_string(complaint.position.line) + ":" + std::to_string(complaint.position.column) +
           ": " + complaint.text;
  }
  throw Error(ExitCode::usage, all);
}

std::string case_json_schema() {
  CaseParameters parameters;
  return json_schema("Case file of a fluid-fiber computation", [&](Visitor& v) { describe_case(v, parameters); });
}

std::string case_reference() {
  CaseParameters parameters;
  return "# Input reference\n\nThis page is written by `fbi-gen --reference` from the tables that read the input.\n\n"
         "A case is one JSON file; `//` comments are allowed. A number may also be a constant formula as text, such as "
         "`\"10/226\"`. A formula is a number, or text with x, y, z, t, pi, e, the functions sin, cos, tan, asin, "
         "acos, atan, "
         "atan2, sinh, cosh, tanh, exp, ln, log2, log10, sqrt, abs, sign, rint, min, max, sum, avg, powers `^` and "
         "choices "
         "`condition ? a : b`. Units are any consistent set; the dimensions are shown in brackets. Unknown keys are "
         "errors.\n\n" +
         reference_page("Case file", [&](Visitor& v) { describe_case(v, parameters); });
}

}  // namespace fbi::cases
