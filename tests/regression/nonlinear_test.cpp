/// Newton, Picard and linearized: one answer, one solve; steady flow from rest.
#include "record.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

constexpr int steps = 20;

Json reversing(const std::string& nonlinear, bool bdf2 = false) {
  Json json = small_beam(R"({ "time": { "step": 1e-3, "end": 0.02 } })");
  set_inflow(json, 20.0, 0.01);
  tighten(json, 1e-10, 1e-6);
  json["solver"]["nonlinear"] = nonlinear;
  if (bdf2) json["time"]["fluid"] = {{"scheme", "bdf2"}};
  return json;
}

/// Displacement of the tip after each step.
std::vector<double> tips(const Json& json, int count = steps, int* most_solves = nullptr) {
  CoupledCase run(json);
  std::vector<double> tips;
  for (int k = 0; k < count && !::testing::Test::HasFailure(); ++k) {
    const fsi::StepReport result = run.step();
    if (most_solves != nullptr) *most_solves = std::max(*most_solves, result.newton);
    for (int i = 0; i < 3; ++i) tips.push_back(run.tip()[i]);
  }
  return tips;
}

TEST(Nonlinear, picard_gives_the_answer_of_newton) {
  for (const char* scheme : {"monolithic", "aitken"}) {
    Json newton = reversing("newton"), picard = reversing("picard");
    for (Json* json : {&newton, &picard}) {
      (*json)["coupling"]["scheme"] = scheme;
      tighten(*json, 1e-11, 1e-7);
    }
    CoupledCase one(newton), other(picard);
    one.run(3);
    other.run(3);
    const Snapshot a = one.snapshot(), b = other.snapshot();
    const double velocity = relative_difference(b.velocity, a.velocity);
    const double tip = relative_difference(b.displacement, a.displacement);
    report(std::string(scheme) + " picard - newton, velocity", velocity);
    report(std::string(scheme) + " picard - newton, displacement", tip);
    EXPECT_LE(velocity, 1e-8);
    EXPECT_LE(tip, 1e-8);
    record({.section = "Coupling",
            .check = std::string("picard and newton give one step, ") + scheme,
            .source = "identity",
            .reference = 0,
            .ours = std::max(velocity, tip),
            .bar = "1e-8"});
  }
}

// One coupled linear solve a step: stable, and close to the nonlinear solution once a step follows the reversal of the
// flow; with 10 steps in half a period (step 1e-3) the tip is still 23 % off, with 20 it is 0.2 %.
TEST(Nonlinear, one_linear_solve_a_step) {
  for (const bool bdf2 : {false, true}) {
    Json newton = reversing("newton", bdf2), linearized = reversing("linearized", bdf2);
    for (Json* json : {&newton, &linearized}) (*json)["time"]["step"] = 5e-4;
    int most = 0;
    const std::vector<double> expected = tips(newton, 2 * steps);
    const std::vector<double> found = tips(linearized, 2 * steps, &most);
    EXPECT_EQ(most, 1);
    const double gap = relative_difference(found, expected);
    report(std::string(bdf2 ? "bdf2" : "theta 1") + " linearized - newton, tip", gap);
    EXPECT_LE(gap, 0.01);
    record({.section = "Coupling",
            .check = std::string("tip of the fiber, one linear solve a step against newton, reversing flow, ") +
                     (bdf2 ? "bdf2" : "theta = 1"),
            .source = "newton, same mesh and step",
            .reference = 0,
            .ours = gap,
            .bar = "0.01"});
  }
}

/// Flow of speed 1 from one step to the next, past a fiber or not, with the default tolerances.
Json sudden_start(bool fiber) {
  Json json = parse_json(R"case({
    "fluid": { "density": 1, "viscosity": 0.01 },
    "channel": { "size": [2, 1, 0.5], "elements": [16, 8, 4], "boundaries": {
      "xmin": { "type": "inflow", "velocity": ["4*y*(1-y)", 0, 0] }, "xmax": { "type": "outflow" },
      "ymin": { "type": "no_slip" }, "ymax": { "type": "no_slip" }, "zmin": { "type": "slip" },
      "zmax": { "type": "slip" } } },
    "solver": { "linear": "iterative" }, "time": { "step": 0.02, "end": 0.2 } })case");
  if (fiber)
    json.merge_patch(parse_json(R"case({
      "fibers": [ { "name": "fiber", "curve": { "type": "line", "from": [0.5, 0, 0.25], "to": [0.5, 0.5, 0.25] },
        "elements": 4, "section": { "radius": 0.01 }, "material": { "young": 1e5, "density": 10 },
        "clamped": "start" } ],
      "coupling": { "scheme": "monolithic", "geometry_update": "extrapolated" } })case"));
  return json;
}

// After a sudden start the default tolerance is relative to less than the first residual of a step. The one solve of
// linearized must be as exact as that asks for.
TEST(Nonlinear, one_linear_solve_is_enough_after_a_sudden_start) {
  for (const bool fiber : {false, true}) {
    Json loose = sudden_start(fiber), tight = sudden_start(fiber);
    for (Json* json : {&loose, &tight}) (*json)["solver"]["nonlinear"] = "linearized";
    tight["solver"]["newton_tolerance"] = tight["solver"]["krylov_tolerance"] = 1e-8;
    CoupledCase run(loose), other(tight);
    for (int k = 0; k < 10 && !::testing::Test::HasFailure(); ++k) {
      EXPECT_EQ(run.step().newton, 1);
      other.step();
    }
    const double gap = relative_difference(run.snapshot().velocity, other.snapshot().velocity);
    report(std::string(fiber ? "fiber" : "no fiber") + ", default tolerances - tight, velocity", gap);
    EXPECT_LE(gap, 0.01);
  }
}

