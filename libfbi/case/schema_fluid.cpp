/// Tables of "fluid", "channel" and "mesh".
#include <algorithm>
#include <limits>

#include "case/schema_tables.hpp"
#include "input/suggest.hpp"

namespace fbi::cases {

using namespace input;

void describe_fluid(Visitor& v, fluid::FluidParameters& p) {
  v.number(field("density", "density rho", "mass/length^3").required("1.0"), p.density, positive());
  v.number(field("viscosity", "dynamic viscosity mu", "mass/(length time)").required("0.004"), p.viscosity, positive());
  v.choice<fluid::ConvectiveForm>(
      field("convective_form", "how rho (v.grad) v is written"), p.convective_form,
      {{fluid::ConvectiveForm::advective, "advective", "rho (v.grad) v"},
       {fluid::ConvectiveForm::conservative, "conservative",
        "rho (v.grad) v + rho v div v: what leaves a cell enters its neighbor"},
       {fluid::ConvectiveForm::skew, "skew", "rho (v.grad) v + 1/2 rho v div v: convection makes no kinetic energy"},
       {fluid::ConvectiveForm::none, "none", "left out: Stokes flow"}});
  v.choice<fluid::PressureStabilization>(
      field("pressure_stabilization", "what makes equal-order velocity and pressure stable"), p.pressure_stabilization,
      {{fluid::PressureStabilization::pspg, "pspg", "tau_M grad q against the residual of momentum"},
       {fluid::PressureStabilization::projection, "projection",
        "the part of p that is not constant in a cell, over mu (over rho |v| h/6 in fast flow); free of the time "
        "step"}});
  const bool residual = p.pressure_stabilization == fluid::PressureStabilization::pspg ||
                        p.convective_form != fluid::ConvectiveForm::none;
  v.choice<fluid::ViscousResidual>(field("viscous_residual", "div(2 mu eps(v)) in the stabilisation's strong residual")
                                       .only("pressure_stabilization", "pspg, or with convection", residual,
                                             "remove it: without PSPG and SUPG the strong residual is not used"),
                                   p.viscous_residual,
                                   {{fluid::ViscousResidual::full, "full", "with all second derivatives"},
                                    {fluid::ViscousResidual::none, "none", "left out"}});
  v.choice<fluid::Tau>(field("tau", "stabilisation parameters tau_M and tau_C"), p.tau,
                       {{fluid::Tau::franca_valentin, "franca_valentin", "two local Reynolds numbers"},
                        {fluid::Tau::whiting_jansen, "whiting_jansen",
                         "metric tensor G of the cell, tau_C = 1/(tau_M tr G): strong in small time steps"},
                        {fluid::Tau::taylor_hughes_zarins, "taylor_hughes_zarins",
                         "metric tensor G of the cell, tau_C = rho sqrt(v.G v)/tr G"}});
  v.choice<fluid::TauAt>(field("tau_at", "where tau is evaluated"), p.tau_at,
                         {{fluid::TauAt::center, "center", "at the center of a cell"},
                          {fluid::TauAt::quadrature_points, "quadrature_points",
                           "at each of the eight points: slower, eight times the memory of tau"}});
  v.choice<fluid::TauUpdate>(
      field("tau_update", "which velocity tau is taken from"), p.tau_update,
      {{fluid::TauUpdate::step, "step", "the one extrapolated to the new time; kept for the step"},
       {fluid::TauUpdate::iteration, "iteration", "the present iterate; nonlinear iterations converge linearly"}});
  v.flag(field("tau_time", "time-step term in tau_M"), p.tau_time);
  v.flag(field("grad_div", "stabilisation of div v (tau_C)"), p.grad_div);
  v.formulas(field("body_force", "b(x,y,z,t), an acceleration: the force is rho b", "length/time^2"), p.body_force);
  v.formulas(field("initial_velocity", "v(x,y,z) at t = 0", "length/time"), p.initial_velocity);
  v.flag(field("project_initial_velocity", "replace it by the nearest velocity without divergence"),
         p.project_initial_velocity);
}

namespace {

void describe_grading(Visitor& v, mesh::GradingParameters& p) {
  v.choice<mesh::Grading>(
      field("type", "how the cells are spread").required("\"tanh\""), p.type,
      {{mesh::Grading::uniform, "uniform", "equal cells"},
       {mesh::Grading::geometric, "geometric", "each cell `ratio` times the one before it"},
       {mesh::Grading::tanh, "tanh", "finer towards both ends, `ratio` = largest cell / smallest cell"}});
  const bool graded = p.type != mesh::Grading::uniform;
  v.number(field("ratio", "strength of the grading").required("2").only("type", "geometric or tanh", graded), p.ratio,
           positive());
  if (v.reading() && p.type == mesh::Grading::tanh && p.ratio < 1.0 && !v.failed("ratio")) {
    v.error("ratio", "must be at least 1 for tanh: it is largest cell / smallest cell");
  }
}

void describe_gradings(Visitor& v, std::array<mesh::GradingParameters, 3>& p) {
  const char* keys[] = {"x", "y", "z"};
  for (int i = 0; i < 3; ++i) {
    v.object(field(keys[i], std::string("spread of the cells along ") + keys[i] + "; uniform if missing").optional(),
             "Grading", [&](Visitor& inner) { describe_grading(inner, p[i]); });
  }
}

void describe_partition(Visitor& v, mesh::Partition& p) {
  v.choice<mesh::Partition>(
      field("partition", "how the cells are placed on ranks; a mesh that is a box is cut into blocks always"), p,
      {{mesh::Partition::coordinates, "coordinates", "the cell centers are bisected across their longest extent"},
       {mesh::Partition::graph, "graph",
        "few faces between ranks, for bent or branched channels (PT-Scotch); parts may differ in size by a few per "
        "cent"}});
}

void describe_cylinder(Visitor& v, mesh::CylinderParameters& p) {
  v.pair(field("center", "its axis, in the order x, y, z without the axis", "length").required("[0.2, 0.2]"), p.center);
  v.choice<mesh::Axis>(field("axis", "direction of the cylinder, from wall to wall"), p.axis,
                       {{mesh::Axis::x, "x", ""}, {mesh::Axis::y, "y", ""}, {mesh::Axis::z, "z", ""}});
  v.number(field("radius", "its radius", "length").required("0.05"), p.radius, positive());
  v.integer(field("around",
                  "cells around the circle, a multiple of 8; the cells of the whole section follow from it, so that "
                  "twice as many make a mesh twice as fine everywhere")
                .required("64"),
            p.around, at_least(8));
  v.integer(field("layers", "equal cells along the axis"), p.layers, at_least(1));
  v.number(field("first", "thickness of the cells at the cylinder, relative to their length along the circle"), p.first,
           positive());
  v.number(field("block",
                 "half width of the square block of rings around the cylinder; 0: three radii, but no more than 3/4 of "
                 "the distance from the axis to the nearest wall",
                 "length"),
           p.block, at_least(0.0));
  describe_partition(v, p.partition);
  if (v.reading() && v.given("around") && !v.failed("around") && p.around % 8 != 0) {
    const Index below = p.around / 8 * 8;
    v.error("around", "must be a multiple of 8, not " + std::to_string(p.around) + "; use for example " +
                          std::to_string(below + 8));
  }
}

void describe_boundaries(Visitor& v, fluid::BoundaryConditions& p, bool cylinder) {
  for (const char* face : {"xmin", "xmax", "ymin", "ymax", "zmin", "zmax"}) {
    v.object(field(face, "condition on this face").required("{ \"type\": \"no_slip\" }"), "Boundary condition",
             [&](Visitor& inner) { describe_boundary(inner, p[face]); });
  }
  Field f = field("cylinder", "condition on the cylinder, where the channel has one");
  if (v.reading() && cylinder) f.required("{ \"type\": \"no_slip\" }");
  f.optional().only("channel.cylinder", "given", !v.reading() || cylinder);
  v.object(f, "Boundary condition", [&](Visitor& inner) { describe_boundary(inner, p["cylinder"]); });
}

/// How far the cylinder is from the nearest wall, and the errors of a place where it does not fit.
void check_cylinder(Visitor& v, const Channel& p) {
  const mesh::CylinderParameters& c = *p.cylinder;
  if (v.failed("cylinder") || v.failed("size") || v.failed("origin") || !v.given("size")) return;
  double distance = std::numeric_limits<double>::infinity();
  int i = 0;
  for (int a = 0; a < 3; ++a) {
    if (a == static_cast<int>(c.axis)) continue;
    const double low = c.center[i] - p.box.origin[a];
    distance = std::min({distance, low, p.box.size[a] - low});
    ++i;
  }
  if (c.block > 0.0 && c.block < 1.2 * c.radius) {
    v.error("cylinder.block",
            "must be at least 1.2 radii, " + number_text(1.2 * c.radius) + ", not " + number_text(c.block));
  } else if (distance < 1.6 * c.radius) {
    v.error("cylinder",
            "its axis must be at least 1.6 radii from every wall; the distance is " + number_text(distance));
  } else if (c.block > 0.95 * distance) {
    v.error("cylinder.block", "must be at most 0.95 of the distance from the axis to the nearest wall, " +
                                  number_text(0.95 * distance) + ", not " + number_text(c.block));
  }
}

}  // namespace

void describe_boundary(Visitor& v, fluid::BoundaryCondition& p) {
  using fluid::BoundaryType;
  v.choice<BoundaryType>(field("type", "kind of condition").required("\"no_slip\""), p.type,
                         {{BoundaryType::inflow, "inflow", "velocity given"},
                          {BoundaryType::no_slip, "no_slip", "velocity zero"},
                          {BoundaryType::slip, "slip", "normal velocity zero, no tangential traction"},
                          {BoundaryType::outflow, "outflow", "traction zero"},
                          {BoundaryType::traction, "traction", "traction given"},
                          {BoundaryType::pressure, "pressure", "traction -p n of a given pressure"},
                          {BoundaryType::mixed, "mixed", "some velocity components given, traction on the others"},
                          {BoundaryType::periodic, "periodic", "the flow of another face, by translation"}});
  const bool mixed = p.type == BoundaryType::mixed;
  const bool open =
      p.type == BoundaryType::outflow || p.type == BoundaryType::traction || p.type == BoundaryType::pressure;
  v.partial_formulas(
      field("velocity", "velocity as formulas of x, y, z, t; null (mixed only) leaves a component free", "length/time")
          .required("[\"4*y*(1-y)\", 0, 0]")
          .only("type", "inflow or mixed", p.type == BoundaryType::inflow || mixed),
      p.velocity);
  v.formulas(field("traction", "traction as formulas of x, y, z, t; required for traction, zero if missing for mixed",
                   "force/area")
                 .optional()
                 .only("type", "traction or mixed", p.type == BoundaryType::traction || mixed),
             p.traction);
  v.formula(field("pressure", "pressure as a formula of x, y, z, t", "force/area")
                .required("0")
                .only("type", "pressure", p.type == BoundaryType::pressure),
            p.pressure);
  v.flag(field("backflow", "resist inflow through this face: adds -beta rho min(v.n, 0) v")
             .only("type", "outflow, traction or pressure", open),
         p.backflow);
  v.number(field("backflow_beta", "beta of backflow; 0.5 bounds the energy")
               .only("type", "outflow, traction or pressure", open),
           p.backflow_beta, between(0.5, 1.0));
  v.text(field("with", "the other face of a periodic pair; on one of them or on both")
             .optional()
             .only("type", "periodic", p.type == BoundaryType::periodic),
         p.with);
  if (!v.reading() || v.failed("type")) return;
  if (p.type == BoundaryType::traction && !v.given("traction")) {
    v.missing("traction",
              "missing key \"traction\", needed for type traction; add for example \"traction\": [0, 0, 0]");
  }
  if (v.given("backflow_beta") && !p.backflow) {
    v.error("backflow_beta", "has no effect without \"backflow\": true; add that or remove this");
  }
  if ((p.type == BoundaryType::inflow || mixed) && v.given("velocity") && !v.failed("velocity")) {
    const int prescribed = p.velocity[0].has_value() + p.velocity[1].has_value() + p.velocity[2].has_value();
    if (p.type == BoundaryType::inflow && prescribed < 3) {
      v.error("velocity", "inflow prescribes all three components; use type mixed to leave one free");
    }
    if (mixed && prescribed == 0) v.error("velocity", "leaves every component free; use type traction");
    if (mixed && prescribed == 3 && v.given("traction")) {
      v.error("traction", "has no effect: the velocity leaves no component free; use type inflow");
    }
    for (int i = 0; mixed && i < 3; ++i) {
      const std::string item = "traction[" + std::to_string(i) + "]";
      if (prescribed < 3 && p.velocity[i] && !p.traction[i].is_zero()) {
        v.error(item, "has no effect: the velocity of this component is given; write 0");
      }
    }
  }
}

namespace {

/// Both faces of each periodic pair are periodic and agree; fills in the partners that were left out.
void pair_faces(Visitor& v, fluid::BoundaryConditions& conditions) {
  using fluid::BoundaryType;
  if (v.failed("boundaries")) return;
  std::vector<std::string> names;
  for (const auto& [name, condition] : conditions) names.push_back(name);
  bool sound = true;
  const auto error = [&](const std::string& name, const std::string& what) {
    v.error("boundaries." + name + (v.given("boundaries." + name + ".with") ? ".with" : ""), what);
    sound = false;
  };
  const std::map<std::string, fluid::BoundaryCondition> given = conditions;
  for (const auto& [name, condition] : given) {
    if (condition.type != BoundaryType::periodic || condition.with.empty()) continue;
    const auto other = given.find(condition.with);
    if (other == given.end()) {
      const std::string hint = did_you_mean(condition.with, names);
      error(name,
            "there is no face \"" + condition.with + "\"" + (hint.empty() ? "; choose " + list_text(names) : hint));
    } else if (condition.with == name) {
      error(name, "a face is not periodic with itself; name the opposite face");
    } else if (other->second.type != BoundaryType::periodic) {
      error(name, "face \"" + condition.with + "\" has another condition; make it { \"type\": \"periodic\" }");
    } else if (!other->second.with.empty() && other->second.with != name) {
      error(name, "face \"" + condition.with + "\" is periodic with \"" + other->second.with + "\" already");
    } else if (!conditions[condition.with].with.empty() && conditions[condition.with].with != name) {
      error(name,
            "face \"" + condition.with + "\" is periodic with \"" + conditions[condition.with].with + "\" already");
    } else {
      conditions[condition.with].with = name;
    }
  }
  if (!sound) return;
  for (const auto& [name, condition] : conditions)
    if (condition.type == BoundaryType::periodic && condition.with.empty())
      error(name, "missing key \"with\": the other face of the periodic pair");
}

}  // namespace

void describe_channel(Visitor& v, Channel& p) {
  v.vector(field("origin", "lower corner of the box", "length"), p.box.origin);
  v.vector(field("size", "extent of the box along x, y, z", "length").required("[3, 1, 1]"), p.box.size, positive());
  v.integers(field("elements", "hexahedral cells along x, y, z; required without cylinder").optional(), p.box.elements,
             at_least(1));
  v.object(field("grading", "spread of the cells, by direction").optional(), "Gradings",
           [&](Visitor& inner) { describe_gradings(inner, p.box.grading); });
  v.flag(field("general", "treat the box as a general hexahedral mesh: slower, for tests and timing"), p.box.general);
  v.optional_object(field("cylinder", "circular cylinder across the channel; its face set is \"cylinder\""), "Cylinder",
                    p.cylinder, describe_cylinder);
  v.object(field("boundaries", "conditions on the six faces; on shared edges no_slip beats inflow beats slip")
               .required("{ \"xmin\": { \"type\": \"no_slip\" }, ... }"),
           "Boundaries", [&](Visitor& inner) { describe_boundaries(inner, p.boundaries, p.cylinder.has_value()); });
  if (!v.reading()) return;
  pair_faces(v, p.boundaries);
  if (p.cylinder) {
    for (const char* key : {"elements", "grading", "general"})
      if (v.given(key))
        v.error(key, "has no effect with \"cylinder\": the cells follow from cylinder.around; remove it");
    check_cylinder(v, p);
    return;
  }
  if (!v.given("elements"))
    v.missing("elements", "missing key \"elements\"; add for example \"elements\": [30, 10, 10]");
  for (int i = 0; i < 3; ++i) {
    const std::string path = std::string("grading.") + "xyz"[i];
    const mesh::GradingParameters& grading = p.box.grading[i];
    if (!v.given(path) || v.failed(path) || v.failed("elements") || !v.given("elements")) continue;
    if (grading.type == mesh::Grading::tanh && grading.ratio != 1.0 && p.box.elements[i] < 3) {
      v.error(path, "tanh needs at least 3 cells in this direction, not " + std::to_string(p.box.elements[i]));
    }
  }
}

void describe_mesh(Visitor& v, MeshFile& p) {
  v.text(field("file", "a mesh of hexahedra as gmsh writes it (.msh, formats 2 and 4); relative to the case file")
             .required("\"mesh.msh\""),
         p.source.file);
  v.number(field("scale", "factor for all coordinates of the file"), p.source.scale, positive());
  describe_partition(v, p.source.partition);
  v.named(field("boundaries", "conditions on the named surfaces (physical groups) of the mesh, one for each")
              .required("{ \"inlet\": { \"type\": \"no_slip\" }, ... }"),
          "Boundary condition",
          [&](Visitor& inner, const std::string& name) { describe_boundary(inner, p.boundaries[name]); });
  if (v.reading() && v.given("file") && !v.failed("file") && p.source.file.empty())
    v.error("file", "must not be empty");
  if (v.reading()) pair_faces(v, p.boundaries);
}

}  // namespace fbi::cases
