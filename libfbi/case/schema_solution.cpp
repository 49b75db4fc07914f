/// Tables of "coupling", "solver", "time", "output" and "expect".
#include <cmath>

#include "case/schema_tables.hpp"
#include "input/suggest.hpp"

namespace fbi::cases {

using namespace input;

namespace {

/// What belongs to the schemes that solve fluid and fibers in turns.
void describe_partitioned(Visitor& v, fsi::SchemeParameters& scheme) {
  using fsi::Scheme;
  const std::string name = "scheme", all = "constant, aitken, newton_krylov or iqn_ils";
  const bool partitioned = scheme.scheme != Scheme::monolithic;
  const std::string hint = "remove it or set \"scheme\": \"aitken\"";
  const std::string newton = hint + " (the tolerances of monolithic are those of \"solver\")";
  v.number(field("tolerance", "largest relative change of the interaction force").only(name, all, partitioned, newton),
           scheme.tolerance, positive());
  v.number(
      field("absolute_tolerance", "the same, absolute, root mean square", "force").only(name, all, partitioned, newton),
      scheme.absolute_tolerance, at_least(0.0));
  v.integer(field("max_iterations", "most iterations of a step").only(name, all, partitioned, newton),
            scheme.max_iterations, at_least(1));
  v.flag(field("implicit_penalty",
               "the force of the penalty that follows the fibers' own velocity stays in their equations")
             .only(name, all, partitioned, hint),
         scheme.implicit_penalty);
  v.choice<fsi::ForcePredictor>(
      field("force_predictor", "force that a step starts from").only(name, all, partitioned, hint),
      scheme.force_predictor,
      {{fsi::ForcePredictor::constant, "constant", "that of the last step"},
       {fsi::ForcePredictor::linear, "linear", "extrapolated from two steps"},
       {fsi::ForcePredictor::quadratic, "quadratic", "extrapolated from three steps"}});
  const bool krylov = scheme.scheme == Scheme::newton_krylov, quasi = scheme.scheme == Scheme::iqn_ils;
  v.number(field("relaxation", "relaxation factor; aitken and iqn_ils: the first")
               .only(name, "constant, aitken or iqn_ils", partitioned && !krylov, hint),
           scheme.relaxation, Range{.min = 0.0, .max = 1.0, .without_min = true});
  const std::string use_krylov = "remove it or set \"scheme\": \"newton_krylov\"";
  v.choice<fsi::Differences>(
      field("differences", "evaluation of the fields for the differences of the Jacobian")
          .only(name, "newton_krylov", krylov, use_krylov),
      scheme.differences,
      {{fsi::Differences::linearized, "linearized", "one linear solve of each about the iterate"},
       {fsi::Differences::nonlinear, "nonlinear", "both solved again, fiber positions included"}});
  v.number(field("gamma", "difference step over the size of the force").only(name, "newton_krylov", krylov, use_krylov),
           scheme.gamma, Range{.min = 0.0, .max = 1.0, .without_min = true});
  v.number(field("krylov_tolerance", "residual of a linear solve on the interface, relative")
               .only(name, "newton_krylov", krylov, use_krylov),
           scheme.krylov_tolerance, Range{.min = 0.0, .max = 1.0, .without_min = true});
  v.integer(field("krylov_iterations", "most iterations of a linear solve on the interface")
                .only(name, "newton_krylov", krylov, use_krylov),
            scheme.krylov_iterations, at_least(1));
  const std::string use_quasi = "remove it or set \"scheme\": \"iqn_ils\"";
  v.integer(field("reuse", "earlier steps that the quasi-Newton matrix is built from as well")
                .only(name, "iqn_ils", quasi, use_quasi),
            scheme.reuse, at_least(0));
  v.number(field("filter", "differences of which less than this share is independent of newer ones are dropped")
               .only(name, "iqn_ils", quasi, use_quasi),
           scheme.filter, Range{.min = 0.0, .max = 1.0, .without_min = true});
}

}  // namespace

void describe_coupling(Visitor& v, coupling::CouplingParameters& p, fsi::SchemeParameters& scheme) {
  v.choice<fsi::Scheme>(field("scheme", "how fluid and fibers are solved"), scheme.scheme,
                        {{fsi::Scheme::monolithic, "monolithic", "together, fibers condensed"},
                         {fsi::Scheme::constant, "constant", "in turns, force relaxed by a constant factor"},
                         {fsi::Scheme::aitken, "aitken", "in turns, force relaxed by Aitken's rule"},
                         {fsi::Scheme::newton_krylov, "newton_krylov", "in turns, Newton's method by differences"},
                         {fsi::Scheme::iqn_ils, "iqn_ils", "in turns, quasi-Newton by least squares"}});
  v.choice<fsi::Direction>(
      field("direction", "which field feels the other"), scheme.direction,
      {{fsi::Direction::two_way, "two_way", "each the other"},
       {fsi::Direction::fluid_only, "fluid_only",
        "the fluid feels the fibers, which move by their own loads, supports or motion"},
       {fsi::Direction::fiber_only, "fiber_only", "the fibers feel the fluid, which flows as if they were not there"}});
  if (scheme.scheme != fsi::Scheme::monolithic && scheme.direction != fsi::Direction::two_way && v.given("scheme"))
    v.error("scheme", "nothing is to be iterated with \"direction\": \"fluid_only\" or \"fiber_only\"; remove it");
  v.choice<coupling::Multiplier>(field("multiplier", "Lagrange multipliers on the fibers"), p.multiplier,
                                 {{coupling::Multiplier::linear, "linear", "linear, continuous over a fiber"},
                                  {coupling::Multiplier::quadratic, "quadratic", "quadratic, continuous"},
                                  {coupling::Multiplier::cubic, "cubic", "cubic, continuous"},
                                  {coupling::Multiplier::gauss_point, "gauss_point",
                                   "one for each integration point: Gauss-point-to-cell penalty"}});
  v.choice<coupling::Operator>(
      field("operator", "how a fiber sees the velocity of the fluid, and where its force goes"), p.kernel,
      {{coupling::Operator::centerline, "centerline", "on its center line; its radius does not matter then"},
       {coupling::Operator::ring, "ring", "mean over a circle around it, of its radius or half a cell"}});
  v.number_or_word(
      field("penalty", "force per fiber length and velocity difference", "force time/length^2"), p.penalty, p.automatic,
      positive(),
      {"auto", "from viscosity, cells and the radius of the fiber, which then has its own resistance; with ring"});
  v.choice<fsi::GeometryUpdate>(
      field("geometry_update", "fiber positions used by the coupling terms"), scheme.geometry_update,
      {{fsi::GeometryUpdate::lagged, "lagged", "those at the start of the step"},
       {fsi::GeometryUpdate::extrapolated, "extrapolated", "extrapolated from the last two steps, second order"},
       {fsi::GeometryUpdate::iterated, "iterated", "those of the current iterate"}});
  v.choice<fsi::CouplingWeight>(
      field("coupling_weight",
            "share w of the new coupling force in the fiber equations: w lambda_(n+1) + (1-w) lambda_n")
          .only("direction", "two_way or fiber_only", scheme.direction != fsi::Direction::fluid_only),
      scheme.coupling_weight,
      {{fsi::CouplingWeight::theta, "theta", "that of the fluid: both receive the same impulse"},
       {fsi::CouplingWeight::one_minus_alpha_f, "1-alpha_f", "that of the fibers' generalised-alpha"}});
  v.choice<coupling::Integration>(
      field("integration", "of the coupling terms along a fiber"), p.integration,
      {{coupling::Integration::segments, "segments", "elements are cut at the faces of cells"},
       {coupling::Integration::element, "element", "elements as a whole: cheaper, and blind to faces between points"}});
  v.integer(field("gauss_points", "integration points of a segment of a fiber within one cell, or of an element"),
            p.gauss_points, between(1, 64));
  v.choice<coupling::Outside>(field("outside", "fibers that reach out of the fluid"), p.outside,
                              {{coupling::Outside::error, "error", "end the run"},
                               {coupling::Outside::allow, "allow", "feel the fluid only inside it"}});
  describe_partitioned(v, scheme);
}

void describe_solver(Visitor& v, fsi::SolverParameters& p) {
  v.choice<fsi::LinearSolver>(
      field("linear", "solver of the linear systems of the fluid"), p.linear,
      {{fsi::LinearSolver::automatic, "auto", "iterative in time; for steady flow direct below 150,000 unknowns"},
       {fsi::LinearSolver::direct, "direct", "sparse factorisation"},
       {fsi::LinearSolver::iterative, "iterative", "Krylov method, matrix-free; steady flow: in pseudo-time steps"},
       {fsi::LinearSolver::reference, "reference",
        "GMRES with incomplete factors of the assembled matrix: slow, to compare with"}});
  v.choice<fluid::Linearization>(
      field("nonlinear", "treatment of the convecting velocity"), p.nonlinear,
      {{fluid::Linearization::newton, "newton", "quadratic convergence; steady flow: after some steps of picard"},
       {fluid::Linearization::picard, "picard", "frozen within an iteration"},
       {fluid::Linearization::extrapolated, "linearized",
        "extrapolated from earlier steps, second order: one linear solve a step"}});
  v.number(
      field("newton_tolerance",
            "residual relative to the first one of the step, but where this is looser than 1e-3 to no more than a "
            "twentieth of (rho sigma V + mu h) |v|; fibers to 5e-3 at least; 0: 2.2e-2 for time steps of the fluid "
            "alone or by the monolithic scheme, 1e-3 for these with bdf2 or theta < 0.6, 1e-6 for all others"),
      p.newton_tolerance, between(0.0, 1.0));
  v.number(field("newton_absolute_tolerance", "residual, root mean square of all unknowns"),
           p.newton_absolute_tolerance, at_least(0.0));
  v.integer(field("newton_iterations", "most nonlinear iterations of a step; steady flow: ten times as many"),
            p.newton_iterations, at_least(1));
  v.choice<fsi::Precision>(
      field("precision", "numbers in the iterations of linear solves"), p.precision,
      {{fsi::Precision::mixed, "mixed", "single precision, corrected by residuals in double precision"},
       {fsi::Precision::twofold, "double", "double precision"}});
  v.number(field("krylov_tolerance",
                 "residual of a linear solve, relative; 0: 1.1e-2 where newton_tolerance is 0 and becomes 2.2e-2, 5e-4 "
                 "where it becomes 1e-3, 1e-4 for all others"),
           p.krylov_tolerance, between(0.0, 1.0));
  v.integer(field("krylov_iterations", "most iterations of a linear solve; ten times as many with reference"),
            p.krylov_iterations, at_least(1));
  const bool reference = p.linear == fsi::LinearSolver::reference;
  v.integer(field("ilu_level", "levels of fill of the incomplete factors").only("linear", "reference", reference),
            p.ilu_level, between(0, 10));
  v.integer(field("gmres_restart", "directions kept by GMRES").only("linear", "reference", reference), p.gmres_restart,
            at_least(1));
}

namespace {

void describe_fluid_time(Visitor& v, fluid::FluidTimeParameters& p) {
  v.choice<fluid::TimeScheme>(
      field("scheme", "time integration of the fluid"), p.scheme,
      {{fluid::TimeScheme::one_step_theta, "one_step_theta", "trapezoidal family"},
       {fluid::TimeScheme::bdf2, "bdf2", "second order, damps what is fast; starts by theta = 1"},
       {fluid::TimeScheme::steady, "steady", "no time derivative; fibers must be fixed"}});
  v.number(field("theta", "1 = implicit Euler, 0.5 = trapezoidal rule")
               .only("scheme", "one_step_theta", p.scheme == fluid::TimeScheme::one_step_theta),
           p.theta, between(0.5, 1.0));
}

void describe_beam_time(Visitor& v, beam::BeamTimeParameters& p) {
  v.choice<beam::TimeScheme>(
      field("scheme", "time integration of the fibers"), p.scheme,
      {{beam::TimeScheme::generalized_alpha, "generalized_alpha", "dynamics"},
       {beam::TimeScheme::midpoint, "midpoint",
        "dynamics that conserve energy and momentum of torsion-free fibers: midpoint rule with difference quotients of "
        "the energy"},
       {beam::TimeScheme::static_, "static", "equilibrium of fibers without fluid, loads applied in steps"}});
  v.number(field("rho_inf", "spectral radius at infinite frequency; 1 = no numerical damping")
               .only("scheme", "generalized_alpha", p.scheme == beam::TimeScheme::generalized_alpha),
           p.rho_inf, between(0.0, 1.0));
  v.number(field("tolerance", "Newton: residual relative to the largest force, in runs without fluid"), p.tolerance,
           Range{.min = 0.0, .max = 1.0, .without_min = true});
  v.integer(field("max_iterations", "most Newton iterations of a step"), p.max_iterations, at_least(1));
}

}  // namespace

void describe_time(Visitor& v, CaseParameters& p) {
  v.number(
      field("step",
            "time step dt; statics: step of the load factor, all at once if missing; not needed for steady flow past "
            "fixed fibers",
            "time")
          .optional(),
      p.time.step, positive());
  v.number(
      field("end", "end time, a whole number of steps; statics: last load factor, 1 if missing", "time").optional(),
      p.time.end, positive());
  v.number(field("steady_tolerance",
                 "the run ends when the rate of change of the velocity fell below this times the velocity (root mean "
                 "squares); 0: never",
                 "1/time"),
           p.time.steady_tolerance, at_least(0.0));
  v.integer(field("halvings",
                  "a step that does not converge is repeated in parts of step/2, step/4, ... at least step/2^halvings; "
                  "0: never"),
            p.time.halvings, between(0, 20));
  v.object(field("fluid", "time scheme of the fluid").optional(), "Fluid time",
           [&](Visitor& inner) { describe_fluid_time(inner, p.fluid_time); });
  v.object(field("beam", "time scheme of the fibers").optional(), "Beam time",
           [&](Visitor& inner) { describe_beam_time(inner, p.beam_time); });
}

namespace {

void describe_probe(Visitor& v, Probe& p) {
  v.text(field("fiber", "name of a fiber such as patch/112/7: records its displacement").optional(), p.fiber);
  v.choice<beam::End>(field("at", "the observed end, with fiber"), p.at,
                      {{beam::End::start, "start", ""}, {beam::End::end, "end", ""}});
  v.flag(field("forces", "with fiber: record drag and clamp reaction instead"), p.forces);
  v.vector(field("point", "a point, instead of fiber: records velocity and pressure there", "length").optional(),
           p.point);
  if (!v.reading()) return;
  const bool fiber = v.given("fiber"), point = v.given("point");
  if (fiber == point)
    v.error("", fiber ? "contradictory: give \"fiber\" or \"point\"" : "missing key: give \"fiber\" or \"point\"");
  if (fiber && p.fiber.empty() && !v.failed("fiber")) v.error("fiber", "must not be empty");
  for (const char* key : {"at", "forces"}) {
    if (point && !fiber && v.given(key)) v.error(key, "goes with \"fiber\" only; remove it");
  }
}

void describe_forces(Visitor& v, ForceOutput& p) {
  v.text(field("name", "first part of the names of the columns").required("\"cylinder\""), p.name);
  v.texts(field("faces", "names of face sets whose forces are summed").required("[\"cylinder\"]"), p.faces);
  Vec3 about = Vec3::Zero();
  v.vector(field("moment_about", "record the moment about this point as well", "length").optional(), about);
  v.object(field("coefficient", "record the force over rho speed^2 area/2 as well").optional(), "Force coefficient",
           [&](Visitor& inner) {
             inner.number(field("speed", "speed of the coefficient", "length/time").required("1"), p.speed, positive());
             inner.number(field("area", "area of the coefficient", "length^2").required("1"), p.area, positive());
           });
  if (!v.reading()) return;
  if (v.given("moment_about")) p.about = about;
  check_name(v, p.name, "names become columns of tables");
  if (v.given("faces") && !v.failed("faces") && p.faces.empty()) v.error("faces", "must name a face set");
}

void describe_averages(Visitor& v, Averages& p) {
  v.number(field("from", "means are taken of the steps that begin at this time or later", "time"), p.from,
           at_least(0.0));
  v.integer(field("every", "one in so many steps is taken in and stands for the time since the one before"), p.every,
            at_least(1));
}

}  // namespace

void describe_output(Visitor& v, Output& p) {
  v.integer(field("every", "fields are written every so many steps; 0: first and last only"), p.every, at_least(0));
  v.integer(field("checkpoint", "a checkpoint every so many steps; 0: by wall time and at the end only"), p.checkpoint,
            at_least(0));
  v.number(field("checkpoint_minutes", "wall time between checkpoints; 0: never by wall time", "min"),
           p.checkpoint_minutes, at_least(0.0));
  v.integer(field("fiber_points", "points of one element on the written center line"), p.fiber_points,
            between(2, 1000));
  v.list_of(field("probes", "what is recorded in every step"), "Probe", p.probes, describe_probe);
  v.list_of(field("forces", "forces of the fluid on named faces, recorded in every step"), "Force on faces", p.forces,
            describe_forces);
  v.optional_object(field("averages",
                          "running means of velocity, pressure and velocity fluctuations, written with the fields as "
                          "mean_velocity, mean_pressure and reynolds_stress (the means of v_i' v_j': xx, xy, xz, yy, "
                          "yz, zz); {} takes all steps"),
                    "Averages", p.averages, describe_averages);
}

void describe_expectation(Visitor& v, Expectation& p) {
  v.text(field("quantity", "a column of the history, such as \"patch/112/7:displacement_x\"")
             .required("\"beam:displacement_x\""),
         p.quantity);
  v.number(field("value", "the expected value").required("0"), p.value);
  v.text(field("source", "where the value is from: author and year, for the record"), p.source);
  double relative = 0.0, absolute = 0.0;
  v.number(field("tolerance", "admissible relative deviation").optional(), relative, at_least(0.0));
  v.number(field("absolute_tolerance", "admissible deviation, instead of tolerance").optional(), absolute,
           at_least(0.0));
  v.optional_number(
      field("time", "the row nearest to this time is compared; missing: the last one, or all by reduce", "time"),
      p.time, at_least(0.0));
  v.choice<std::string>(field("reduce", "what is compared when no time is given"), p.reduce,
                        {{"last", "last", "value at the end"},
                         {"max", "max", "largest value of all steps"},
                         {"min", "min", "smallest value"},
                         {"max_abs", "max_abs", "largest absolute value"}});
  if (!v.reading()) return;
  const bool is_relative = v.given("tolerance"), is_absolute = v.given("absolute_tolerance");
  p.relative = is_relative;
  p.tolerance = is_relative ? relative : absolute;
  if (is_relative == is_absolute) {
    v.error("", is_relative ? "contradictory: give \"tolerance\" or \"absolute_tolerance\""
                            : "missing key: give \"tolerance\" (relative) or \"absolute_tolerance\"");
  } else if (is_relative && p.value == 0.0 && v.given("value") && !v.failed("value")) {
    v.error("tolerance", "a relative tolerance of the value 0 means nothing; use \"absolute_tolerance\"");
  }
  if (v.given("time") && v.given("reduce"))
    v.error("reduce", "contradicts \"time\": one row has nothing to reduce; remove one");
  if (v.given("quantity") && !v.failed("quantity") && p.quantity.empty()) v.error("quantity", "must not be empty");
}

}  // namespace fbi::cases
