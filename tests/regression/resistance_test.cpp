/// Flow across a square array of fixed fibers: force against mean velocity (Sangani and Acrivos 1982; the values of the
/// center-line coupling on these meshes were computed independently).
#include "record.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

/// One cell of the array, 1 x 1 x 2/N, driven by a pressure drop of 1, fiber along z through the middle.
Json array_cell(int n) {
  Json json = parse_json(R"({
    "title": "Square array",
    "fluid": { "density": 1e-6, "viscosity": 1.0, "convective_form": "none", "viscous_residual": "none",
               "tau_time": false, "grad_div": false },
    "channel": {
      "size": [1, 1, 1], "elements": [1, 1, 2],
      "boundaries": {
        "xmin": { "type": "mixed", "velocity": [null, "0", "0"], "traction": ["0.5", "0", "0"] },
        "xmax": { "type": "mixed", "velocity": [null, "0", "0"], "traction": ["0.5", "0", "0"] },
        "ymin": { "type": "slip" }, "ymax": { "type": "slip" }, "zmin": { "type": "slip" }, "zmax": { "type": "slip" }
      }
    },
    "fibers": [ { "name": "fiber", "curve": { "type": "line", "from": [0.5, 0.5, 0], "to": [0.5, 0.5, 1] },
                  "elements": 2, "formulation": "fixed" } ],
    "coupling": { "penalty": 1e6 },
    "time": { "fluid": { "scheme": "steady" } }
  })");
  const double depth = 2.0 / n;
  json["channel"]["size"] = {1.0, 1.0, depth};
  json["channel"]["elements"] = {n, n, 2};
  json["fibers"][0]["curve"]["to"] = {0.5, 0.5, depth};
  return json;
}

/// Mean of u_x over the inlet: trapezoidal rule on the uniform grid of the face.
double mean_velocity(CoupledCase& run, int n) {
  const mesh::HexMesh& mesh = *run.setup.fluid_mesh;
  fluid::LocalArray u(run.fluid().accepted());
  double sum = 0.0;
  for (Index a = 0; a < mesh.owned_nodes; ++a) {
    const double* x = mesh.node(a);
    if (x[0] > 1e-9) continue;
    const bool edge_y = x[1] < 1e-9 || x[1] > 1 - 1e-9, edge_z = x[2] < 1e-9 || x[2] > 2.0 / n - 1e-9;
    sum += (edge_y ? 0.5 : 1.0) * (edge_z ? 0.5 : 1.0) * u[4 * static_cast<std::size_t>(a)];
  }
  return run.comm().sum(sum) / (n * 2.0);
}

void check_array(int n, double expected) {
  CoupledCase run(array_cell(n));
  const fsi::StepReport result = run.step();
  const double force = run.drag()[0] / (2.0 / n);
  const double resistance = force / mean_velocity(run, n);
  report("F/(mu U), N " + std::to_string(n), resistance);
  report("F - dp, N " + std::to_string(n), force - 1.0);
  report("Newton iterations, N " + std::to_string(n), result.newton);
  const std::string where = n % 2 == 0 ? "fiber on a line of nodes" : "fiber in the middle of cells";
  record({.section = "Coupling",
          .id = "S-H1",
          .check = log::format("resistance of a square array, %s, %d cells: F/(mu U)", where.c_str(), n),
          .source = "the same discretisation in 2D, computed independently",
          .reference = expected,
          .ours = resistance,
          .bar = "0.2 %"});
  record({.section = "Coupling",
          .id = "S-H1",
          .check = log::format("the same, %d cells: force on the fiber against the pressure drop", n),
          .source = "balance",
          .reference = 0.0,
          .ours = std::abs(force - 1.0),
          .bar = "1e-8"});
  EXPECT_NEAR(resistance, expected, 0.002 * expected);
  EXPECT_NEAR(force, 1.0, 1e-8);
}

TEST(SquareArray, fiber_on_a_line_of_nodes) { check_array(32, 2.565); }
TEST(SquareArray, fiber_in_the_middle_of_cells) { check_array(33, 4.599); }

}  // namespace
}  // namespace fbi::test
