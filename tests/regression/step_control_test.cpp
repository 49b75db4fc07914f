/// Steps that are divided: order of accuracy with steps of changing size, and the way back where the smallest one
/// fails.
#include <cmath>
#include <cstdio>

#include "base/counters.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

/// A flexible fiber in a channel whose flow starts smoothly from rest; 540 unknowns of the fluid.
Json smooth_start(double dt, const std::string& changes) {
  Json json = parse_json(R"({
    "title": "a reed in a flow that starts smoothly",
    "fluid": { "density": 1, "viscosity": 0.05, "tau_time": false },
    "channel": { "size": [2, 1, 0.25], "elements": [8, 4, 2], "boundaries": {
      "xmin": { "type": "inflow", "velocity": ["2*y*(1-y)*(1-cos(12*t))^2", 0, 0] },
      "xmax": { "type": "outflow" }, "ymin": { "type": "no_slip" }, "ymax": { "type": "slip" },
      "zmin": { "type": "slip" }, "zmax": { "type": "slip" } } },
    "fibers": [ { "name": "reed", "curve": { "type": "line", "from": [1, 0, 0.12], "to": [1, 0.5, 0.12] },
      "elements": 3, "section": { "radius": 0.01 }, "material": { "young": 1e6, "density": 10 }, "clamped": "start" } ],
    "coupling": { "geometry_update": "extrapolated" },
    "solver": { "newton_tolerance": 1e-9 },
    "time": { "end": 0.4, "beam": { "rho_inf": 0.8 } }
  })");
  json["time"]["step"] = dt;
  json.merge_patch(parse_json(changes));
  return json;
}

/// Every fourth step does not converge at once: two steps in halves follow, then two whole ones.
bool every_fourth(const fsi::StepClock& clock, double dt) { return clock.step % 4 == 1 && clock.dt > 0.75 * dt; }

Snapshot run(CoupledCase& coupled, bool divided) {
  fsi::StepControl& control = coupled.setup.step_control;
  const double dt = coupled.setup.dt;
  if (divided) control.refuse = [dt](const fsi::StepClock& clock) { return every_fourth(clock, dt); };
  std::string failure;
  const fsi::LoopEnd end = fsi::run_time_loop(
      coupled.system(), coupled.setup.acceleration.get(), control, 0, coupled.setup.steps, dt,
      [divided, dt](const fsi::StepClock& clock, const fsi::StepReport& report) {
        const bool halves = divided && (clock.step - 1) % 4 < 2;
        EXPECT_DOUBLE_EQ(clock.dt, halves ? 0.5 * dt : dt) << "step " << clock.step;
        EXPECT_EQ(report.parts, halves ? 2 : 1) << "step " << clock.step;
        EXPECT_EQ(report.failures, divided && clock.step % 4 == 1 ? 1 : 0) << "step " << clock.step;
        return false;
      },
      failure);
  EXPECT_EQ(end, fsi::LoopEnd::finished) << failure;
  return coupled.snapshot();
}

double distance(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0, size = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    sum += (a[k] - b[k]) * (a[k] - b[k]);
    size += b[k] * b[k];
  }
  return std::sqrt(sum / size);
}

/// Orders of velocity and displacement from 80 to 160 steps, divided, against 640 whole ones.
void check_order(const std::string& changes, double least) {
  log::configure(false, true);
  CoupledCase fine(smooth_start(0.4 / 640, changes));
  const Snapshot reference = run(fine, false);
  double velocity[2], displacement[2];
  for (int k = 0; k < 2; ++k) {
    const double dt = 0.4 / (80 << k);
    CoupledCase whole(smooth_start(dt, changes)), divided(smooth_start(dt, changes));
    const Snapshot at_once = run(whole, false), in_parts = run(divided, true);
    velocity[k] = distance(in_parts.velocity, reference.velocity);
    displacement[k] = distance(in_parts.displacement, reference.displacement);
    // Half of the time is covered by steps of half the size: no worse than whole ones.
    EXPECT_LT(velocity[k], distance(at_once.velocity, reference.velocity));
    EXPECT_LT(displacement[k], distance(at_once.displacement, reference.displacement));
  }
  const double order[2] = {std::log2(velocity[0] / velocity[1]), std::log2(displacement[0] / displacement[1])};
  std::printf("velocity %.3e %.3e: order %.2f, displacement %.3e %.3e: order %.2f\n", velocity[0], velocity[1],
              order[0], displacement[0], displacement[1], order[1]);
  EXPECT_GT(order[0], least);
  EXPECT_GT(order[1], least);
}

TEST(StepControl, IsOfSecondOrderWithTrapezoidalRule) {
  check_order(R"({ "time": { "fluid": { "theta": 0.5 }, "beam": { "rho_inf": 1.0 } } })", 1.7);
}
TEST(StepControl, IsOfSecondOrderWithBdf2) {
  check_order(R"({ "time": { "fluid": { "scheme": "bdf2" } }, "coupling": { "coupling_weight": "1-alpha_f" } })", 1.7);
}

