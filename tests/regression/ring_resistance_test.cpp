/// Fibers coupled on a ring with the penalty "auto" keep their own radius: resistance of straight fibers on coarse
/// meshes, with no calibration.
#include "regression/relaxation.hpp"

namespace fbi::test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr const char* study = "the same operator in 2D, computed independently";

/// The case with rings, automatic penalty and fibers of this radius.
Json with_ring(Json json, double radius) {
  json["coupling"] = {{"operator", "ring"}, {"penalty", "auto"}};
  json["fibers"][0]["section"] = {{"radius", radius}};
  return json;
}

TEST(Ring, ThinFiberAcrossAnArray) {
  constexpr double radius = 0.005641896, exact = 3.24955742;
  for (const auto& [n, expected] : {std::pair{16, 3.27065}, {17, 3.22272}, {32, 3.27528}, {33, 3.22559}}) {
    const double ours = array_drag(with_ring(array_cell(n), radius), n).resistance;
    const std::string check =
        log::format("ring and auto, square array, a/h %.3g, %d cells, fiber %s: F/(mu U)", radius * n, n, place_of(n));
    check_number("S-H1", check, study, expected, ours, 0.003);
    check_number("S-H1", check, "Hasimoto 1959, cylinders of the fiber's radius", exact, ours, 0.015);
  }
}

TEST(Ring, ThickFiberAcrossAnArray) {
  constexpr double radius = 0.126156626, exact = 15.55782232;
  for (const auto& [n, expected] : {std::pair{32, 15.3334}, {33, 15.6508}}) {
    const double ours = array_drag(with_ring(array_cell(n), radius), n).resistance;
    const std::string check =
        log::format("ring and auto, square array, a/h %.3g, %d cells, fiber %s: F/(mu U)", radius * n, n, place_of(n));
    check_number("S-H1", check, study, expected, ours, 0.003);
    check_number("S-H1", check, "Sangani and Acrivos 1982", exact, ours, 0.025);
    const double line = array_drag(array_cell(n), n).resistance;
    report("center line", line);
    EXPECT_GT(std::abs(line / exact - 1), 0.5) << "the center line does not know the radius";
  }
}

/// A fifth of the array is fiber: beyond what a ring of forces can stand for.
TEST(Ring, DenseArray) {
  constexpr double radius = 0.252313252, exact = 51.52694896;
  const double ours = array_drag(with_ring(array_cell(32), radius), 32).resistance;
  check_number("S-H1", "ring and auto, square array, solid fraction 0.2, 32 cells: F/(mu U)",
               "Sangani and Acrivos 1982", exact, ours, 0.12);
  EXPECT_LT(ours, 0.95 * exact) << "better than the documented limit";
}

/// The law of "auto" in other stabilisations.
TEST(Ring, ThinFiberWithOtherOptions) {
  constexpr double radius = 0.005641896, exact = 3.24955742;
  struct Choice {
    const char* name;
    const char* fluid;
  };
  const Choice choices[] = {{"whiting_jansen", R"({ "tau": "whiting_jansen" })"},
                            {"whiting_jansen with grad-div", R"({ "tau": "whiting_jansen", "grad_div": true })"},
                            {"viscous residual full", R"({ "viscous_residual": "full" })"}};
  for (const Choice& choice : choices)
    for (const int n : {16, 17}) {
      Json json = with_ring(array_cell(n), radius);
      json["fluid"].merge_patch(parse_json(choice.fluid));
      check_number("S-H1",
                   log::format("ring and auto, square array, %s, a/h %.3g, %d cells, fiber %s: F/(mu U)", choice.name,
                               radius * n, n, place_of(n)),
                   "Hasimoto 1959, cylinders of the fiber's radius", exact, array_drag(json, n).resistance, 0.03);
    }
}

TEST(Ring, FiberAlongADuct) {
  for (const auto& [radius, exact] : {std::pair{0.01, 1.57560806}, {0.02, 1.90709472}, {0.05, 2.64182920}})
    for (const int n : {16, 17}) {
      CoupledCase run(with_ring(duct(n), radius));
      check_number("S-H2",
                   log::format("ring and auto, fiber along a square duct, a/h %.3g, %d cells, %s: F/(mu U)", radius * n,
                               n, place_of(n)),
                   "2 pi/ln(0.539 L/a), the fiber's radius", exact, -solve_for_force(run, 2.0 / n)[2], 0.02);
    }
}

