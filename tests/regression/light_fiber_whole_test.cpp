/// The whole run of single-beam with light fibers: lambda does not alternate against its largest value. Minutes a run.
#include "regression/light_fiber.hpp"

namespace fbi::test {
namespace {

void check_run(double density) {
  const std::string name = "whole run, rho_b " + log::format("%g", density);
  constexpr int all = 1000;
  const FiberRun theta = measure(name + ", weight theta", light(density, "theta"), all, "lambda below 0.05");
  EXPECT_EQ(theta.failed_step, 0);
  EXPECT_LT(theta.lambda, 0.05);
  measure(name + ", weight 1-alpha_f", light(density, "1-alpha_f"), all);
}

TEST(LightFiberWhole, hundred_times_lighter) { check_run(0.1); }
TEST(LightFiberWhole, thousand_times_lighter) { check_run(0.01); }

}  // namespace
}  // namespace fbi::test
