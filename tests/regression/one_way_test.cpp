/// One-way coupling: the field that does not feel the other is bitwise the one without it.
#include <cmath>

#include "record.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

Json one_way(const char* direction) {
  Json json = small_beam(R"({ "time": { "step": 5e-4, "end": 0.02 } })");
  set_inflow(json, 40.0, 0.02);
  json["fibers"][0]["loads"] = {{{"type", "force"}, {"value", {"0.02*sin(100*t)", 0, 0}}}};
  json["coupling"]["direction"] = direction;
  return json;
}

constexpr int steps = 8;

TEST(OneWay, FiberOnlyLeavesTheFluidAlone) {
  CoupledCase run(one_way("fiber_only"));
  Json json = one_way("fiber_only");
  json.erase("fibers");
  json.erase("coupling");
  json["time"].erase("beam");
  json["output"].erase("probes");
  CoupledCase alone(json);
  Index different = 0;
  double worst = 0.0, largest = 0.0;
  for (int step = 0; step < steps; ++step) {
    run.step();
    alone.step();
    fluid::LocalArray a(run.fluid().accepted()), b(alone.fluid().accepted());
    for (std::size_t i = 0; i < 4 * static_cast<std::size_t>(run.setup.fluid_mesh->owned_nodes); ++i)
      different += a[i] != b[i];
    // lambda = eps/kappa (M v_f - D v_b)
    const std::vector<double> slip = run.system().slip();
    for (std::size_t k = 0; k < slip.size(); ++k) {
      const double force = run.system().coupling_parameters().penalty * slip[k] / run.coupling().kappa()[k / 3];
      worst = std::max(worst, std::abs(run.system().lambda()[k] - force));
      largest = std::max(largest, std::abs(force));
    }
  }
  EXPECT_EQ(run.comm().sum(static_cast<GlobalIndex>(different)), 0);
  worst = run.comm().max(worst) / run.comm().max(largest);
  report("fiber_only, force against eps times slip", worst);
  record({.section = "Coupling",
          .check = "fiber_only: the fluid is bitwise that without fibers; force of the fiber against eps times slip",
          .source = "identity",
          .reference = 0.0,
          .ours = worst,
          .bar = "1e-12"});
  EXPECT_LE(worst, 1e-12);
  EXPECT_GT(run.tip().norm(), 1e-3);
}

// A free fiber across a uniform flow U: rho_b A dv/dt = eps (U - v). The force of the step's end makes
// generalised-alpha with rho_inf = 1 the implicit Euler rule for v: v_(n+1) = (v_n + k U)/(1 + k), k = eps dt/(rho_b
// A).
TEST(OneWay, FreeFiberIsCarriedAway) {
  Json json = small_beam(R"({ "time": { "step": 5e-4, "end": 0.02 } })");
  json["channel"]["elements"] = {12, 6, 2};
  json["fluid"]["initial_velocity"] = {2, 0, 0};
  json["channel"]["boundaries"]["xmin"]["velocity"] = {2, 0, 0};
  json["fibers"][0].erase("clamped");
  json["fibers"][0]["curve"]["from"] = {1.51, 0.25, 0.03};
  json["fibers"][0]["curve"]["to"] = {1.51, 0.75, 0.03};
  json["coupling"] = {{"direction", "fiber_only"}, {"penalty", 0.5}};
  tighten(json);
  CoupledCase run(json);
  const double k = 0.5 * 5e-4 / (10.0 * M_PI * 0.0056419 * 0.0056419);
  double v = 0.0, x = 0.0, worst = 0.0;
  for (int step = 0; step < 30; ++step) {
    run.step();
    const double before = v;
    v = (v + 2.0 * k) / (1.0 + k);
    x += 0.5 * 5e-4 * (before + v);
    worst = std::max(worst, std::abs(run.tip()[0] - x) / x);
  }
  report("fiber carried away", worst);
  record({.section = "Coupling",
          .check = "fiber_only: free fiber in uniform flow, drag eps (U - v): displacement",
          .source = "recursion by hand",
          .reference = x,
          .ours = run.tip()[0],
          .bar = "1e-9"});
  EXPECT_LE(worst, 1e-9);
}

TEST(OneWay, FluidOnlyLeavesTheFibersAlone) {
  for (const char* update : {"lagged", "extrapolated", "iterated"}) {
    Json json = one_way("fluid_only");
    json["coupling"]["geometry_update"] = update;
    CoupledCase run(json);
    json.erase("fluid");
    json.erase("channel");
    json.erase("coupling");
    json.erase("solver");
    json["time"].erase("fluid");
    json["output"].erase("probes");
    CoupledCase alone(json);
    for (int step = 0; step < steps; ++step) {
      run.step();
      alone.step();
      const auto a = run.beams().state(), b = alone.beams().state();
      ASSERT_EQ(a.size(), b.size());
      for (std::size_t k = 0; k < a.size(); ++k) EXPECT_EQ(*a[k].second, *b[k].second) << a[k].first;
      for (const double force : run.system().last_force()) EXPECT_EQ(force, 0.0);
    }
    EXPECT_GT(run.tip().norm(), 1e-5);
    EXPECT_GT(run.drag().norm(), 1e-3) << "the fluid feels the fibers";
  }
}

// What holds for fibers that do not move at all: the direction towards them makes no difference.
TEST(OneWay, FluidOnlyOfFixedFibersIsTwoWay) {
  Json json = one_way("two_way");
  json["fibers"][0].erase("loads");
  json["fibers"][0].erase("clamped");
  json["fibers"][0].erase("material");
  json["fibers"][0].erase("section");
  json["fibers"][0]["formulation"] = "fixed";
  CoupledCase both(json);
  json["coupling"]["direction"] = "fluid_only";
  CoupledCase one(json);
  both.run(3);
  one.run(3);
  EXPECT_EQ(both.snapshot().velocity, one.snapshot().velocity);
  EXPECT_EQ(both.snapshot().lambda, one.snapshot().lambda);
}

}  // namespace
}  // namespace fbi::test
