/// The same fiber on cells of half the size: the part of its rate that does not depend on any calibration.
#include "regression/relaxation.hpp"

namespace fbi::test {
namespace {

TEST(Relaxation, HalfTheCellSizeAddsLogTwo) {
  constexpr const char* source = "slender fiber of the radius calibrated in the array";
  const double radius = transverse_radius(32);
  const Relaxation coarse = check_relaxation(12, 6, radius / 6, source, 0.02);
  const Relaxation fine = check_relaxation(24, 12, radius / 12, source, 0.01);
  const double pi4 = std::pow(std::numbers::pi, 4), expected = pi4 * std::log(2.0) / (4 * std::numbers::pi);
  const double found = (fine.rate - coarse.rate) / bending;
  report("difference of the rates", found);
  record({.section = "Coupling",
          .id = "S-C1",
          .check = "the same: rate mu/EI on 12 less that on 6 cells along the fiber",
          .source = "k^4 ln 2/(4 pi)",
          .reference = expected,
          .ours = found,
          .bar = "10 %"});
  EXPECT_NEAR(found, expected, 0.1 * expected);
}

}  // namespace
}  // namespace fbi::test
