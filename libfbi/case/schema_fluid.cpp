/// Tables of "fluid" and "channel".
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

void describe_boundaries(Visitor& v, fluid::BoundaryConditions& p) {
  for (const char* face : {"xmin", "xmax", "ymin", "ymax", "zmin", "zmax"}) {
    v.object(field(face, "condition on this face").required("{ \"type\": \"no_slip\" }"), "Boundary condition",
             [&](Visitor& inner) { describe_boundary(inner, p[face]); });
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
                          {BoundaryType::mixed, "mixed", "some velocity components given, traction on the others"}});
  const bool mixed = p.type == BoundaryType::mixed;
  const bool outflow = p.type == BoundaryType::outflow;
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
  v.flag(field("backflow", "resist inflow through this face: adds -beta rho min(v.n, 0) v")
             .only("type", "outflow", outflow),
         p.backflow);
  v.number(field("backflow_beta", "beta of backflow; 0.5 bounds the energy").only("type", "outflow", outflow),
           p.backflow_beta, between(0.5, 1.0));
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

void describe_channel(Visitor& v, Channel& p) {
  v.vector(field("origin", "lower corner of the box", "length"), p.box.origin);
  v.vector(field("size", "extent of the box along x, y, z", "length").required("[3, 1, 1]"), p.box.size, positive());
  v.integers(field("elements", "hexahedral cells along x, y, z").required("[30, 10, 10]"), p.box.elements, at_least(1));
  v.object(field("grading", "spread of the cells, by direction").optional(), "Gradings",
           [&](Visitor& inner) { describe_gradings(inner, p.box.grading); });
  v.flag(field("general", "treat the box as a general hexahedral mesh: slower, for tests and timing"), p.box.general);
  v.object(field("boundaries", "conditions on the six faces; on shared edges no_slip beats inflow beats slip")
               .required("{ \"xmin\": { \"type\": \"no_slip\" }, ... }"),
           "Boundaries", [&](Visitor& inner) { describe_boundaries(inner, p.boundaries); });
  if (!v.reading()) return;
  for (int i = 0; i < 3; ++i) {
    const std::string path = std::string("grading.") + "xyz"[i];
    const mesh::GradingParameters& grading = p.box.grading[i];
    if (!v.given(path) || v.failed(path) || v.failed("elements") || !v.given("elements")) continue;
    if (grading.type == mesh::Grading::tanh && grading.ratio != 1.0 && p.box.elements[i] < 3) {
      v.error(path, "tanh needs at least 3 cells in this direction, not " + std::to_string(p.box.elements[i]));
    }
  }
}

}  // namespace fbi::cases
