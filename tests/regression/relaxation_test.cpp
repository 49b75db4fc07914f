/// A bent fiber straightens in a viscous fluid, coupled at its center line: its radius is that of the mesh.
#include "regression/relaxation.hpp"

namespace fbi::test {
namespace {

constexpr const char* source = "slender fiber of the radius calibrated in the array";

TEST(Relaxation, ConstantOfTheArray) {
  report("C_2", array_constant(2.0));
  record({.section = "Coupling",
          .id = "S-C1",
          .check = "square array at distance 2, force sin(pi z): C_2 by the sum of Bessel functions",
          .source = "computed independently",
          .reference = -0.511366,
          .ours = array_constant(2.0),
          .bar = "5e-6"});
  EXPECT_NEAR(array_constant(2.0), -0.511366, 5e-6);
}

TEST(Relaxation, RateFromTheRadiusOfTheMesh) {
  for (const int n : {12, 13}) check_relaxation(n, 6, transverse_radius(n + 20) / 6, source, 0.02);
}

}  // namespace
}  // namespace fbi::test
