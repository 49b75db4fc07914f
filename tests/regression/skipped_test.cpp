/// What a scene does not need is not done: the counts of work of small scenes.
#include "base/counters.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

constexpr int steps = 5;

/// A fiber in a channel, five steps; merged with `changes`.
Json scene(const std::string& changes) {
  Json json = parse_json(R"case({
    "title": "a fiber in a channel",
    "fluid": { "density": 1, "viscosity": 0.1, "body_force": ["0.1*y", 0, 0] },
    "channel": { "size": [2, 1, 0.5], "elements": [8, 4, 2], "boundaries": {
      "xmin": { "type": "inflow", "velocity": ["4*y*(1-y)", 0, 0] },
      "xmax": { "type": "outflow" }, "ymin": { "type": "no_slip" }, "ymax": { "type": "slip" },
      "zmin": { "type": "slip" }, "zmax": { "type": "slip" } } },
    "fibers": [ { "name": "fiber", "curve": { "type": "line", "from": [1, 0.1, 0.2], "to": [1, 0.6, 0.3] },
      "elements": 4, "section": { "radius": 0.01 }, "material": { "young": 1e6, "density": 10 }, "clamped": "start" } ],
    "solver": { "linear": "iterative" },
    "time": { "step": 0.002, "end": 0.01 }
  })case");
  json.merge_patch(parse_json(changes));
  return json;
}

/// Counts of all ranks together after the five steps; fields stay in `kept` on request.
class Work {
 public:
  explicit Work(const Json& json, const std::function<void(CoupledCase&)>& look = {}) {
    reset_counters();
    CoupledCase coupled(json);
    coupled.run(static_cast<int>(coupled.setup.steps));
    for (const Counted& count : counted_work(coupled.comm())) counts_[count.what] = count.number;
    if (look) look(coupled);
  }
  GlobalIndex operator[](const std::string& what) const {
    const auto found = counts_.find(what);
    return found == counts_.end() ? 0 : found->second;
  }

 private:
  std::map<std::string, GlobalIndex> counts_;
};

Json fixed(const std::string& changes = "{}") {
  Json json = scene(changes);
  json["fibers"][0].erase("material");
  json["fibers"][0].erase("clamped");
  json["fibers"][0]["formulation"] = "fixed";
  return json;
}

Json flow(const std::string& changes = "{}") {
  Json json = scene(changes);
  json.erase("fibers");
  return json;
}

void expect_no_beam_work(const Work& work) {
  EXPECT_EQ(work["fiber tangents"], 0);
  EXPECT_EQ(work["fiber solves"], 0);
  EXPECT_EQ(work["condensations"], 0);
  EXPECT_EQ(work["fiber corrections"], 0);
}

TEST(Skipped, MovingFibersNeedAllButNewFactors) {
  const Work work(scene("{}"));
  EXPECT_EQ(work["searches"], steps);
  EXPECT_EQ(work["builds of M"], steps);
  // With lines in the velocity block a factor may be that of an earlier M.
  EXPECT_GE(work["multiplier factorizations"], 1);
  EXPECT_LT(work["multiplier factorizations"], steps);
  EXPECT_GT(work["fiber tangents"], steps);
  EXPECT_GT(work["condensations"], steps);
  EXPECT_GT(work["fiber corrections"], 0);
  EXPECT_GE(work["elements cut"], 4 * (steps - 1));
  EXPECT_EQ(work["tau updates"], steps);
  EXPECT_EQ(work["pressure setups"], 1);
}

// Fibers that are bent far over meet other cells: their blocks are made anew in time, and not in every step.
TEST(Skipped, OldFactorsAreRenewed) {
  Json json = scene(R"({ "time": { "step": 0.01, "end": 0.25 } })");
  json["fibers"][0]["array"] = parse_json(R"({ "counts": [4, 1, 2], "spacing": [0.1, 0, 0.1] })");
  json["fibers"][0]["material"]["young"] = 1e4;
  const Work work(json);
  EXPECT_EQ(work["searches"], 25);
  EXPECT_GE(work["multiplier factorizations"], 2);
  EXPECT_LT(work["multiplier factorizations"], 20);
}

