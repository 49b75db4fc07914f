/// A fiber with free ends in a periodic cube, coupled at its center line: its radius is that of the mesh.
#include "regression/rigid_fiber_flow.hpp"

namespace fbi::test {
namespace {

TEST(FiberInCube, ImagesOfAPointForce) {
  const double ours = -image_velocity(Vec3::Zero())(0, 0) * 3 / 4;
  report("images of a point force", ours);
  record({.section = "Coupling",
          .id = "S-H6",
          .check = "what the images of a point force in a periodic cube take from its velocity, times 6 pi mu L",
          .source = "Hasimoto 1959",
          .reference = 2.837297,
          .ours = ours,
          .bar = "1e-6"});
  EXPECT_NEAR(ours, 2.837297, 1e-6);
}

void row(int n, const char* name, const char* way, double aspect, double reference, double ours, double bar) {
  const std::string text = log::format("fiber in a periodic cube%s, %d cells, %s, flow %s, l/(2 a) %.3g: F/(mu l U)",
                                       name, n, place_of(n), way, aspect);
  check_number("S-H6", text, "Tirado and Garcia de la Torre 1984", reference, ours, bar);
}

/// The radius is that of the mesh, calibrated across an array and along a duct.
void check(int n, double bar) {
  const int cells = n % 2 == 0 ? 32 : 33;
  const FiberInCube found = drag_in_cube(n);
  CoupledCase run(duct(cells));
  const double along = found.length * n / (2 * cells * duct_radius(-solve_for_force(run, 2.0 / cells)[2]));
  const double across = found.length * n / (2 * transverse_radius(cells));
  row(n, "", "across", across, cylinder_across(across), found.across, bar);
  row(n, "", "along", along, cylinder_along(along), found.along, bar);
}

TEST(FiberInCube, OnALineOfNodes) { check(20, 0.06); }
TEST(FiberInCube, InTheMiddleOfCells) { check(21, 0.12); }

TEST(FiberInCube, OnARing) {
  constexpr double aspect = 20;
  for (const int n : {20, 21}) {
    Json changes;
    changes["coupling"] = {{"operator", "ring"}, {"penalty", "auto"}};
    const double length = 2.0 * (n / 4) / n;
    changes["fibers"] = fiber_in_cube(n, 0)["fibers"];
    changes["fibers"][0]["section"] = {{"radius", length / (2 * aspect)}};
    const FiberInCube found = drag_in_cube(n, changes);
    row(n, ", ring and auto", "across", aspect, cylinder_across(aspect), found.across, 0.1);
    row(n, ", ring and auto", "along", aspect, cylinder_along(aspect), found.along, 0.1);
  }
}

}  // namespace
}  // namespace fbi::test
