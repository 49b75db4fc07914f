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

void check(int n) {
  const FiberInCube found = drag_in_cube(n);
  const double across_radius = transverse_radius(n % 2 == 0 ? 32 : 33) / n;
  const double along_radius = duct_radius([&] {
                                const int cells = n % 2 == 0 ? 32 : 33;
                                CoupledCase run(duct(cells));
                                return -solve_for_force(run, 2.0 / cells)[2];
                              }()) *
                              (n % 2 == 0 ? 32.0 : 33.0) / n;
  const auto row = [&](const char* way, double reference, double ours, double radius) {
    const std::string text = log::format("fiber in a periodic cube, %d cells, %s, flow %s, l/(2 a) %.3g: F/(mu l U)", n,
                                         place_of(n), way, found.length / (2 * radius));
    report(text, ours);
    report("reference", reference);
    record({.section = "Coupling",
            .id = "S-H6",
            .check = text,
            .source = "Tirado and Garcia de la Torre 1984, radius calibrated across an array and along a duct",
            .reference = reference,
            .ours = ours,
            .bar = "5 %"});
    EXPECT_NEAR(ours, reference, 0.05 * reference);
  };
  row("across", cylinder_across(found.length / (2 * across_radius)), found.across, across_radius);
  row("along", cylinder_along(found.length / (2 * along_radius)), found.along, along_radius);
}

TEST(FiberInCube, OnALineOfNodes) { check(20); }
TEST(FiberInCube, InTheMiddleOfCells) { check(21); }

}  // namespace
}  // namespace fbi::test
