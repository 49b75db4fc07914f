/// Limits in which the coupled solution is known from one field alone; the same solution by other meshes and solvers.
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

Json fast() {
  Json json = small_beam(R"({ "time": { "step": 1e-3, "end": 0.02 } })");
  set_inflow(json, 20.0, 0.01);
  tighten(json, 1e-11, 1e-8);
  return json;
}

constexpr int steps = 10;

// The flow does not feel a fiber whose penalty vanishes, and differs by a force of first order in the penalty.
TEST(Limits, vanishing_penalty_leaves_the_flow_alone) {
  Json json = fast();
  Json alone = json;
  alone.erase("fibers");
  alone.erase("coupling");
  alone["output"].erase("probes");
  alone["time"].erase("beam");
  CoupledCase flow(alone);
  flow.run(steps);
  const std::vector<double> expected = flow.snapshot().velocity;
  double difference[2];
  for (const int k : {0, 1}) {
    json["coupling"]["penalty"] = k == 0 ? 1e-7 : 1e-11;
    CoupledCase coupled(json);
    coupled.run(steps);
    difference[k] = relative_difference(coupled.snapshot().velocity, expected);
  }
  report("flow at penalty 1e-7, difference", difference[0]);
  report("flow at penalty 1e-11, difference", difference[1]);
  EXPECT_LE(difference[1], 1e-9);
  EXPECT_GT(difference[0], 1e-9) << "the fiber must be seen at all";
}

// A fiber with a load of its own moves as without fluid when the penalty vanishes.
TEST(Limits, vanishing_penalty_leaves_the_fiber_alone) {
  Json json = fast();
  json["fibers"][0]["loads"] =
      parse_json(R"json([ { "type": "force", "at": "end", "value": ["0.04*sin(300*t)", 0, 0] } ])json");
  Json alone = json;
  for (const char* key : {"fluid", "channel", "coupling", "solver"}) alone.erase(key);
  alone["time"].erase("fluid");
  CoupledCase fiber(alone);
  fiber.run(steps);
  const std::vector<double> expected = fiber.snapshot().displacement;
  double difference[2];
  for (const int k : {0, 1}) {
    json["coupling"]["penalty"] = k == 0 ? 1e-3 : 1e-11;
    CoupledCase coupled(json);
    coupled.run(steps);
    difference[k] = relative_difference(coupled.snapshot().displacement, expected);
  }
  report("fiber alone, tip", fiber.tip().norm());
  report("fiber at penalty 1e-3, difference", difference[0]);
  report("fiber at penalty 1e-11, difference", difference[1]);
  EXPECT_GT(fiber.tip().norm(), 0.01);
  EXPECT_LE(difference[1], 1e-8);
  EXPECT_GT(difference[0], 1e-4) << "the flow must be felt at all";
}

// A fiber of growing stiffness comes to take the force of a fixed one, with an error of the order of its compliance.
TEST(Limits, stiff_fiber_is_a_fixed_one) {
  Json json = fast();
  Json fixed = json;
  fixed["fibers"][0] = parse_json(R"({ "name": "beam", "elements": 4, "formulation": "fixed",
      "curve": { "type": "line", "from": [1.51, 0, 0.03], "to": [1.51, 0.5, 0.03] } })");
  fixed["time"].erase("beam");
  json["time"]["beam"]["rho_inf"] = 0.0;
  CoupledCase still(fixed);
  still.run(steps);
  double drag[2], flow[2];
  for (const int k : {0, 1}) {
    json["fibers"][0]["material"] = {{"young", k == 0 ? 1e11 : 1e13}, {"density", 10}};
    CoupledCase stiff(json);
    stiff.run(steps);
    drag[k] = (stiff.drag() - still.drag()).norm() / still.drag().norm();
    flow[k] = relative_difference(stiff.snapshot().velocity, still.snapshot().velocity);
    report("stiffness 1e" + std::to_string(11 + 2 * k) + ", drag difference", drag[k]);
    report("stiffness 1e" + std::to_string(11 + 2 * k) + ", flow difference", flow[k]);
  }
  EXPECT_LE(drag[1], 1e-3);
  EXPECT_LE(flow[1], 1e-3);
  EXPECT_LE(flow[1], flow[0] / 50.0);
}

/// Runs both and asks for the same solution to solver tolerance after every step.
void expect_same(const std::string& name, CoupledCase& a, CoupledCase& b) {
  double worst[3] = {0.0, 0.0, 0.0};
  for (int step = 0; step < steps && !::testing::Test::HasFailure(); ++step) {
    a.step();
    b.step();
    const Snapshot x = a.snapshot(), y = b.snapshot();
    worst[0] = std::max(worst[0], relative_difference(y.velocity, x.velocity));
    worst[1] = std::max(worst[1], relative_difference(y.displacement, x.displacement));
    worst[2] = std::max(worst[2], relative_difference(y.lambda, x.lambda));
  }
  report(name + ", fluid velocity", worst[0]);
  report(name + ", displacement", worst[1]);
  report(name + ", lambda", worst[2]);
  for (const double difference : worst) EXPECT_LE(difference, 1e-8);
}

// The mesh as a box and as hexahedra of any shape: other kernels, another search, another preconditioner.
TEST(Limits, general_mesh_gives_the_same) {
  Json json = fast();
  CoupledCase box(json);
  json["channel"]["general"] = true;
  CoupledCase general(json);
  EXPECT_TRUE(box.setup.fluid_mesh->box.has_value());
  EXPECT_FALSE(general.setup.fluid_mesh->box.has_value());
  expect_same("general mesh", box, general);
}

// Multipliers eliminated and iterated on, and multipliers as unknowns of a sparse factorisation; at a large penalty
// too.
TEST(Limits, direct_solver_gives_the_same) {
  for (const double penalty : {1e2, 1e6}) {
    Json json = fast();
    json["coupling"]["penalty"] = penalty;
    json["solver"]["linear"] = "iterative";
    CoupledCase iterative(json);
    json["solver"]["linear"] = "direct";
    CoupledCase direct(json);
    expect_same("direct solver, penalty " + log::format("%g", penalty), iterative, direct);
    EXPECT_TRUE(direct.system().solver().is_direct());
    EXPECT_FALSE(iterative.system().solver().is_direct());
  }
}

}  // namespace
}  // namespace fbi::test
