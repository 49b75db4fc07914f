/// A slender fiber with shear and torsion in the stream: it moves as the torsion-free one, in both coupling schemes.
#include "record.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

Json stream(const char* formulation, const char* scheme = "monolithic") {
  Json json = small_beam(R"({ "time": { "step": 5e-4, "end": 0.02 } })");
  set_inflow(json, 40.0, 0.02);
  json["fibers"][0]["formulation"] = formulation;
  if (std::string(formulation) == "simo_reissner") json["fibers"][0]["material"]["poisson"] = 0.3;
  json["coupling"]["scheme"] = scheme;
  tighten(json);
  return json;
}

TEST(SimoReissner, SlenderFiberMovesAsTheTorsionFreeOne) {
  CoupledCase shear(stream("simo_reissner")), plain(stream("torsion_free"));
  double difference = 0.0, scale = 0.0;
  int newton = 0;
  for (int step = 1; step <= 40; ++step) {
    newton = std::max(newton, shear.step().newton);
    plain.step();
    difference = std::max(difference, (shear.tip() - plain.tip()).norm());
    scale = std::max(scale, plain.tip().norm());
  }
  report("largest tip displacement", scale);
  report("difference, relative", difference / scale);
  report("most Newton iterations", newton);
  EXPECT_GT(scale, 0.05);
  EXPECT_LE(difference, 1e-2 * scale);
  EXPECT_LE(newton, 8);
  record({.section = "Coupling",
          .id = "",
          .check = "simo_reissner against torsion_free in the oscillating channel, 4 elements, L/R = 89: tip "
                   "displacement, largest difference over largest displacement",
          .source = "Kirchhoff limit",
          .reference = 0.0,
          .ours = difference / scale,
          .bar = "1e-2"});
}

TEST(SimoReissner, MonolithicAndAitkenReachTheSameStep) {
  CoupledCase monolithic(stream("simo_reissner")), aitken(stream("simo_reissner", "aitken"));
  double difference = 0.0, scale = 0.0;
  for (int step = 1; step <= 8; ++step) {
    monolithic.step();
    aitken.step();
    difference = std::max(difference, (monolithic.tip() - aitken.tip()).norm());
    scale = std::max(scale, monolithic.tip().norm());
  }
  report("monolithic against aitken", difference / scale);
  EXPECT_LE(difference, 1e-8 * scale);
  record({.section = "Coupling",
          .id = "",
          .check = "simo_reissner: monolithic against aitken, tip displacement after 8 steps",
          .source = "identity",
          .reference = 0.0,
          .ours = difference / scale,
          .bar = "1e-8"});
}

}  // namespace
}  // namespace fbi::test
