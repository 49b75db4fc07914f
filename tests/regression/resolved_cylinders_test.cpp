/// Cylinders that the mesh resolves, in slow flow: the same references as for fibers that it does not.
#include "case/probes.hpp"
#include "regression/straight_fibers.hpp"

namespace fbi::test {
namespace {

constexpr double pi = std::numbers::pi;

void row(const char* id, const std::string& check, const char* source, double reference, double ours, double bar,
         double order = not_given) {
  report(check, ours);
  report("relative error", ours / reference - 1);
  if (order == order) report("order", order);
  record({.section = "General meshes",
          .id = id,
          .check = check,
          .source = source,
          .reference = reference,
          .ours = ours,
          .order = order,
          .bar = log::format("%g %%", 100 * bar)});
  EXPECT_NEAR(ours, reference, bar * std::abs(reference)) << check;
}

/// A box of lx x ly with a cylinder in the middle, as deep as a cell at the cylinder is long; steady Stokes flow.
Json resolved(double lx, double ly, double radius, int cells) {
  Json json = box_with_fiber(1, 1, 1.0, 0.0, 0.0);
  json.erase("fibers");
  json.erase("coupling");
  json["fluid"]["viscous_residual"] = "full";
  json["channel"]["size"] = {lx, ly, 2 * pi * radius / cells};
  json["channel"].erase("elements");
  json["channel"]["cylinder"] = {{"center", {lx / 2, ly / 2}}, {"radius", radius}, {"around", cells}};
  json["channel"]["boundaries"]["cylinder"] = parse_json(R"({ "type": "no_slip" })");
  json["output"]["forces"] = {{{"name", "cylinder"}, {"faces", {"cylinder"}}}};
  json["solver"]["linear"] = "direct";
  return json;
}

struct Flow {
  double force = 0.0, velocity = 0.0;  ///< on the cylinder per length; mean over the whole cell
};

Flow solve(const Json& json) {
  CoupledCase run(json);
  cases::ProbeSet probes(run.setup.parameters.output.probes, run.fibers(), run.setup.fluid_mesh.get());
  probes.add_forces(run.setup.parameters.output.forces, run.setup.fluid.get());
  run.step();
  const Json& size = json["channel"]["size"];
  const double flow = run.fluid().momentum(run.fluid().accepted())[0] / run.fluid().parameters().density;
  return {probes.values(run.system()).at(0) / size[2].get<double>(),
          flow / (size[0].get<double>() * size[1].get<double>() * size[2].get<double>())};
}

TEST(ResolvedCylinder, SquareArray) {
  for (const std::array<double, 2> c : {std::array{0.05, 15.55782232}, {0.2, 51.52694896}}) {
    double error[2] = {0.0, 0.0};
    for (const int level : {0, 1}) {
      const int around = 64;
      Json json = resolved(1.0, 1.0, std::sqrt(c[0] / pi), around << level);
      Json& faces = json["channel"]["boundaries"];
      faces["xmin"] = faces["xmax"] = parse_json(R"({ "type": "mixed", "velocity": [null, "0", "0"],
                                                      "traction": ["0.5", "0", "0"] })");
      faces["ymin"] = faces["ymax"] = parse_json(R"({ "type": "slip" })");
      const Flow flow = solve(json);
      EXPECT_NEAR(flow.force, 1.0, 1e-8);
      const double ours = flow.force / flow.velocity;
      error[level] = ours / c[1] - 1;
      row("S-H1",
          log::format("square array of cylinders, solid fraction %g, %d cells around: F/(mu U)", c[0], around << level),
          "Sangani and Acrivos 1982, by collocation", c[1], ours, level == 0 ? 2e-2 : 5e-3,
          level == 0 ? not_given : std::log2(std::abs(error[0] / error[1])));
    }
    EXPECT_GT(std::log2(std::abs(error[0] / error[1])), 1.5);
  }
}

/// The series of Faxen for cylinders that are not thin: radius 0.1 H and 0.3 H.
TEST(ResolvedCylinder, BetweenPlates) {
  for (const double k : {0.1, 0.3}) {
    Json json = resolved(8.0, 1.0, 0.5 * k, 64);
    for (const char* face : {"xmin", "xmax", "ymin", "ymax"})
      json["channel"]["boundaries"][face] = parse_json(R"({ "type": "inflow", "velocity": ["-1", "0", "0"] })");
    row("S-H3", log::format("cylinder of radius %g H midway between plates, 64 cells around: F/(mu U)", k),
        "Faxen 1946", faxen(k), -solve(json).force, 5e-3);
  }
}

}  // namespace
}  // namespace fbi::test
