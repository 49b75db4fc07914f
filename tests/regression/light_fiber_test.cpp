/// Fibers much lighter than the fluid around them: the monolithic scheme does not care, and with equal impulses on
/// fluid and fibers the force does not alternate from step to step.
#include "regression/light_fiber.hpp"

namespace fbi::test {
namespace {

// The stiffest modes of a fiber follow the trapezoidal rule (rho_inf = 1) without damping: the sudden acceleration of
// the flow at t = 0 leaves them ringing, most of all at the clamped foot. That is the fiber's own vibration and not one
// of the coupling: it goes away with rho_inf < 1, does not show in the drag, and over the whole run (the slow test
// light_fiber_whole) it is small against the largest lambda.
void check_fiber(double density) {
  const std::string name = "rho_b " + log::format("%g", density);
  const FiberRun theta = measure(name + ", weight theta", light(density, "theta"), short_run, "drag below 0.05");
  EXPECT_EQ(theta.failed_step, 0);
  EXPECT_LE(theta.newton, 4);
  EXPECT_LT(theta.drag, 0.05);
  const FiberRun damped = measure(name + ", weight theta, rho_inf 0.8", light(density, "theta", 0.8), short_run,
                                  "lambda below 0.05");
  EXPECT_EQ(damped.failed_step, 0);
  EXPECT_LT(damped.lambda, 0.05);
  measure(name + ", weight 1-alpha_f", light(density, "1-alpha_f"));

  // Reported, not asked for: what the partitioned scheme does.
  Json json = light(density, "theta");
  json["coupling"]["scheme"] = "aitken";
  json["coupling"]["max_iterations"] = 200;
  const FiberRun aitken = run_fiber(json, 2);
  report(name + ", aitken, most iterations", aitken.coupling);
  report(name + ", aitken, failed step", aitken.failed_step);
  report(name + ", aitken, residual", aitken.residual);
  report(name + ", aitken, relaxation factor", aitken.relaxation);
  record({.section = "Coupling",
          .check = "light fibers, " + name + ", the same with aitken",
          .source = "definition",
          .ours_text = aitken.failed_step > 0 ? log::format("does not converge in %d iterations of step %d",
                                                            aitken.coupling, aitken.failed_step)
                                              : log::format("at most %d iterations", aitken.coupling),
          .bar = "reported"});
}

TEST(LightFiber, hundred_times_lighter) { check_fiber(0.1); }
TEST(LightFiber, thousand_times_lighter) { check_fiber(0.01); }

// A free fiber in a uniform flow that starts at once. Without stiffness against it, unequal impulses on fluid and fiber
// let the force alternate by a factor -1/(1 + 2 m_b/m_f) a step, m_b the fiber's mass and m_f the fluid's that the mesh
// adds to it, both per length: nearly undamped for a light fiber.
TEST(LightFiber, free_fiber_in_a_sudden_flow) {
  Json theta = light(0.1, "theta"), paper = light(0.1, "1-alpha_f");
  for (Json* json : {&theta, &paper}) {
    (*json)["channel"]["boundaries"]["xmin"]["velocity"] = {"5", "0", "0"};
    (*json)["fibers"][0]["curve"] =
        parse_json(R"({ "type": "line", "from": [1.51, 0.25, 0.03], "to": [1.51, 0.75, 0.03] })");
    (*json)["fibers"][0].erase("clamped");
  }
  const FiberRun equal = measure("free fiber, weight theta", theta, short_run, "drag below 0.05");
  const FiberRun unequal = measure("free fiber, weight 1-alpha_f", paper, short_run, "drag above 1");
  EXPECT_LT(equal.drag, 0.05);
  EXPECT_GT(unequal.drag, 1.0);
}

}  // namespace
}  // namespace fbi::test