TEST(Ring, FiberMidwayBetweenPlates) {
  for (const double k : {0.01, 0.05})
    for (const int n : {16, 17}) {
      CoupledCase run(with_ring(plates(n), 0.5 * k));
      check_number("S-H3",
                   log::format("ring and auto, fiber midway between plates, a/h %.3g, %d cells, %s: F/(mu U)",
                               0.5 * k * n, n, place_of(n)),
                   "Faxen 1946, the fiber's radius", faxen(k), -solve_for_force(run, 2.0 / n)[0], 0.02);
    }
}

TEST(Ring, RelaxationOfABentFiber) {
  const double radius = std::sqrt(1e-4 / pi);  // of the area of the section
  Json changes;
  changes["coupling"] = {{"operator", "ring"}, {"penalty", "auto"}};
  for (const int n : {12, 13})
    check_relaxation(n, 6, radius, "slender fiber of its own radius", 0.04, changes, ", ring and auto,");
}

/// 8 x 8 positions of a fiber in its cell; symmetry leaves 5 x 5. The flow has a part across and one along the fiber.
TEST(Ring, PositionsInTheCell) {
  const int n = 32;
  const auto drag = [&](int i, int j, bool on_ring) {
    Json json = periodic_array(n, 0.5 + i / (8.0 * n), 0.5 + j / (8.0 * n));
    json["fluid"]["body_force"] = {"1e6", "0", "1e6"};
    json["channel"]["boundaries"]["zmin"] = parse_json(R"({ "type": "periodic", "with": "zmax" })");
    json["channel"]["boundaries"]["zmax"] = parse_json(R"({ "type": "periodic", "with": "zmin" })");
    if (on_ring) json = with_ring(json, 0.1 / n);
    CoupledCase run(json);
    const Vec3 force = solve_for_force(run, 2.0 / n), velocity = mean_velocity(run);
    return std::array{force[0] / velocity[0], force[2] / velocity[2]};
  };
  const auto spread = [&](const std::vector<std::array<double, 2>>& drags, const std::vector<double>& weights,
                          int way) {
    double low = drags[0][way], high = low, sum = 0.0, all = 0.0;
    for (std::size_t k = 0; k < drags.size(); ++k) {
      low = std::min(low, drags[k][way]);
      high = std::max(high, drags[k][way]);
      sum += weights[k] * drags[k][way];
      all += weights[k];
    }
    return (high - low) / (sum / all);
  };
  std::vector<std::array<double, 2>> rings, lines;
  std::vector<double> weights;
  for (int i = 0; i <= 4; ++i)
    for (int j = 0; j <= 4; ++j) {
      rings.push_back(drag(i, j, true));
      weights.push_back((i == 0 || i == 4 ? 1.0 : 2.0) * (j == 0 || j == 4 ? 1.0 : 2.0));
    }
  for (const int i : {0, 4}) lines.push_back(drag(i, i, false));
  constexpr const char* ways[2] = {"across", "along"};
  for (const int way : {0, 1}) {
    const double ours = spread(rings, weights, way), line = spread(lines, {1.0, 1.0}, way);
    report(std::string("spread of the drag, ring and auto, ") + ways[way], ours);
    report(std::string("spread of the drag, center line, ") + ways[way], line);
    record(
        {.section = "Coupling",
         .check = log::format("ring and auto, 8 x 8 positions in the cell, a/h 0.1, flow %s: (max - min)/mean of the "
                              "drag; center line between node and middle of cells: %.2f",
                              ways[way], line),
         .source = "a fiber that slides through cells",
         .reference = 0.0,
         .ours = ours,
         .bar = "2 %, center line above 40 %"});
    EXPECT_LT(ours, 0.02);
    EXPECT_GT(line, 0.4);
  }
}

}  // namespace
}  // namespace fbi::test
