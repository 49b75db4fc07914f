/// Warnings of cases outside the stable region: the factors they rest on, each limit from both sides, and the cases of
/// the repository, which are all inside.
#include "case/stability.hpp"

#include "record.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

using cases::alternation_factor;
using cases::CaseParameters;
using cases::iteration_factor;
using cases::stability_warnings;
using cases::StabilityNumbers;

/// Ratio of lambda in one step after the other, from the three equations solved without any formula for the ratio.
double measured_factor(double penalty, double fluid, double fiber, double step, double weight, double theta) {
  double v_f = 1.0, v_b = 0.0, lambda = penalty, factor = 0.0;
  for (int n = 0; n < 3; ++n) {
    // v_f' = v_f - dt/m (theta l' + (1-theta) l), v_b' = v_b + dt/(rho A) (w l' + (1-w) l), l' = eps (v_f' - v_b'):
    // linear in l', so that two trial values give it.
    const auto misfit = [&](double next) {
      const double f = v_f - step / fluid * (theta * next + (1.0 - theta) * lambda);
      const double b = v_b + step / fiber * (weight * next + (1.0 - weight) * lambda);
      return penalty * (f - b) - next;
    };
    const double next = misfit(0.0) / (misfit(0.0) - misfit(1.0));
    v_f -= step / fluid * (theta * next + (1.0 - theta) * lambda);
    v_b += step / fiber * (weight * next + (1.0 - weight) * lambda);
    factor = next / lambda;
    lambda = next;
  }
  return factor;
}

TEST(Stability, FactorOfAlternation) {
  for (const double theta : {0.5, 1.0})
    for (const double weight : {0.5, 0.7, 1.0})
      for (const double fiber : {1e-4, 1.0, 30.0})
        EXPECT_NEAR(alternation_factor(50.0, 2.0, fiber, 0.1, weight, theta),
                    measured_factor(50.0, 2.0, fiber, 0.1, weight, theta), 1e-9)
            << theta << " " << weight << " " << fiber;
  // the stiff limit for theta = 1, w = 1/2
  const double factor = alternation_factor(1e15, 2.0, 0.1, 0.01, 0.5, 1.0);
  EXPECT_NEAR(factor, -1.0 / (1.0 + 2.0 * 0.1 / 2.0), 1e-9);
  EXPECT_GE(alternation_factor(100.0, 2.0, 0.1, 0.01, 1.0, 1.0), 0.0);
}

TEST(Stability, FactorOfAnIteration) {
  // velocity to the fluid: l = (v_f0 - v_b)/(1/eps + theta dt/m); force to the fiber: v_b = w dt/(rho A) l
  const double penalty = 50.0, fluid = 2.0, fiber = 0.3, step = 0.1, weight = 0.8, theta = 0.6;
  const auto turn = [&](double force) {
    return (1.0 - weight * step / fiber * force) / (1.0 / penalty + theta * step / fluid);
  };
  EXPECT_NEAR(iteration_factor(penalty, fluid, fiber, step, weight, theta), turn(0.0) - turn(1.0), 1e-12);
}

/// Whether a warning holds the text.
bool warns(const StabilityNumbers& numbers, const CaseParameters& parameters, const std::string& text) {
  const std::vector<std::string> warnings = stability_warnings(numbers, parameters);
  return std::any_of(warnings.begin(), warnings.end(),
                     [&](const std::string& warning) { return warning.find(text) != std::string::npos; });
}

class Limits : public ::testing::Test {
 protected:
  Limits() { parameters.fluid.emplace(); }
  CaseParameters parameters;
  StabilityNumbers numbers;
};

TEST_F(Limits, Nothing) { EXPECT_TRUE(stability_warnings(numbers, parameters).empty()); }

TEST_F(Limits, LargeSteps) {
  numbers.cauchy = 4.0;
  numbers.motion = 0.13;
  numbers.elements = 5;
  numbers.change = 0.05;
  EXPECT_TRUE(stability_warnings(numbers, parameters).empty());
  numbers.change = 0.5;
  EXPECT_TRUE(warns(numbers, parameters, "fiber lengths in a step"));
  numbers.motion = 0.07;
  EXPECT_TRUE(stability_warnings(numbers, parameters).empty());
  numbers.motion = 0.26;
  numbers.change = 0.0;
  EXPECT_TRUE(warns(numbers, parameters, "fiber lengths in a step"));
  parameters.beam_time.rho_inf = 0.5;
  EXPECT_TRUE(stability_warnings(numbers, parameters).empty());
  parameters.beam_time.rho_inf = 1.0;
  numbers.cauchy = 0.01;  // too stiff to yield
  EXPECT_TRUE(stability_warnings(numbers, parameters).empty());
}

TEST_F(Limits, FlexibleFibers) {
  numbers.cauchy = 150.0;
  for (const Index elements : {5, 10, 20}) {
    numbers.elements = elements;
    numbers.motion = 0.013 * elements / 5;
    EXPECT_TRUE(stability_warnings(numbers, parameters).empty());
    numbers.motion *= 2;
    EXPECT_TRUE(warns(numbers, parameters, "more elements"));
    numbers.cauchy = 40.0;
    EXPECT_TRUE(stability_warnings(numbers, parameters).empty());
    numbers.cauchy = 150.0;
  }
}

TEST_F(Limits, Alternation) {
  numbers.alternation = -0.94;
  EXPECT_TRUE(stability_warnings(numbers, parameters).empty());
  numbers.alternation = -0.99;
  EXPECT_TRUE(warns(numbers, parameters, "alternate from step to step"));
}