/// Twelve fibers in a few cells: soft ones need no sparse factors, stiff ones under a large penalty and step do,
/// without lines in the velocity block, and both get through.
TEST(Skipped, SparseFactorsAreMadeWhereBlocksDoNotSuffice) {
  const auto many = [](const std::string& changes) {
    Json json = scene(changes);
    json["fibers"][0]["array"] = parse_json(R"({ "counts": [6, 1, 2], "spacing": [0.03, 0, 0.03] })");
    return json;
  };
  const Work soft(many("{}"));
  EXPECT_EQ(soft["multiplier blocks given up"], 0);
  EXPECT_EQ(soft["velocity lines left out"], 0);
  EXPECT_GT(soft["multiplier iterations"], soft["fluid tangent products"]);
  Json stiff = many(R"({ "solver": { "krylov_tolerance": 1e-4, "newton_tolerance": 1e-3 },
                         "coupling": { "penalty": 1e4 }, "time": { "step": 0.05, "end": 0.25 } })");
  stiff["fibers"][0]["material"]["young"] = 1e10;
  const Work work(stiff);
  EXPECT_EQ(work["multiplier blocks given up"], 1);
  EXPECT_GE(work["velocity lines left out"], 1);
  // 499 where solves begin with factors for the S of another iteration, which lead nowhere, and 20 times as many where
  // two ranks share the fibers and know each other's rows by sums alone.
  std::printf("%lld products\n", static_cast<long long>(work["fluid tangent products"]));
  EXPECT_LT(work["fluid tangent products"], 380);
}

TEST(Skipped, WithoutFibersNothingIsSearchedOrKept) {
  const Work work(flow(), [](CoupledCase& coupled) { EXPECT_FALSE(coupled.system().is_coupled()); });
  for (const char* what : {"searches", "builds of M", "elements cut", "multiplier factorizations"})
    EXPECT_EQ(work[what], 0) << what;
  expect_no_beam_work(work);
  EXPECT_GT(work["fluid residuals"], 0);
}

TEST(Skipped, FixedFibersAreSearchedAndFactorizedOnce) {
  // So tight that a step takes more than one linear solve.
  const Work work(fixed(R"({ "solver": { "newton_tolerance": 1e-6 } })"));
  expect_no_beam_work(work);
  EXPECT_EQ(work["searches"], 1);
  EXPECT_EQ(work["builds of M"], 1);
  EXPECT_EQ(work["multiplier factorizations"], 1);
  EXPECT_GE(work["linear solves"], 2 * steps);
}

TEST(Skipped, PrescribedFibersAtRestToo) {
  Json json = fixed();
  json["fibers"][0]["formulation"] = "prescribed";
  json["fibers"][0]["motion"] = {0, "0.01*x", 0};
  const Work work(json);
  expect_no_beam_work(work);
  EXPECT_EQ(work["prescribed fibers placed"], 1);
  EXPECT_EQ(work["searches"], 1);
  EXPECT_EQ(work["multiplier factorizations"], 1);
  json["fibers"][0]["motion"] = {0, "0.01*sin(t)", 0};
  const Work moving(json);
  expect_no_beam_work(moving);
  EXPECT_EQ(moving["searches"], steps);
}

// A scene with fibers of both kinds: only those that move are cut again.
TEST(Skipped, ElementsThatStayedKeepTheirSegments) {
  Json json = scene("{}");
  json["fibers"].push_back(parse_json(R"({ "name": "post", "curve": { "type": "line", "from": [0.6, 0.1, 0.2],
      "to": [0.6, 0.6, 0.2] }, "elements": 6, "section": { "radius": 0.01 }, "formulation": "fixed" })"));
  const Work work(json);
  EXPECT_EQ(work["elements cut"] + work["elements with old segments"], 10 * steps);
  EXPECT_GE(work["elements with old segments"], 6 * (steps - 1));
}

