/// Channels with a cylinder (benchmarks of Schaefer and Turek 1996) from the cases of the repository.
#pragma once

#include "case/probes.hpp"
#include "record.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {

/// A case of the repository on other meshes: `around` cells along the circle, one layer of this depth.
inline Json cylinder_case(const std::string& name, int around, double depth = 0.1) {
  Json json = read_case(name);
  json["channel"]["size"][2] = depth;
  json["channel"]["cylinder"]["around"] = around;
  for (Json& probe : json["output"]["probes"]) probe["point"][2] = depth / 2;
  Json& force = json["output"]["forces"][0];
  force["moment_about"][2] = depth / 2;
  force["coefficient"]["area"] = 0.1 * depth;
  return json;
}

/// Drag, lift and pressure difference between the front and the back of the cylinder.
struct Cylinder {
  double drag, lift, pressure;
};

/// From the probes and forces of the accepted state.
inline Cylinder cylinder_values(CoupledCase& run, const cases::ProbeSet& probes) {
  const std::vector<double> values = probes.values(run.system());
  const auto value = [&](const std::string& column) {
    const auto found = std::find(probes.columns().begin(), probes.columns().end(), column);
    EXPECT_NE(found, probes.columns().end()) << column;
    return values.at(static_cast<std::size_t>(found - probes.columns().begin()));
  };
  return {value("cylinder:coefficient_x"), value("cylinder:coefficient_y"),
          value("point/0:pressure") - value("point/1:pressure")};
}

/// The flow of cases/dfg-2d-1, steady.
inline Cylinder steady_cylinder(int around, double depth = 0.1, const std::string& tau = "whiting_jansen") {
  Json json = cylinder_case("dfg-2d-1", around, depth);
  json["fluid"]["tau"] = tau;
  CoupledCase run(json);
  cases::ProbeSet probes(run.setup.parameters.output.probes, run.fibers(), run.setup.fluid_mesh.get());
  probes.add_forces(run.setup.parameters.output.forces, run.setup.fluid.get());
  run.step();
  return cylinder_values(run, probes);
}

/// Reference values of test 2D-1.
inline constexpr Cylinder reference_2d_1 = {5.57953523384, 0.010618948146, 0.11752016697};

/// Prints and records one mesh of test 2D-1.
/// @param order  against the mesh of half as many cells; not_given without one
/// @param bar    admissible relative errors
inline void record_2d_1(const char* mesh, const Cylinder& ours, const Cylinder& order, const Cylinder& bar) {
  const auto row = [&](const char* name, double value, double reference, double observed, double most) {
    report(std::string("2D-1 ") + name + ", " + mesh, value);
    if (observed == observed) report(std::string("2D-1 order of ") + name + ", " + mesh, observed);
    EXPECT_LT(std::abs(value / reference - 1), most) << name;
    record({.section = "General meshes",
            .id = "S-F5",
            .check = std::string("flow past a cylinder at Re 20, ") + name + ", " + mesh + " cells around",
            .source = "Schaefer and Turek 1996, spectral values",
            .reference = reference,
            .ours = value,
            .order = observed,
            .bar = log::format("%.2g %%", 100 * most)});
  };
  row("drag", ours.drag, reference_2d_1.drag, order.drag, bar.drag);
  row("lift", ours.lift, reference_2d_1.lift, order.lift, bar.lift);
  row("pressure difference", ours.pressure, reference_2d_1.pressure, order.pressure, bar.pressure);
}

}  // namespace fbi::test
