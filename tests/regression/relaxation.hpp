/// A bent fiber straightens in a viscous fluid: how fast, from its radius across the flow.
#pragma once

#include "regression/straight_fibers.hpp"

namespace fbi::test {

inline constexpr double bending = 0.01, deflection = 1e-5;  ///< EI and how far the fiber is bent

/// C_L in R = ln(1/a) + C_L for a force sin(k z) on parallel fibers at distance L (square array), k = pi: velocity of a
/// modulated line force, summed over the neighbors.
inline double array_constant(double distance) {
  const double k = std::numbers::pi;
  double sum = std::log(2 / k) - std::numbers::egamma + 0.5;
  for (int i = -8; i <= 8; ++i)
    for (int j = -8; j <= 8; ++j) {
      if (i == 0 && j == 0) continue;
      const double x = k * distance * std::hypot(i, j);
      if (x < 100) sum += std::cyl_bessel_k(0.0, x) + 0.5 * x * std::cyl_bessel_k(1.0, x);
    }
  return sum;
}

/// Fiber of length 1 along z, pinned at both ends, in a box of n x n x nz cubic cells; a small load sin(pi z) bends it
/// towards `deflection` at the rate that is to be measured.
inline Json relaxing(int n, int nz, double mass, double dt) {
  const double h = 1.0 / nz;
  Json json = box_with_fiber(n, n, h, 0.5 * n * h, 0.5 * n * h);
  json["channel"]["size"][2] = 1.0;
  json["channel"]["elements"][2] = nz;
  Json& faces = json["channel"]["boundaries"];
  for (const char* face : {"xmin", "xmax"})
    faces[face] = parse_json(R"({ "type": "mixed", "velocity": [null, "0", "0"] })");
  for (const char* face : {"ymin", "ymax"}) faces[face] = parse_json(R"({ "type": "slip" })");
  for (const char* face : {"zmin", "zmax"})
    faces[face] = parse_json(R"({ "type": "mixed", "velocity": ["0", "0", null] })");
  Json& fiber = json["fibers"][0];
  fiber["curve"]["to"][2] = 1.0;
  fiber["elements"] = nz;
  fiber["formulation"] = "torsion_free";
  fiber["section"] = {{"area", 1e-4}, {"inertia", 1e-6}};
  fiber["material"] = {{"young", bending / 1e-6}, {"density", mass / 1e-4}};
  fiber["pinned"] = "both";
  fiber["loads"] = {
      {{"type", "line"},
       {"value", {log::format("%.17g*sin(pi*z)", deflection * bending * std::pow(std::numbers::pi, 4)), "0", "0"}}}};
  json["coupling"]["penalty"] = 1e5;
  json["time"] = parse_json(R"({ "fluid": { "scheme": "one_step_theta", "theta": 0.5 } })");
  json["time"]["step"] = dt;
  json["time"]["end"] = 40 * dt;
  json["solver"] = {{"linear", "direct"}, {"newton_tolerance", 1e-7}, {"newton_absolute_tolerance", 1e-6}};
  return json;
}

/// Displacement x in the middle of the fiber.
inline double middle(CoupledCase& run) {
  const std::size_t node = run.fibers().nodes() / 2;
  return run.beams().accepted_dofs()[6 * node] - run.fibers().position[3 * node];
}

struct Relaxation {
  double predicted = 0.0;  ///< rate from the calibrated radius, with the mass of the fiber
  double rate = 0.0;       ///< measured
};

/// @param radius  of the fiber across the flow
/// @param changes  to the case, such as another operator
inline Relaxation relax(int n, int nz, double radius, const Json& changes = Json::object()) {
  const double r = std::log(1 / radius) + array_constant(static_cast<double>(n) / nz);
  const double z = 4 * std::numbers::pi / r, massless = bending * std::pow(std::numbers::pi, 4) / z,
               mass = 0.01 * z / massless;
  const double dt = 0.04 / massless;
  Json json = relaxing(n, nz, mass, dt);
  json.merge_patch(changes);
  CoupledCase run(json);
  constexpr int first = 8, last = 15;
  double before = 0.0, early = 0.0, late = 0.0;
  int newton = 0;
  for (int step = 1; step <= last; ++step) {
    const fsi::StepReport result = run.step();
    if (::testing::Test::HasFailure()) break;
    newton = std::max(newton, result.newton);
    const double now = middle(run);
    if (step == first) early = now - before;
    if (step == last) late = now - before;
    before = now;
  }
  report("most Newton iterations", newton);
  // m s^2 - Z s + EI k^4 = 0; the trapezoidal rule turns s dt into 2 artanh(s dt/2).
  const double exact = (z - std::sqrt(z * z - 4 * mass * bending * std::pow(std::numbers::pi, 4))) / (2 * mass);
  const double measured = std::log(early / late) / (last - first) / dt;
  return {exact, 2 * std::tanh(0.5 * measured * dt) / dt};
}

/// Solves, records and compares; returns what was measured. With `radius` h over the calibrated one.
inline Relaxation check_relaxation(int n, int nz, double radius, const char* source, double bar,
                                   const Json& changes = Json::object(), const char* name = "") {
  const Relaxation found = relax(n, nz, radius, changes);
  const std::string check =
      log::format("relaxation of a bent fiber%s %s, %d cells along it: rate mu/EI", name, place_of(n), nz);
  report(check, found.rate / bending);
  report("predicted", found.predicted / bending);
  record({.section = "Coupling",
          .id = "S-C1",
          .check = check,
          .source = source,
          .reference = found.predicted / bending,
          .ours = found.rate / bending,
          .bar = log::format("%g %%", 100 * bar)});
  EXPECT_NEAR(found.rate, found.predicted, bar * found.predicted);
  return found;
}

}  // namespace fbi::test
