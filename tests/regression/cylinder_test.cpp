/// Steady flow past a cylinder on coarse meshes, and pressures read at points of a general mesh.
#include "regression/cylinder.hpp"

#include "record.hpp"

namespace fbi::test {
namespace {

// Measured: drag 0.12 %, lift 10 %, pressure 0.24 %.
TEST(Cylinder, drag_lift_and_pressure_at_re_20) {
  const Cylinder ours = steady_cylinder(64);
  record_2d_1("64", ours, {not_given, not_given, not_given}, {0.0015, 0.12, 0.003});
  // The flow is plane: with tau of the metric the depth of the one layer does not matter where it is large; with tau of
  // V^(1/3) it does.
  const Cylinder deep = steady_cylinder(64, 0.4);
  report("2D-1 change of lift with four times the depth", deep.lift / ours.lift - 1);
  EXPECT_NEAR(deep.drag, ours.drag, 1e-4 * ours.drag);
  EXPECT_NEAR(deep.lift, ours.lift, 5e-3 * ours.lift);
  EXPECT_NEAR(deep.pressure, ours.pressure, 1e-3 * ours.pressure);
  const Cylinder cube_root = steady_cylinder(64, 0.1, "franca_valentin");
  report("2D-1 lift with franca_valentin, relative", cube_root.lift / reference_2d_1.lift);
  report("2D-1 pressure difference with franca_valentin, relative", cube_root.pressure / reference_2d_1.pressure);
  EXPECT_LT(cube_root.pressure, 0.95 * reference_2d_1.pressure);
}

// Fluid at rest under a body force: the pressure is linear, so that probes read it exactly wherever they lie.
TEST(Cylinder, probes_of_a_linear_pressure) {
  Json json = cylinder_case("dfg-2d-1", 32, 0.01);
  json["fluid"] = parse_json(R"({ "density": 2, "viscosity": 0.1, "body_force": [1, -3, 0.5] })");
  json["channel"]["boundaries"]["xmin"] = json["channel"]["boundaries"]["cylinder"];
  json["channel"]["boundaries"]["xmax"] = json["channel"]["boundaries"]["cylinder"];
  json["output"].erase("forces");
  const double points[][3] = {{0.15, 0.2, 0.003}, {0.25, 0.2, 0.01}, {0.2513, 0.1871, 0.0}, {0.31, 0.33, 0.0071},
                              {1.7, 0.02, 0.004}, {0, 0, 0},         {2.2, 0.41, 0.01}};
  json["output"]["probes"] = Json::array();
  for (const auto& p : points) json["output"]["probes"].push_back({{"point", {p[0], p[1], p[2]}}});
  CoupledCase run(json);
  const cases::ProbeSet probes(run.setup.parameters.output.probes, run.fibers(), run.setup.fluid_mesh.get());
  run.step();
  const std::vector<double> values = probes.values(run.system());
  const auto exact = [](const double* p) { return 2 * (p[0] - 3 * p[1] + 0.5 * p[2]); };
  double error = 0.0;
  for (std::size_t k = 1; k < std::size(points); ++k)
    error = std::max(error, std::abs(values[4 * k + 3] - values[3] - exact(points[k]) + exact(points[0])));
  report("probes of a linear pressure, error", error);
  EXPECT_LT(error, 1e-7);
  record({.section = "General meshes",
          .id = "",
          .check = "pressure probes in a channel with a cylinder, fluid at rest under a body force",
          .source = "exact solution",
          .error = error,
          .bar = "1e-7"});
}

}  // namespace
}  // namespace fbi::test