// The same steps, solved in turns: what is predicted from steps of different size is only where the iteration starts.
TEST(StepControl, DoesTheSameInTurns) {
  log::configure(false, true);
  CoupledCase together(smooth_start(0.02, "{}"));
  const Snapshot reference = run(together, true);
  for (const std::string scheme : {"aitken", "iqn_ils"}) {
    CoupledCase in_turns(smooth_start(0.02, R"({ "coupling": { "scheme": ")" + scheme + R"(", "tolerance": 1e-8,
        "force_predictor": "quadratic" } })"));
    const Snapshot result = run(in_turns, true);
    EXPECT_LT(distance(result.velocity, reference.velocity), 1e-5) << scheme;
    EXPECT_LT(distance(result.displacement, reference.displacement), 1e-5) << scheme;
  }
}

/// Largest difference of the pressures at the grid times between divided and whole steps, over the largest pressure.
double pressure_jump(const std::string& changes) {
  log::configure(false, true);
  std::vector<std::vector<double>> pressures[2];
  for (int divided = 0; divided < 2; ++divided) {
    CoupledCase coupled(smooth_start(0.4 / 80, changes));
    const double dt = coupled.setup.dt;
    fsi::StepControl& control = coupled.setup.step_control;
    if (divided > 0) control.refuse = [dt](const fsi::StepClock& clock) { return every_fourth(clock, dt); };
    std::string failure;
    fsi::run_time_loop(
        coupled.system(), nullptr, control, 0, coupled.setup.steps, dt,
        [&](const fsi::StepClock&, const fsi::StepReport&) {
          pressures[divided].push_back(coupled.snapshot().pressure);
          return false;
        },
        failure);
  }
  double largest = 0.0, jump = 0.0;
  for (std::size_t n = 0; n < pressures[0].size(); ++n)
    for (std::size_t k = 0; k < pressures[0][n].size(); ++k) {
      largest = std::max(largest, std::abs(pressures[0][n][k]));
      jump = std::max(jump, std::abs(pressures[1][n][k] - pressures[0][n][k]));
    }
  std::printf("pressure: %.3f of the largest\n", jump / largest);
  return jump / largest;
}

// tau of PSPG has the time step in it: the pressure that goes with a velocity changes with dt. That of the projection
// has not.
TEST(StepControl, PressureAfterAChangeOfStep) {
  EXPECT_LT(pressure_jump(R"({ "fluid": { "tau_time": true } })"), 0.15);
  EXPECT_LT(pressure_jump(R"({ "fluid": { "tau_time": false } })"), 0.05);
  EXPECT_LT(pressure_jump(R"({ "fluid": { "tau_time": null, "pressure_stabilization": "projection" } })"), 0.01);
}

/// The whole of what the next step depends on.
std::vector<double> state_of(CoupledCase& coupled) {
  std::vector<double> all;
  for (const auto& [name, vector] : coupled.fluid().state()) {
    fluid::LocalArray values(vector);
    all.insert(all.end(), values.data(),
               values.data() + 4 * static_cast<std::size_t>(coupled.fluid().mesh().owned_nodes));
  }
  for (const auto& [name, values] : coupled.system().fiber_state())
    all.insert(all.end(), values->begin(), values->end());
  for (const auto& [name, value] : coupled.fluid().scalars()) all.push_back(*value);
  for (const auto& [name, value] : coupled.system().scalars()) all.push_back(*value);
  for (const auto& [name, value] : coupled.setup.step_control.scalars()) all.push_back(*value);
  return all;
}

// The second half of step 7 fails in every size: the state is that after step 6, not that in the middle of step 7.
TEST(StepControl, GoesBackToTheGridWhereTheSmallestPartFails) {
  for (const std::string scheme : {"monolithic", "iqn_ils"}) {
    CoupledCase coupled(
        smooth_start(0.01, R"({ "time": { "halvings": 3 }, "coupling": { "scheme": ")" + scheme + "\" } }"));
    fsi::StepControl& control = coupled.setup.step_control;
    std::string failure;
    const auto go = [&](GlobalIndex from, GlobalIndex to) {
      return fsi::run_time_loop(
          coupled.system(), coupled.setup.acceleration.get(), control, from, to, coupled.setup.dt,
          [](const fsi::StepClock&, const fsi::StepReport&) { return false; }, failure);
    };
    ASSERT_EQ(go(0, 6), fsi::LoopEnd::finished) << failure;
    const std::vector<double> before = state_of(coupled);
    reset_counters();
    control.refuse = [](const fsi::StepClock& clock) { return clock.time > 0.0651; };
    EXPECT_EQ(go(6, 7), fsi::LoopEnd::failed);
    EXPECT_EQ(counted("steps repeated"), 4);  // 1, then the second half, quarter and eighth
    EXPECT_NE(failure.find("step 7 (t = 0.07) did not converge, not even in parts of 0.00125"), std::string::npos)
        << failure;
    EXPECT_EQ(state_of(coupled), before) << scheme;
    // What was given up can be done once nothing is in the way.
    control.refuse = nullptr;
    EXPECT_EQ(go(6, 8), fsi::LoopEnd::finished) << failure;
    const std::vector<double> after = state_of(coupled);
    CoupledCase other(Json::parse(coupled.text()));
    ASSERT_EQ(fsi::run_time_loop(
                  other.system(), other.setup.acceleration.get(), other.setup.step_control, 0, 8, other.setup.dt,
                  [](const fsi::StepClock&, const fsi::StepReport&) { return false; }, failure),
              fsi::LoopEnd::finished);
    const std::vector<double> direct = state_of(other);
    ASSERT_EQ(after.size(), direct.size());
    EXPECT_LT(distance(after, direct), 1e-7);
  }
}

}  // namespace
}  // namespace fbi::test