// Pressure holds the weight of a fluid that rests: nothing flows, so the first residual is the one thing that tells how
// large forces are, and in later steps that is round-off.
TEST(Nonlinear, fluid_at_rest_under_its_weight) {
  for (const char* linear : {"direct", "iterative"})
    for (const bool fiber : {false, true}) {
      Json json = sudden_start(fiber);
      json["fluid"]["body_force"] = {0, -1, 0};
      for (const char* face : {"xmin", "xmax", "ymin", "zmin", "zmax"})
        json["channel"]["boundaries"][face] = {{"type", "no_slip"}};
      json["channel"]["boundaries"]["ymax"] = {{"type", "outflow"}};
      json["solver"]["linear"] = linear;
      CoupledCase run(json);
      run.run(3);
      const Snapshot found = run.snapshot();
      double speed = 0.0, pressure = 0.0;
      for (const double v : found.velocity) speed = std::max(speed, std::abs(v));
      for (const double p : found.pressure) pressure = std::max(pressure, p);
      report(std::string(linear) + (fiber ? ", fiber" : "") + ", speed", speed);
      EXPECT_LE(speed, 1e-3 * 0.02) << linear;  // of a free fall in one step
      EXPECT_NEAR(pressure, 1.0, 1e-3) << linear;
    }
}

TEST(Nonlinear, bdf2_with_a_fiber_is_close_to_theta_1) {
  const double gap = relative_difference(tips(reversing("newton", true)), tips(reversing("newton")));
  report("bdf2 - theta 1, tip", gap);  // theta = 1 is of first order
  EXPECT_LE(gap, 0.2);
}

Json cavity(double viscosity) {
  Json json = parse_json(R"({
    "fluid": { "density": 1, "viscosity": 1 },
    "channel": { "size": [1, 1, 0.125], "elements": [16, 16, 2], "boundaries": {
      "xmin": { "type": "no_slip" }, "xmax": { "type": "no_slip" }, "ymin": { "type": "no_slip" },
      "ymax": { "type": "inflow", "velocity": [1, 0, 0] }, "zmin": { "type": "slip" }, "zmax": { "type": "slip" } } },
    "time": { "fluid": { "scheme": "steady" } }, "solver": { "newton_tolerance": 1e-9 } })");
  json["fluid"]["viscosity"] = viscosity;
  return json;
}

TEST(Nonlinear, steady_cavity_from_rest_by_three_ways) {
  Snapshot expected;
  for (const std::string way : {"newton", "picard", "pseudo-time"}) {
    Json json = cavity(1e-3);
    if (way == "picard") json["solver"]["nonlinear"] = "picard";
    if (way == "pseudo-time") json["solver"]["linear"] = "iterative";
    CoupledCase run(json);
    const fsi::StepReport result = run.step();
    report("cavity Re 1000, linear solves by " + way, result.newton);
    const Snapshot found = run.snapshot();
    if (expected.velocity.empty()) {
      expected = found;
      continue;
    }
    const double gap = relative_difference(found.velocity, expected.velocity);
    report("cavity Re 1000, " + way + " - newton", gap);
    EXPECT_LE(gap, 1e-6);
    record({.section = "Fluid",
            .check = "steady lid-driven cavity from rest, Re 1000, 16^2 cells: " + way + " against newton",
            .source = "identity",
            .reference = 0,
            .ours = gap,
            .bar = "1e-6"});
  }
}

/// Largest nodal error of the projected velocity, relative to the largest velocity.
double projection_error(int cells) {
  Json json = parse_json(R"json({
    "fluid": { "density": 1, "viscosity": 0.01, "project_initial_velocity": true,
               "initial_velocity": [0, "-2*cos(pi*x)*sin(pi*y)", 0] },
    "channel": { "size": [1, 1, 0.25], "boundaries": {} }, "time": { "step": 0.01, "end": 0.01 } })json");
  json["channel"]["elements"] = {cells, cells, 2};
  for (const char* face : {"xmin", "xmax", "ymin", "ymax", "zmin", "zmax"})
    json["channel"]["boundaries"][face] = {{"type", "slip"}};
  CoupledCase run(json);
  fluid::LocalArray u(run.fluid().accepted());
  double largest = 0;
  for (Index n = 0; n < run.setup.fluid_mesh->owned_nodes; ++n) {
    const double* x = run.setup.fluid_mesh->node(n);
    const double exact[3] = {std::sin(M_PI * x[0]) * std::cos(M_PI * x[1]),
                             -std::cos(M_PI * x[0]) * std::sin(M_PI * x[1]), 0};
    for (int i = 0; i < 3; ++i)
      largest = std::max(largest, std::abs(u[4 * static_cast<std::size_t>(n) + i] - exact[i]));
  }
  return run.comm().max(largest);
}

// A vortex between slip walls plus a gradient that ends normal to them: only the vortex is left. Both are modes of the
// discrete operators on equal cells, so that what is measured is the iteration.
TEST(Nonlinear, initial_velocity_without_divergence) {
  const double coarse = projection_error(8), fine = projection_error(16);
  report("projection error, 8 cells", coarse);
  report("projection error, 16 cells", fine);
  EXPECT_LE(fine, 1e-3);
  record({.section = "Fluid",
          .check = "initial velocity = vortex + gradient, projected: the vortex is left, 16 cells, largest nodal error",
          .source = "exact solution",
          .reference = 0,
          .ours = fine,
          .bar = "1e-3"});
}

}  // namespace
}  // namespace fbi::test
