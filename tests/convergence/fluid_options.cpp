// Ethier and Steinman (1994): orders in space, 8 to 16 cells a side, for every convective form, tau and pressure
// stabilisation.
#include <gtest/gtest.h>

#include "convergence/ethier_steinman.hpp"
#include "record.hpp"

namespace fbi::fluid::test {
namespace {

struct Variant {
  const char* name;
  void (*set)(FluidParameters&);
  double warp = 0;
};

const Variant variants[] = {
    {"conservative", [](FluidParameters& p) { p.convective_form = ConvectiveForm::conservative; }},
    {"skew", [](FluidParameters& p) { p.convective_form = ConvectiveForm::skew; }},
    {"whiting_jansen", [](FluidParameters& p) { p.tau = Tau::whiting_jansen; }},
    {"whiting_jansen, tau_time off",
     [](FluidParameters& p) {
       p.tau = Tau::whiting_jansen;
       p.tau_time = false;
     }},
    {"taylor_hughes_zarins", [](FluidParameters& p) { p.tau = Tau::taylor_hughes_zarins; }},
    {"franca_valentin at the points", [](FluidParameters& p) { p.tau_at = TauAt::quadrature_points; }},
    {"franca_valentin of the iteration", [](FluidParameters& p) { p.tau_update = TauUpdate::iteration; }},
    {"projection", [](FluidParameters& p) { p.pressure_stabilization = PressureStabilization::projection; }},
    {"skew, whiting_jansen at the points, projection, warped",
     [](FluidParameters& p) {
       p.convective_form = ConvectiveForm::skew;
       p.tau = Tau::whiting_jansen;
       p.tau_at = TauAt::quadrature_points;
       p.pressure_stabilization = PressureStabilization::projection;
     },
     0.1},
};

TEST(FluidOptions, OrderInSpaceOfEthierSteinman) {
  linalg::initialize_petsc();
  for (const Variant& variant : variants) {
    FluidParameters p = Flow::fluid(true);
    variant.set(p);
    const auto run = [&](int cells) {
      Flow flow(uniform(-1, 1, cells), variant.warp, 0.5, p, 0.1, 10);
      const Errors e = errors(flow.field, [](const Vec3& x, double* value) { exact(x, 0.1, value); });
      std::printf("%s, %d cells a side: velocity %.4e pressure %.4e, Newton iterations %d\n", variant.name, cells,
                  e.velocity, e.pressure, flow.newton);
      return e;
    };
    const Errors coarse = run(8), fine = run(16), order = orders(coarse, fine, 2);
    EXPECT_GE(order.velocity, 1.75) << variant.name;
    EXPECT_GE(order.pressure, 1.4) << variant.name;
    const auto row = [&](const char* what, double error, double observed, const char* bar) {
      fbi::test::record(
          {.section = "Fluid",
           .id = "S-F1",
           .check = std::string("Ethier-Steinman, ") + what + ", L2 error, 16 cells a side: " + variant.name,
           .source = "Ethier, Steinman 1994",
           .ours = error,
           .error = error,
           .order = observed,
           .bar = bar});
    };
    row("velocity", fine.velocity, order.velocity, "order >= 1.75");
    row("pressure", fine.pressure, order.pressure, "order >= 1.4");
  }
}

}  // namespace
}  // namespace fbi::fluid::test
