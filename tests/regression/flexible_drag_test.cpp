/// A flexible fiber held in a slow stream bends away: trend of local resistances along its length.
#include "regression/straight_fibers.hpp"

namespace fbi::test {
namespace {

constexpr double length = 1.0;
constexpr int cells = 6;  // along the fiber

/// Fiber of length 1 along y, clamped at its start, in a box 3 x 2 x 2 of uniform flow along x.
Json stream(double bending, bool fixed) {
  const double h = length / cells;
  Json json = box_with_fiber(3 * cells, 2 * cells, h, 0.0, 0.0);
  json["channel"]["size"][2] = 2.0;
  json["channel"]["elements"][2] = 2 * cells;
  json["fluid"]["initial_velocity"] = {"1", "0", "0"};
  Json& faces = json["channel"]["boundaries"];
  faces["xmin"] = parse_json(R"({ "type": "inflow", "velocity": ["1", "0", "0"] })");
  faces["xmax"] = parse_json(R"({ "type": "outflow" })");
  for (const char* face : {"ymin", "ymax", "zmin", "zmax"}) faces[face] = parse_json(R"({ "type": "slip" })");
  Json& fiber = json["fibers"][0];
  fiber["curve"]["from"] = {1.0, 0.5, 1.0};
  fiber["curve"]["to"] = {1.0, 1.5, 1.0};
  fiber["elements"] = cells;
  fiber["section"] = {{"area", 3.14159265e-4}, {"inertia", 1e-6}};  // a = 0.01
  json["coupling"] = parse_json(R"({ "operator": "ring", "penalty": "auto" })");
  if (fixed) return json;
  fiber["formulation"] = "torsion_free";
  fiber["clamped"] = "start";
  fiber["material"] = {{"young", bending / 1e-6}, {"density", 1.0}};
  json["time"] = parse_json(R"({ "step": 0.2, "end": 10, "beam": { "rho_inf": 0 } })");
  json["solver"] = {{"linear", "direct"}, {"newton_absolute_tolerance", 1e-7}};
  return json;
}

TEST(FlexibleDrag, ClampedFiberInAStream) {
  CoupledCase straight(stream(0.0, true));
  const double rigid = solve_for_force(straight, length)[0];  // c_perp U
  report("rigid drag", rigid);
  struct Known {
    double eta, x, y, drag;
  };
  for (const Known& known : {Known{1, 0.12320748, 0.99128257, 0.99133}, {5, 0.48291785, 0.85486933, 0.86834}}) {
    CoupledCase run(stream(rigid / known.eta, false));
    run.run(25);
    const Vec3 before = run.tip();
    run.step();
    const Vec3 tip = run.tip();
    EXPECT_LT((tip - before).norm(), 1e-3);
    const auto row = [&](const char* name, double reference, double ours) {
      const std::string check = log::format("clamped fiber in a slow stream, c U L^3/EI %g: %s", known.eta, name);
      report(check, ours);
      record({.section = "Coupling",
              .id = "S-C3",
              .check = check,
              .source = "resistances 2:1 along the fiber, computed independently",
              .reference = reference,
              .ours = ours,
              .bar = "trend, 10 %"});
      EXPECT_NEAR(ours, reference, 0.1 * reference);
    };
    row("reach of the tip", known.x, tip[0]);
    row("height of the tip", known.y, 1 + tip[1]);
    row("drag over that of the straight one", known.drag, run.drag()[0] / rigid);
  }
}

}  // namespace
}  // namespace fbi::test
