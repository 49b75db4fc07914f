/// The flow across a square array bends its fibers: the deflection that the drag of the fixed fiber causes.
#include "regression/straight_fibers.hpp"

namespace fbi::test {
namespace {

constexpr double bending = 1.0;

/// Deflection in the middle of a fiber over four cells, times EI/(F l^4); the flow is that of a pressure drop of 1.
double deflection(int n, const char* ends) {
  const int nz = 4;
  const double length = static_cast<double>(nz) / n;
  Json json = array_cell(n);
  json["channel"]["size"][2] = length;
  json["channel"]["elements"][2] = nz;
  Json& fiber = json["fibers"][0];
  fiber["curve"]["to"][2] = length;
  fiber["elements"] = nz;
  fiber["formulation"] = "torsion_free";
  fiber["section"] = {{"area", 1e-4}, {"inertia", 1e-6}};
  fiber["material"] = {{"young", bending / 1e-6}, {"density", 1.0}};
  fiber[ends] = "both";
  json["time"] = parse_json(R"({ "step": 0.02, "end": 1, "beam": { "rho_inf": 0 } })");
  json["solver"] = {{"linear", "direct"}, {"newton_tolerance", 1e-7}, {"newton_absolute_tolerance", 1e-6}};
  CoupledCase run(json);
  run.run(12);
  const double force = run.drag()[0] / length;
  EXPECT_NEAR(force, 1.0, 1e-4);
  const std::size_t node = nz / 2;
  const double w = run.beams().accepted_dofs()[6 * node] - run.fibers().position[3 * node];
  return w * bending / (force * std::pow(length, 4));
}

TEST(LoadTransfer, BeamInTheFlowAcrossAnArray) {
  for (const int n : {12, 13})
    for (const bool clamped : {false, true}) {
      const double ours = deflection(n, clamped ? "clamped" : "pinned"), reference = (clamped ? 1.0 : 5.0) / 384;
      const std::string check = log::format("fiber across an array, %s at both ends, %s: deflection EI/(F l^4)",
                                            clamped ? "clamped" : "pinned", place_of(n));
      report(check, ours);
      record({.section = "Coupling",
              .id = "S-C2",
              .check = check,
              .source = clamped ? "1/384" : "5/384",
              .reference = reference,
              .ours = ours,
              .bar = "0.1 %"});
      EXPECT_NEAR(ours, reference, 1e-3 * reference);
    }
}

}  // namespace
}  // namespace fbi::test
