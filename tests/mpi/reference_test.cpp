/// The assembled matrix with GMRES and ILU gives the answer of the factorised system, on any number of ranks.
#include "record.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

Json fast(const std::string& scheme) {
  Json json = small_beam(R"({ "time": { "step": 1e-3, "end": 0.02 } })");
  json["coupling"]["scheme"] = scheme;
  set_inflow(json, 20.0, 0.01);
  tighten(json, 1e-11, 1e-9);
  return json;
}

/// Steps of the case by both solvers: the same answer after each, by Krylov iterations that were really taken.
void compare(const std::string& name, Json json, int steps) {
  json["solver"]["linear"] = "direct";
  CoupledCase direct(json);
  json["solver"]["linear"] = "reference";
  CoupledCase reference(json);
  double worst[4] = {0.0, 0.0, 0.0, 0.0};
  int krylov = 0, newton = 0;
  for (int step = 0; step < steps && !::testing::Test::HasFailure(); ++step) {
    direct.step();
    const fsi::StepReport result = reference.step();
    krylov += result.krylov;
    newton += result.newton;
    const Snapshot a = direct.snapshot(), b = reference.snapshot();
    worst[0] = std::max(worst[0], relative_difference(b.velocity, a.velocity));
    worst[1] = std::max(worst[1], relative_difference(b.pressure, a.pressure));
    worst[2] = std::max(worst[2], relative_difference(b.displacement, a.displacement));
    worst[3] = std::max(worst[3], relative_difference(b.lambda, a.lambda));
  }
  report(name + ", velocity", worst[0]);
  report(name + ", pressure", worst[1]);
  report(name + ", displacement", worst[2]);
  report(name + ", lambda", worst[3]);
  report(name + ", iterations of a linear solve", static_cast<double>(krylov) / newton);
  record({.section = "Coupling",
          .check = "assembled matrix with GMRES and ILU against sparse factors, " + name +
                   ": difference of velocity, pressure, displacement, lambda",
          .source = "each other",
          .reference = 0.0,
          .ours_text = log::format("%.0e, %.0e, %.0e, %.0e", worst[0], worst[1], worst[2], worst[3]),
          .bar = "1e-8"});
  for (const double difference : worst) EXPECT_LE(difference, 1e-8);
  EXPECT_GT(krylov, 5 * newton) << "a Krylov method must be at work";
}

TEST(Reference, monolithic) { compare("monolithic", fast("monolithic"), 4); }

TEST(Reference, aitken) { compare("aitken", fast("aitken"), 2); }

// M and the fibers' part of S change within the step, and with them the pattern of the matrix.
TEST(Reference, iterated_geometry_at_a_large_penalty) {
  Json json = fast("monolithic");
  json["coupling"]["geometry_update"] = "iterated";
  json["coupling"]["penalty"] = 1e4;
  compare("iterated geometry, penalty 1e4", json, 4);
}

// A fixed fiber across all axes: a full 3 x 3 block of S for each row, rows of quadratic multipliers.
TEST(Reference, rings_and_a_law_with_directions) {
  Json json = fast("monolithic");
  json["fibers"][0] = parse_json(R"({ "name": "beam", "elements": 4, "formulation": "fixed",
      "section": { "radius": 0.01 },
      "curve": { "type": "line", "from": [1.4, 0.1, 0.015], "to": [1.7, 0.6, 0.045] } })");
  json["time"].erase("beam");
  json["coupling"] = {{"operator", "ring"}, {"penalty", "auto"}, {"multiplier", "quadratic"}};
  compare("rings, penalty auto, quadratic multipliers", json, 3);
}

// Two fibers in one block of S, in a closed channel whose pressure level is free.
TEST(Reference, joined_fibers_in_a_closed_channel) {
  Json json = fast("monolithic");
  json["channel"]["boundaries"]["xmin"] = {{"type", "no_slip"}};
  json["channel"]["boundaries"]["xmax"] = {{"type", "no_slip"}};
  json["fluid"]["body_force"] = {"4000*y*sin(300*t)", "0", "0"};
  Json second = json["fibers"][0];
  second["name"] = "branch";
  second["curve"] = parse_json(R"({ "type": "line", "from": [1.51, 0.5, 0.03], "to": [1.8, 0.5, 0.03] })");
  second.erase("clamped");
  json["fibers"].push_back(second);
  json["joints"] = parse_json(R"([ { "a": "beam", "at_a": "end", "b": "branch", "at_b": "start" } ])");
  compare("joined fibers, closed channel", json, 3);
}

}  // namespace
}  // namespace fbi::test
