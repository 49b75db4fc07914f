/// Flow across a square array of fixed fibers: force against mean velocity (Sangani and Acrivos 1982; the values of the
/// center-line coupling on these meshes were computed independently).
#include "regression/straight_fibers.hpp"

namespace fbi::test {
namespace {

/// Mean of u_x over the inlet: trapezoidal rule on the uniform grid of the face.
double inlet_velocity(CoupledCase& run, int n) {
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
  const double resistance = force / inlet_velocity(run, n);
  report("F/(mu U), N " + std::to_string(n), resistance);
  report("F - dp, N " + std::to_string(n), force - 1.0);
  report("Newton iterations, N " + std::to_string(n), result.newton);
  record({.section = "Coupling",
          .id = "S-H1",
          .check = log::format("resistance of a square array, fiber %s, %d cells: F/(mu U)", place_of(n), n),
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
