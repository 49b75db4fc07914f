/// Coupled fibers of the formulations and schemes beside torsion_free with generalised-alpha.
#include "record.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

// A fiber hinged at the floor, which the flow turns through a large angle.
Json hinged(const std::string& formulation, double young) {
  Json json = small_beam(R"({ "time": { "step": 1e-3, "end": 0.04 } })");
  set_inflow(json, 10.0, 0.08);
  Json& fiber = json["fibers"][0];
  fiber.erase("clamped");
  fiber["pinned"] = "start";
  fiber["formulation"] = formulation;
  fiber["material"]["young"] = young;
  if (formulation == "rigid") fiber["material"].erase("young");
  json["solver"]["newton_tolerance"] = 1e-6;  // far below the difference of the two models
  return json;
}

TEST(Rigid, coupled_is_the_limit_of_a_stiff_fiber) {
  // what is left is the difference of two time discretisations of the rotation
  std::vector<double> difference;
  for (const int steps : {40, 80}) {
    Json stiff = hinged("torsion_free", 1e11), body = hinged("rigid", 0.0);
    stiff["time"]["step"] = body["time"]["step"] = 0.04 / steps;
    CoupledCase rigid(body), flexible(stiff);
    rigid.run(steps);
    flexible.run(steps);
    difference.push_back((rigid.tip() - flexible.tip()).norm() / rigid.tip().norm());
    EXPECT_GT(rigid.tip().norm(), 0.1);
  }
  report("rigid against E = 1e11, dt 1e-3", difference[0]);
  report("rigid against E = 1e11, dt 5e-4", difference[1]);
  EXPECT_LE(difference[0], 2e-4);
  EXPECT_LE(difference[1], 0.5 * difference[0]);
  record({.section = "Coupling",
          .id = "",
          .check = "rigid fiber hinged in a flow against a flexible one, E = 1e11, difference of the tips, dt 5e-4",
          .source = "limit E to infinity",
          .reference = 0.0,
          .ours = difference[1],
          .bar = "half of that at dt 1e-3, which is below 2e-4"});
}

// Both coupling schemes reach the same steps.
void compare_schemes(Json json, const std::string& name) {
  json["coupling"]["geometry_update"] = "iterated";
  tighten(json);
  CoupledCase monolithic(json);
  json["coupling"]["scheme"] = "aitken";
  json["coupling"]["max_iterations"] = 200;
  tighten(json);
  CoupledCase aitken(json);
  monolithic.run(8);
  aitken.run(8);
  const double difference = relative_difference(aitken.snapshot().displacement, monolithic.snapshot().displacement);
  report(name + ", monolithic against aitken", difference);
  EXPECT_LE(difference, 1e-8);
}
TEST(Rigid, monolithic_and_partitioned) { compare_schemes(hinged("rigid", 0.0), "rigid"); }
TEST(Midpoint, monolithic_and_partitioned) {
  Json json = hinged("torsion_free", 1e7);
  json["time"]["beam"] = {{"scheme", "midpoint"}};
  compare_schemes(json, "midpoint");
}

// At rest by formula and at rest by itself; moved by formula the fiber drags the fluid along.
TEST(Prescribed, zero_motion_is_fixed_and_motion_drags_the_fluid) {
  Json json = hinged("fixed", 0.0);
  Json& fiber = json["fibers"][0];
  fiber.erase("pinned");
  fiber.erase("material");
  fiber.erase("section");
  CoupledCase fixed(json);
  fiber["formulation"] = "prescribed";
  fiber["motion"] = {0, 0, 0};
  CoupledCase still(json);
  fixed.run(5);
  still.run(5);
  EXPECT_LE(relative_difference(still.snapshot().velocity, fixed.snapshot().velocity), 1e-14);
  fiber["motion"] = {"2*t^2", 0, 0};
  set_inflow(json, 0.0, 0.08);
  for (const char* update : {"lagged", "iterated"}) {
    json["coupling"]["geometry_update"] = update;
    CoupledCase moved(json);
    moved.run(10);
    EXPECT_NEAR(moved.tip()[0], 2e-4, 1e-15);
    EXPECT_LT(moved.drag()[0], 0.0);
  }
}

}  // namespace
}  // namespace fbi::test
