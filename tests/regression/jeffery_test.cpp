/// A free rigid fiber turns in a shear flow: the law of a fiber without thickness, d(cot phi)/dt = shear rate (Jeffery
/// 1922).
#include "regression/straight_fibers.hpp"

namespace fbi::test {
namespace {

constexpr double pi = std::numbers::pi;

/// Fiber of length 1 in the middle of a box 2 x 2 x 1, u = (y - 1, 0, 0) on its faces x and y.
Json shear_flow(int cells, double angle, double dt, const Json& coupling) {
  const double h = 1.0 / cells;
  Json json = box_with_fiber(2 * cells, 2 * cells, h, 1.0, 1.0);
  json["channel"]["size"][2] = 1.0;
  json["channel"]["elements"][2] = cells;
  json["fluid"]["initial_velocity"] = {"y-1", "0", "0"};
  for (const char* face : {"xmin", "xmax", "ymin", "ymax"})
    json["channel"]["boundaries"][face] = parse_json(R"({ "type": "inflow", "velocity": ["y-1", "0", "0"] })");
  Json& fiber = json["fibers"][0];
  const double x = 0.5 * std::cos(angle), y = 0.5 * std::sin(angle);
  fiber["curve"]["from"] = {1 - x, 1 - y, 0.5};
  fiber["curve"]["to"] = {1 + x, 1 + y, 0.5};
  fiber["elements"] = cells;
  fiber["formulation"] = "rigid";
  fiber["section"] = {{"radius", 0.01}};
  fiber["material"] = {{"density", 1.0}};
  json["coupling"] = coupling;
  json["coupling"]["geometry_update"] = "extrapolated";
  json["time"] = parse_json(R"({ "end": 10, "fluid": { "scheme": "one_step_theta" }, "beam": { "rho_inf": 0.5 } })");
  json["time"]["step"] = dt;
  json["solver"] = {{"linear", "direct"}, {"newton_absolute_tolerance", 1e-7}};
  return json;
}

double cotangent(CoupledCase& run) {
  const std::vector<double>& dofs = run.beams().accepted_dofs();
  const std::size_t last = dofs.size() - 6;
  return (dofs[last] - dofs[0]) / (dofs[last + 1] - dofs[1]);
}

TEST(Jeffery, CotangentLaw) {
  const double first = 150 * pi / 180, last = 20 * pi / 180, dt = 0.08;
  const double time = 1 / std::tan(last) - 1 / std::tan(first);
  const int steps = static_cast<int>(time / dt);
  for (const bool ring : {false, true}) {
    Json coupling = {{"penalty", 1e4}};
    if (ring) coupling = {{"operator", "ring"}, {"penalty", "auto"}};
    CoupledCase run(shear_flow(6, first, dt, coupling));
    const double before = cotangent(run);
    double worst = 0.0;
    for (int k = 1; k <= steps && !HasFailure(); ++k) {
      run.step();
      worst = std::max(worst, std::abs(cotangent(run) - before - k * dt));
    }
    const double ours = (cotangent(run) - before) / (steps * dt);
    const std::string check = log::format(
        "free rigid fiber in shear flow from 150 to 20 degrees, %s: mean of "
        "d(cot phi)/dt over the shear rate",
        ring ? "ring and auto, a/h 0.06" : "center line");
    report(check, ours);
    report("largest deviation of cot phi", worst);
    record({.section = "Coupling",
            .id = "S-H7",
            .check = check,
            .source = "Jeffery 1922, no thickness",
            .reference = 1.0,
            .ours = ours,
            .bar = "5 %"});
    EXPECT_NEAR(ours, 1.0, 0.05);
  }
}

}  // namespace
}  // namespace fbi::test
