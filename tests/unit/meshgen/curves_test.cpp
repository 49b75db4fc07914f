/// Center lines and arc-length consistent element lengths.
#include "meshgen/curves.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"

using namespace fbi;
using meshgen::consistent_length;

TEST(Curves, StraightElementHasItsChord) {
  const Vec3 x1(0.1, 0.2, 0.3), x2(1.1, -0.4, 0.9), t = (x2 - x1).normalized();
  EXPECT_NEAR(consistent_length(x1, t, x2, t), (x2 - x1).norm(), 1e-15);
}

// Hagemeyer, Mayr, Popp 2024, Appendix A, with the tangents before rounding; length computed independently.
TEST(Curves, CurvedElementOfAppendixA) {
  const Vec3 t1 = Vec3(1, 1, 1).normalized(), t2 = Vec3(3, -2, 1).normalized();
  EXPECT_NEAR(consistent_length(Vec3(0.15, 0.2, 0.3), t1, Vec3(0.65, 0.1, 0.1), t2), 0.6192043571449605, 1e-12);
}

TEST(Curves, QuarterCircle) {  // l of one Hermite element tends to the arc as its angle shrinks, with order 4
  double last = 0.0;
  for (const double angle : {0.4, 0.2, 0.1}) {
    const double length = consistent_length(Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(std::cos(angle), std::sin(angle), 0),
                                            Vec3(-std::sin(angle), std::cos(angle), 0));
    const double error = std::abs(length / angle - 1);
    EXPECT_LT(error, 1e-4);
    if (last > 0.0) {
      EXPECT_NEAR(std::log2(last / error), 4.0, 0.2);
    }
    last = error;
  }
}

TEST(Curves, PointsOfALine) {
  const mesh::CurveParameters line{mesh::CurveType::line, Vec3(1, 0, 0), Vec3(1, 0.3, 0.4)};
  EXPECT_EQ(meshgen::point_on(line, 1.0).position, line.to);
  EXPECT_NEAR((meshgen::point_on(line, 0.5).position - Vec3(1, 0.15, 0.2)).norm(), 0.0, 1e-16);
  EXPECT_NEAR((meshgen::point_on(line, 0.2).tangent - Vec3(0, 0.6, 0.8)).norm(), 0.0, 1e-15);
}
