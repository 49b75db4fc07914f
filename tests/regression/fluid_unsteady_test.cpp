/// Unsteady duct and channel flow driven by a body force, against exact series: both schemes of second order.
#include <complex>

#include "record.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

/// Velocity component at the node of x.
double velocity_at(CoupledCase& run, const Vec3& x, int component) {
  fluid::LocalArray u(run.fluid().accepted());
  const mesh::HexMesh& mesh = *run.setup.fluid_mesh;
  for (Index n = 0; n < mesh.local_nodes(); ++n)
    if ((Eigen::Map<const Vec3>(mesh.node(n)) - x).norm() < 1e-9) return u[4 * static_cast<std::size_t>(n) + component];
  ADD_FAILURE() << "no node there";
  return 0.0;
}

Json time_scheme(const std::string& scheme) {
  return scheme == "bdf2" ? Json{{"scheme", "bdf2"}} : Json{{"scheme", "one_step_theta"}, {"theta", 0.5}};
}

// A quarter of the square duct of unit side, started from rest by a constant force; 16^2 cells, dt = 0.0025.
TEST(FluidUnsteady, start_of_duct_flow) {
  constexpr int cells = 16;
  constexpr double h = 0.5 / cells, dt = 0.0025;
  struct Row {
    double time, center, rate;
  };
  const Row rows[] = {{0.01, 0.0099980748, 0.0072456368},
                      {0.05, 0.0431402632, 0.0227279649},
                      {0.1, 0.0622634458, 0.0305204969},
                      {0.2, 0.0720865893, 0.0345019731}};
  for (const std::string scheme : {"theta = 0.5", "bdf2"}) {
    Json json = parse_json(R"({
      "fluid": { "density": 1, "viscosity": 1, "body_force": [0, 0, 1] },
      "channel": { "boundaries": {
        "xmin": { "type": "no_slip" }, "xmax": { "type": "slip" }, "ymin": { "type": "no_slip" },
        "ymax": { "type": "slip" }, "zmin": { "type": "mixed", "velocity": [0, 0, null] },
        "zmax": { "type": "mixed", "velocity": [0, 0, null] } } },
      "solver": { "linear": "direct" }, "time": { "end": 0.2 } })");
    json["channel"]["size"] = {0.5, 0.5, 2 * h};
    json["channel"]["elements"] = {cells, cells, 2};
    json["time"]["step"] = dt;
    json["time"]["fluid"] = time_scheme(scheme);
    CoupledCase run(json);
    for (const Row& row : rows) {
      run.run(static_cast<int>(std::lround(row.time / dt)) - static_cast<int>(run.steps_done()));
      const double center = velocity_at(run, Vec3(0.5, 0.5, h), 2);
      double rate = 0;  // trapezoidal rule: exact for the bilinear velocity
      for (int i = 0; i <= cells; ++i)
        for (int j = 0; j <= cells; ++j)
          rate +=
              (i == cells ? 0.5 : 1) * (j == cells ? 0.5 : 1) * 4 * h * h * velocity_at(run, Vec3(i * h, j * h, h), 2);
      report(scheme + log::format(" t = %g center, relative error", row.time), center / row.center - 1);
      report(scheme + log::format(" t = %g rate, relative error", row.time), rate / row.rate - 1);
      EXPECT_NEAR(center / row.center, 1, 0.005);
      EXPECT_NEAR(rate / row.rate, 1, 0.02);
      record(
          {.section = "Fluid",
           .id = "S-F3",
           .check = log::format("square duct from rest, t = %g, %s: velocity at the center", row.time, scheme.c_str()),
           .source = "series solution",
           .reference = row.center,
           .ours = center,
           .bar = "0.5 %"});
      record({.section = "Fluid",
              .id = "S-F3",
              .check = log::format("square duct from rest, t = %g, %s: flow rate", row.time, scheme.c_str()),
              .source = "series solution",
              .reference = row.rate,
              .ours = rate,
              .bar = "2 %"});
    }
  }
}

// Half a plane channel, force cos(w t); 24 cells, 64 steps a period; Fourier coefficients of the last period.
TEST(FluidUnsteady, oscillating_channel) {
  constexpr int cells = 24, steps = 64;
  constexpr double h = 1.0 / cells;
  struct Row {
    int womersley;
    double amplitude, phase, mean_amplitude, mean_phase;
  };
  const Row rows[] = {{1, 0.4631527438, -0.3964147417, 0.3089948476, -0.3797793245},
                      {4, 1.1128035752, -1.5383629196, 0.8436121846, -1.3600230344}};
  for (const std::string scheme : {"theta = 0.5", "bdf2"})
    for (const Row& row : rows) {
      const int w = row.womersley * row.womersley;
      const double period = 2 * M_PI / w;
      const int periods = std::max(2, static_cast<int>(std::ceil(4 / period)));
      Json json = parse_json(R"({
        "fluid": { "density": 1, "viscosity": 1 },
        "channel": { "boundaries": {
          "xmin": { "type": "mixed", "velocity": [null, 0, 0] }, "xmax": { "type": "mixed", "velocity": [null, 0, 0] },
          "ymin": { "type": "no_slip" }, "ymax": { "type": "slip" }, "zmin": { "type": "slip" },
          "zmax": { "type": "slip" } } },
        "solver": { "linear": "direct" } })");
      json["fluid"]["body_force"] = {log::format("cos(%d*t)", w), 0, 0};
      json["channel"]["size"] = {2 * h, 1, h};
      json["channel"]["elements"] = {2, cells, 1};
      json["time"] = {{"step", period / steps}, {"end", periods * period}, {"fluid", time_scheme(scheme)}};
      CoupledCase run(json);
      run.run((periods - 1) * steps);
      std::complex<double> center = 0, mean = 0;
      for (int k = 0; k < steps; ++k) {
        run.step();
        const std::complex<double> wave = std::polar(2.0 / steps, -w * run.time());
        center += velocity_at(run, Vec3(h, 1, 0), 0) * wave;
        for (int j = 0; j <= cells; ++j)
          mean += (j == cells ? 0.5 : 1) * h * velocity_at(run, Vec3(h, j * h, 0), 0) * wave;
      }
      const auto check = [&](const char* what, double reference, double ours) {
        report(log::format("%s Wo %d %s, relative error", scheme.c_str(), row.womersley, what), ours / reference - 1);
        EXPECT_NEAR(ours / reference, 1, 0.01);
        record({.section = "Fluid",
                .id = "S-F4",
                .check = log::format("oscillating plane channel, Wo = %d, %s: %s", row.womersley, scheme.c_str(), what),
                .source = "exact solution",
                .reference = reference,
                .ours = ours,
                .bar = "1 %"});
      };
      check("amplitude at the center", row.amplitude, w * std::abs(center));
      check("phase at the center", row.phase, std::arg(center));
      check("amplitude of the mean", row.mean_amplitude, w * std::abs(mean));
      check("phase of the mean", row.mean_phase, std::arg(mean));
    }
}

}  // namespace
}  // namespace fbi::test
