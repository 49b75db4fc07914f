/// Straight fibers along z through boxes of cubic cells, two cells deep: forces in steady Stokes flow, and the radius
/// of the cylinder that feels the same force.
#pragma once

#include <numbers>

#include "record.hpp"
#include "regression/case_fixture.hpp"
#include "regression/lattice_symbol.hpp"

namespace fbi::test {

inline constexpr double hasimoto = 1.3105329259;  ///< ln(L/a) - 4 pi mu U/F of thin cylinders in a square array
inline const double tau_of_metric = 1 / std::sqrt(36.0 * 48.0);  ///< tau_M mu/h^2 of a cube in slow steady flow

/// Reports, records (section "Coupling") and checks a number against a reference; `bar` is relative.
inline void check_number(const char* id, const std::string& check, const char* source, double reference, double ours,
                         double bar) {
  report(check, ours);
  report("relative error", ours / reference - 1);
  record({.section = "Coupling",
          .id = id,
          .check = check,
          .source = source,
          .reference = reference,
          .ours = ours,
          .bar = log::format("%g %%", 100 * bar)});
  EXPECT_NEAR(ours, reference, bar * std::abs(reference)) << check;
}

inline const char* place_of(int n) { return n % 2 == 0 ? "on a line of nodes" : "in the middle of cells"; }

/// Steady Stokes flow in a box of nx x ny x 2 cells of size h; the fixed fiber lies along the whole depth at (x, y).
/// The faces x and y are to be given; z faces slip.
inline Json box_with_fiber(int nx, int ny, double h, double x, double y) {
  Json json = parse_json(R"({
    "fluid": { "density": 1e-6, "viscosity": 1.0, "convective_form": "none", "viscous_residual": "none",
               "tau_time": false, "grad_div": false },
    "channel": { "boundaries": { "zmin": { "type": "slip" }, "zmax": { "type": "slip" } } },
    "fibers": [ { "name": "fiber", "curve": { "type": "line" }, "elements": 2, "formulation": "fixed" } ],
    "coupling": { "penalty": 1e6 },
    "time": { "fluid": { "scheme": "steady" } }
  })");
  json["channel"]["size"] = {nx * h, ny * h, 2 * h};
  json["channel"]["elements"] = {nx, ny, 2};
  json["fibers"][0]["curve"]["from"] = {x, y, 0.0};
  json["fibers"][0]["curve"]["to"] = {x, y, 2 * h};
  return json;
}

/// One cell of a square array, side 1, driven by a pressure drop of 1 along x; fiber in the middle. Slip and mixed
/// faces stand for the neighbors.
inline Json array_cell(int n) {
  Json json = box_with_fiber(n, n, 1.0 / n, 0.5, 0.5);
  Json& faces = json["channel"]["boundaries"];
  faces["xmin"] = faces["xmax"] = parse_json(R"({ "type": "mixed", "velocity": [null, "0", "0"],
                                                  "traction": ["0.5", "0", "0"] })");
  faces["ymin"] = faces["ymax"] = parse_json(R"({ "type": "slip" })");
  return json;
}

/// The same with periodic faces and a body force of 1 per volume, which lets the fiber lie anywhere.
inline Json periodic_array(int n, double x, double y) {
  Json json = box_with_fiber(n, n, 1.0 / n, x, y);
  Json& faces = json["channel"]["boundaries"];
  faces["xmin"] = parse_json(R"({ "type": "periodic", "with": "xmax" })");
  faces["ymin"] = parse_json(R"({ "type": "periodic", "with": "ymax" })");
  faces["xmax"] = parse_json(R"({ "type": "periodic", "with": "xmin" })");
  faces["ymax"] = parse_json(R"({ "type": "periodic", "with": "ymin" })");
  json["fluid"]["body_force"] = {"1e6", "0", "0"};
  return json;
}

/// Volume mean of the accepted velocity. Collective.
inline Vec3 mean_velocity(CoupledCase& run) {
  const mesh::HexMesh& mesh = *run.setup.fluid_mesh;
  double volume = 0.0;
  for (Index a = 0; a < mesh.owned_nodes; ++a) volume += run.fluid().lumped_volume()[a];
  return run.fluid().momentum(run.fluid().accepted()) / (run.fluid().parameters().density * run.comm().sum(volume));
}

/// Solves a steady case with a fiber; force per length on it.
inline Vec3 solve_for_force(CoupledCase& run, double depth) {
  const fsi::StepReport result = run.step();
  EXPECT_TRUE(result.converged);
  return run.drag() / depth;
}

/// F/(mu U) of a fiber across a square array; U is the mean velocity, mu = 1.
struct ArrayDrag {
  double resistance = 0.0;
  double imbalance = 0.0;  ///< |F - pressure drop|
};

inline ArrayDrag array_drag(const Json& json, int n) {
  CoupledCase run(json);
  const double force = solve_for_force(run, 2.0 / n)[0];
  return {force / mean_velocity(run)[0], std::abs(force - 1.0)};
}

/// Radius of thin cylinders that have this resistance (Hasimoto 1959), side 1.
inline double hasimoto_radius(double resistance) { return std::exp(-4 * std::numbers::pi / resistance - hasimoto); }

/// Radius over h that the mesh gives to a fiber across the flow: the calibration of all other cases.
inline double transverse_radius(int n, const Json& changes = Json::object()) {
  Json json = array_cell(n);
  json.merge_patch(changes);
  return n * hasimoto_radius(array_drag(json, n).resistance);
}

/// Square duct of side 1 with a fiber on its axis: the walls move along z at -1, the fluid is free to follow.
inline Json duct(int n) {
  Json json = box_with_fiber(n, n, 1.0 / n, 0.5, 0.5);
  Json& faces = json["channel"]["boundaries"];
  for (const char* face : {"xmin", "xmax", "ymin", "ymax"})
    faces[face] = parse_json(R"({ "type": "inflow", "velocity": ["0", "0", "-1"] })");
  for (const char* face : {"zmin", "zmax"})
    faces[face] = parse_json(R"({ "type": "mixed", "velocity": ["0", "0", null] })");
  return json;
}

inline constexpr double duct_constant = 0.5393526012;  ///< F/(mu U) = 2 pi/ln(0.539.../a) on the axis of a square duct

inline double duct_radius(double resistance) { return duct_constant * std::exp(-2 * std::numbers::pi / resistance); }

/// Fiber midway between plates at distance 2 H = 1: everything else moves at -1.
inline Json plates(int n) {
  const int nx = 8 * n + n % 2;
  Json json = box_with_fiber(nx, n, 1.0 / n, 0.5 * nx / n, 0.5);
  for (const char* face : {"xmin", "xmax", "ymin", "ymax"})
    json["channel"]["boundaries"][face] = parse_json(R"({ "type": "inflow", "velocity": ["-1", "0", "0"] })");
  return json;
}

/// F/(mu U) of a cylinder midway between plates at distance 2 H, k = a/H (Faxen 1946).
inline double faxen(double k) {
  return 4 * std::numbers::pi /
         (std::log(1 / k) - 0.915689773 + 1.7244 * k * k - 1.7302 * std::pow(k, 4) + 2.4056 * std::pow(k, 6) -
          4.5913 * std::pow(k, 8));
}

}  // namespace fbi::test