TEST_F(Limits, SolvedInTurns) {
  const std::pair<fsi::Scheme, double> limits[] = {
      {fsi::Scheme::constant, 20.0 / 3.1}, {fsi::Scheme::aitken, 60.0}, {fsi::Scheme::iqn_ils, 6000.0}};
  for (const auto& [scheme, limit] : limits) {
    parameters.scheme.scheme = scheme;
    numbers.iteration = 0.9 * limit;
    EXPECT_TRUE(stability_warnings(numbers, parameters).empty());
    numbers.iteration = 1.1 * limit;
    EXPECT_TRUE(warns(numbers, parameters, "solved in turns"));
  }
  parameters.scheme.scheme = fsi::Scheme::newton_krylov;
  numbers.iteration = 1e6;
  EXPECT_TRUE(stability_warnings(numbers, parameters).empty());
}

TEST_F(Limits, Linearized) {
  parameters.solver.nonlinear = fluid::Linearization::extrapolated;
  numbers.motion = 0.01;
  numbers.change = 0.05;
  EXPECT_TRUE(stability_warnings(numbers, parameters).empty());
  numbers.change = 0.1;
  EXPECT_TRUE(warns(numbers, parameters, "linearized"));
  parameters.beam_time.rho_inf = 0.5;
  EXPECT_TRUE(stability_warnings(numbers, parameters).empty());
  numbers.change = 0.15;
  EXPECT_TRUE(warns(numbers, parameters, "linearized"));
  parameters.beam_time.rho_inf = 0.0;
  EXPECT_TRUE(stability_warnings(numbers, parameters).empty());
  parameters.beam_time.rho_inf = 1.0;
  parameters.solver.nonlinear = fluid::Linearization::newton;
  EXPECT_TRUE(stability_warnings(numbers, parameters).empty());
}

TEST_F(Limits, SuddenStart) {
  numbers.cfl = 0.005;
  EXPECT_TRUE(stability_warnings(numbers, parameters).empty());
  numbers.sudden = true;
  EXPECT_TRUE(warns(numbers, parameters, "PSPG"));
  parameters.fluid->tau_time = false;
  EXPECT_TRUE(stability_warnings(numbers, parameters).empty());
}

/// Factor by which the alternating part of the drag changes in a step, in the last 40 of 60 steps, for unequal impulses
/// on fluid and fiber: a sudden start, a stiff penalty.
double factor_of_run(double density) {
  Json json = small_beam(R"({ "channel": { "elements": [24, 8, 1] }, "solver": { "linear": "iterative" },
    "coupling": { "penalty": 1e6, "coupling_weight": "1-alpha_f" }, "time": { "step": 1e-5, "end": 6e-4 } })");
  json["fibers"][0]["material"]["density"] = density;
  json["channel"]["boundaries"]["xmin"]["velocity"][0] = "4*y*(1-y)*6.5";
  CoupledCase run(json);
  std::vector<double> drag;
  for (int n = 0; n < 60; ++n) {
    run.step();
    drag.push_back(run.drag()[0]);
  }
  for (int order = 0; order < 6; ++order) {
    for (std::size_t k = 0; k + 1 < drag.size(); ++k) drag[k] = drag[k + 1] - drag[k];
    drag.pop_back();
  }
  double middle = 0.0, last = 0.0;
  for (std::size_t k = drag.size() - 20; k < drag.size(); ++k) {
    last += drag[k] * drag[k];
    middle += drag[k - 20] * drag[k - 20];
  }
  return std::pow(last / middle, 1.0 / 40.0);
}

// The mass of fluid that the mesh adds to a fiber is known up to where its points lie in their cells.
TEST(Stability, AlternationOfARun) {
  for (const double density : {0.1, 1.0}) {
    const double fiber = density * 1e-4, h = 0.06, step = 1e-5;
    const double low = -alternation_factor(1e6, 0.38 * h * h, fiber, step, 0.5, 1.0),
                 high = -alternation_factor(1e6, 3.1 * h * h, fiber, step, 0.5, 1.0), ours = factor_of_run(density);
    EXPECT_GT(ours, low) << density;
    EXPECT_LT(ours, high) << density;
    record({.section = "Coupling",
            .check = log::format("alternating coupling force, rho_b %g, weight 1-alpha_f: factor of a step", density),
            .source = "a mass of fluid between 0.38 and 3.1 rho h^2 and a mass of fiber",
            .reference_text = log::format("-%.3f to -%.3f", low, high),
            .ours_text = log::format("-%.4f", ours),
            .bar = "within"});
  }
}

std::vector<std::string> warnings_of(const Json& json) {
  CoupledCase run(json);
  return stability_warnings(cases::stability_numbers(run.setup, cases::inspect(run.setup)), run.setup.parameters);
}

TEST(Stability, CasesOfTheRepository) {
  EXPECT_EQ(warnings_of(single_beam()), std::vector<std::string>());
  EXPECT_EQ(warnings_of(read_case("canopy-small")), std::vector<std::string>());
  EXPECT_EQ(warnings_of(read_case("obstacle")), std::vector<std::string>());
}

TEST(Stability, NumbersOfACase) {
  CoupledCase run(small_beam());
  const StabilityNumbers numbers = cases::stability_numbers(run.setup, cases::inspect(run.setup));
  EXPECT_NEAR(numbers.motion, 6.5 * 1e-4 / 0.5, 0.02 * numbers.motion);
  EXPECT_GT(numbers.cauchy, 3.0);
  EXPECT_LT(numbers.cauchy, 4.5);
  EXPECT_EQ(numbers.iteration, 0.0);
  EXPECT_GT(numbers.alternation, 0.0);
  EXPECT_FALSE(numbers.sudden);
}

}  // namespace
}  // namespace fbi::test
