// Ethier and Steinman (1994), exact unsteady 3D solution on (-1,1)^3, a = pi/4, d = pi/2, nu = 1: orders in space and
// time.
#include <gtest/gtest.h>

#include "convergence/ethier_steinman.hpp"

namespace fbi::fluid::test {
namespace {

TEST(EthierSteinman, ExactSolutionMatchesPublishedValues) {
  double v[4];
  exact(Vec3(0, 0, 0), 0.1, v);
  EXPECT_NEAR(v[0], -0.613665930954, 1e-11);
  EXPECT_NEAR(v[3], -0.564878812221, 1e-11);
  exact(Vec3(0.5, -0.25, 0.75), 0.1, v);
  EXPECT_NEAR(v[0], -1.861651781295, 1e-11);
  EXPECT_NEAR(v[1], -0.999490021100, 1e-11);
  EXPECT_NEAR(v[2], -0.098377145412, 1e-11);
  EXPECT_NEAR(v[3], -2.237202859909, 1e-11);
  const input::VectorExpression f = formulas();
  EXPECT_NEAR(f[1](0.5, -0.25, 0.75, 0.1), v[1], 1e-14);
}

std::vector<double> halved(const std::vector<double>& x) {
  std::vector<double> fine;
  for (std::size_t i = 0; i + 1 < x.size(); ++i) {
    fine.push_back(x[i]);
    fine.push_back(0.5 * (x[i] + x[i + 1]));
  }
  fine.push_back(x.back());
  return fine;
}

// With dt in tau the pair 8/16 is not yet asymptotic: measured 1.84 and 1.49. The finer pair has its own, slower test.
// Graded and warped meshes of the same counts keep the orders.
TEST(EthierSteinman, OrderInSpace) {
  linalg::initialize_petsc();
  const std::vector<double> coarse = uniform(-1, 1, 8), fine = uniform(-1, 1, 16),
                            graded_coarse = graded(-1, 1, 8, 1.15);
  const Errors fine_off = space_errors(fine, 0, false),
               off = orders(space_errors(coarse, 0, false), fine_off, 2);
  record_orders("8 to 16 cells a side, tau_time off", fine_off, off, "order 1.9", "order 1.4");
  EXPECT_GE(off.velocity, 1.9);
  EXPECT_GE(off.pressure, 1.4);
  const Errors fine_box = space_errors(fine, 0, true), box = orders(space_errors(coarse, 0, true), fine_box, 2);
  record_orders("8 to 16 cells a side, tau_time on", fine_box, box, "order 1.8", "order 1.4");
  EXPECT_GE(box.velocity, 1.8);
  EXPECT_GE(box.pressure, 1.4);
  const Errors fine_stretched = space_errors(halved(graded_coarse), 0, true),
               stretched = orders(space_errors(graded_coarse, 0, true), fine_stretched, 2);
  record_orders("graded, 8 to 16 cells a side, tau_time on", fine_stretched, stretched, "box - 0.1", "order 1.4");
  EXPECT_GE(stretched.velocity, box.velocity - 0.1);
  EXPECT_GE(stretched.pressure, 1.4);
  const Errors fine_warped = space_errors(fine, 0.1, true),
               warped = orders(space_errors(coarse, 0.1, true), fine_warped, 2);
  record_orders("general cells, warped, 8 to 16 a side, tau_time on", fine_warped, warped, "box - 0.1", "order 1.4");
  EXPECT_GE(warped.velocity, box.velocity - 0.1);
  EXPECT_GE(warped.pressure, 1.4);
}

// Against the same mesh with 1/16 of the smaller step.
double time_order(double theta, bool tau_time) {
  const std::vector<double> x = uniform(-1, 1, 8);
  const auto difference = [](FluidField& one, FluidField& other) {
    LocalArray u(one.iterate()), v(other.iterate());
    double sum = 0;
    const std::vector<double>& volume = one.lumped_volume();
    for (std::size_t n = 0; n < volume.size(); ++n)
      for (int i = 0; i < 3; ++i) sum += volume[n] * std::pow(u[4 * n + i] - v[4 * n + i], 2);
    return std::sqrt(sum);
  };
  const int steps = 10;
  Flow coarse(x, 0, theta, tau_time, 0.1, steps), fine(x, 0, theta, tau_time, 0.1, 2 * steps),
      reference(x, 0, theta, tau_time, 0.1, 32 * steps);
  const double e1 = difference(coarse.field, reference.field), e2 = difference(fine.field, reference.field);
  const double order = std::log2(e1 / e2);
  std::printf("theta %.1f, tau_time %s: errors in time %.3e %.3e, order %.3f\n", theta, tau_time ? "on" : "off", e1, e2,
              order);
  fbi::test::record({.section = "Fluid",
                     .id = "S-F1",
                     .check = log::format("Ethier-Steinman flow, 8 cells a side, theta = %.1f, tau_time %s: error in "
                                          "time of the velocity against dt/16, order", theta, tau_time ? "on" : "off"),
                     .source = "definition",
                     .ours = e2,
                     .order = order,
                     .bar = tau_time ? "reported" : theta < 1.0 ? "order 2 ± 0.1" : "order 1 ± 0.1"});
  return order;
}

TEST(EthierSteinman, OrderInTime) {
  linalg::initialize_petsc();
  EXPECT_NEAR(time_order(1.0, false), 1.0, 0.1);
  EXPECT_NEAR(time_order(0.5, false), 2.0, 0.1);
  // known effect of dt in tau, reported: no bar
  time_order(1.0, true);
  time_order(0.5, true);
}

}  // namespace
}  // namespace fbi::fluid::test
