/// Positions of the coupling terms in time: what lagging and extrapolating cost against iterating.
#include <algorithm>
#include <cmath>

#include "record.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

/// Tip displacement at the multiples of `every`.
std::vector<double> tips(const char* update, double dt, double every, double end) {
  Json json = small_beam();
  json["time"]["step"] = dt;
  json["time"]["end"] = end;
  set_inflow(json, 40.0, 0.02);
  json["coupling"]["geometry_update"] = update;
  tighten(json, 1e-9, 1e-6);
  CoupledCase run(json);
  std::vector<double> result;
  for (int k = 0; k < std::lround(end / every); ++k) {
    run.run(static_cast<int>(std::lround(every / dt)));
    result.push_back(run.tip()[0]);
  }
  return result;
}

double largest_distance(const std::vector<double>& a, const std::vector<double>& b) {
  double largest = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) largest = std::max(largest, std::abs(a[k] - b[k]));
  return largest;
}

// Everything but the positions is the same, so that the distance to the iterated solution is theirs alone.
TEST(GeometryUpdate, OrdersInTime) {
  const double step = 5e-4, end = 0.016;
  double lagged[2], extrapolated[2];
  for (int k = 0; k < 2; ++k) {
    const double dt = step / (1 << k);
    const std::vector<double> iterated = tips("iterated", dt, step, end);
    lagged[k] = largest_distance(tips("lagged", dt, step, end), iterated);
    extrapolated[k] = largest_distance(tips("extrapolated", dt, step, end), iterated);
    report("lagged", lagged[k]);
    report("extrapolated", extrapolated[k]);
  }
  const double first = std::log2(lagged[0] / lagged[1]), second = std::log2(extrapolated[0] / extrapolated[1]);
  record(
      {.section = "Coupling",
       .check = "largest distance of the tip to iterated geometry, halved time step: lagged, extrapolated",
       .source = "orders 1 and 2",
       .ours_text = log::format("orders %.2f, %.2f; distances %.1e, %.1e", first, second, lagged[1], extrapolated[1]),
       .bar = "0.8, 1.6"});
  EXPECT_GT(first, 0.8);
  EXPECT_GT(second, 1.6);
  EXPECT_LT(extrapolated[1], 0.2 * lagged[1]);
}

TEST(GeometryUpdate, ExtrapolatesFromAcceptedPositions) {
  Json json = small_beam(R"({ "time": { "step": 5e-4, "end": 0.02 } })");
  set_inflow(json, 40.0, 0.02);
  json["coupling"]["geometry_update"] = "extrapolated";
  CoupledCase run(json);
  run.run(3);
  const std::vector<double> before = run.beams().accepted_dofs();
  run.step();
  const std::vector<double> now = run.beams().accepted_dofs(), found = run.system().first_positions();
  double worst = 0.0, moved = 0.0;
  for (std::size_t k = 0; k < now.size(); ++k) {
    worst = std::max(worst, std::abs(found[k] - (2 * now[k] - before[k])));
    moved = std::max(moved, std::abs(now[k] - before[k]));
  }
  EXPECT_GT(run.comm().max(moved), 1e-5);
  EXPECT_LE(run.comm().max(worst), 1e-15);
}

}  // namespace
}  // namespace fbi::test