TEST(Skipped, OneWaySolvesEachFieldOnce) {
  const Work fiber_only(scene(R"({ "coupling": { "direction": "fiber_only" } })")), alone(flow());
  for (const char* what : {"fluid residuals", "fluid tangent products", "linear solves"})
    EXPECT_EQ(fiber_only[what], alone[what]) << what;
  EXPECT_EQ(fiber_only["multiplier factorizations"], 0);
  EXPECT_EQ(fiber_only["searches"], steps);
  const Work fluid_only(scene(R"({ "coupling": { "direction": "fluid_only" } })"));
  EXPECT_EQ(fluid_only["fiber solves"], steps);
  EXPECT_EQ(fluid_only["fiber tangents"], 0);
  EXPECT_EQ(fluid_only["condensations"], 0);
  EXPECT_EQ(fluid_only["fiber corrections"], 0);
}

TEST(Skipped, StokesFlowKeepsItsOperator) {
  const std::string stokes = R"("fluid": { "convective_form": "none" })";
  const Work work(flow("{" + stokes + "}"));
  EXPECT_EQ(work["tau updates"], 1);
  EXPECT_EQ(work["pressure setups"], 1);
  EXPECT_EQ(work["velocity weights"], 1);
  const Work direct(fixed("{" + stokes + R"(, "solver": { "linear": "direct" } })"));
  EXPECT_EQ(direct["direct factorizations"], 1);
  EXPECT_EQ(direct["fluid tangents assembled"], 1);
  EXPECT_GE(direct["linear solves"], steps);
  const Work moving(scene("{" + stokes + R"(, "solver": { "linear": "direct" } })"));
  EXPECT_GE(moving["direct factorizations"], steps);  // a second iteration may keep them
}

TEST(Skipped, SteadyFlowHasNoHistory) {
  const Work work(flow(R"({ "time": { "step": null, "end": null, "fluid": { "scheme": "steady" } } })"),
                  [](CoupledCase& coupled) { EXPECT_EQ(coupled.fluid().state().size(), 1U); });
  EXPECT_EQ(work["tau updates"], work["fluid residuals"] + 1);  // one for each iterate, none for steps
}

TEST(Skipped, SmallSteadyFlowIsSolvedDirectlyAndFlowInTimeIsNot) {
  const Work steady(flow(
      R"({ "time": { "step": null, "end": null, "fluid": { "scheme": "steady" } }, "solver": { "linear": "auto" } })"));
  EXPECT_GT(steady["direct factorizations"], 0);
  EXPECT_EQ(steady["fluid tangent products"], 0);
  EXPECT_EQ(steady["pressure setups"], 0);
  EXPECT_EQ(steady["velocity weights"], 0);
  const Work in_time(flow(R"({ "solver": { "linear": "auto" } })"));
  EXPECT_EQ(in_time["direct factorizations"], 0);
  EXPECT_EQ(in_time["fluid tangents assembled"], 0);
  EXPECT_GT(in_time["fluid tangent products"], 0);
}

TEST(Skipped, FibersAloneHaveNoFluid) {
  Json json = scene("{}");
  for (const char* key : {"fluid", "channel", "solver"}) json.erase(key);
  const Work work(json);
  EXPECT_EQ(work["fiber solves"], steps);
  for (const char* what : {"searches", "fluid residuals", "linear solves", "tau updates"}) EXPECT_EQ(work[what], 0);
}

TEST(Skipped, FormulasWithoutTimeAreEvaluatedOnce) {
  const Work constant(flow()), timed(flow(R"case({ "fluid": { "body_force": ["0.1*y*t", 0, 0] },
      "channel": { "boundaries": { "xmin": { "velocity": ["4*y*(1-y)*(1+t)", 0, 0] } } } })case"));
  EXPECT_GT(constant["boundary values evaluated"], 0);
  // At t = 0 and in every step; the other two components of the inflow have no t.
  EXPECT_EQ(timed["boundary values evaluated"],
            constant["boundary values evaluated"] + steps * constant["boundary values evaluated"] / 3);
  EXPECT_EQ(timed["body forces evaluated"], (steps + 1) * constant["body forces evaluated"]);
}

}  // namespace
}  // namespace fbi::test
