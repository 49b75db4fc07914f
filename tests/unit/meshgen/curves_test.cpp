/// Center lines by their arc length, and arc-length consistent element lengths.
#include "meshgen/curves.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/error.hpp"
#include "fem/line_shapes.hpp"
#include "record.hpp"

using namespace fbi;
using meshgen::consistent_length;
using meshgen::CurvePoint;
using meshgen::make_center_line;

namespace {

constexpr double pi = std::numbers::pi;

mesh::CurveParameters formulas(const std::string& x, const std::string& y, const std::string& z, double begin,
                               double end) {
  mesh::CurveParameters curve;
  curve.type = mesh::CurveType::expression;
  curve.position = {input::Expression(x), input::Expression(y), input::Expression(z)};
  curve.begin = begin;
  curve.end = end;
  return curve;
}

mesh::CurveParameters circle(double angle) {
  mesh::CurveParameters curve;
  curve.type = mesh::CurveType::arc;
  curve.from = Vec3(3, 2, 3);
  curve.center = Vec3(1, 2, 3);
  curve.normal = Vec3(0, 0, 5);
  curve.angle = angle;
  return curve;
}

std::string refusal(const mesh::CurveParameters& curve) {
  try {
    make_center_line(curve);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::geometry);
    return error.what();
  }
  return "none";
}

// Sum of the element lengths of the interpolation, and its largest distance from the curve at equal parts of each
// element, which are equal parts of the arc up to the error of the interpolation.
std::array<double, 2> interpolate(const mesh::CurveParameters& curve, int elements) {
  const auto line = make_center_line(curve);
  double length = 0.0, distance = 0.0;
  for (int e = 0; e < elements; ++e) {
    const CurvePoint a = line->at(static_cast<double>(e) / elements), b = line->at((e + 1.0) / elements);
    const double l = consistent_length(a.position, a.tangent, b.position, b.tangent);
    length += l;
    for (const double x : {-0.5, 0.0, 0.5}) {
      const std::array<double, 4> h = fem::hermite(x);
      const Vec3 r = h[0] * a.position + h[2] * b.position + 0.5 * l * (h[1] * a.tangent + h[3] * b.tangent);
      distance = std::max(distance, (r - line->at((e + 0.5 * (1 + x)) / elements).position).norm());
    }
  }
  return {length, distance};
}

}  // namespace

TEST(Curves, StraightElementHasItsChord) {
  const Vec3 x1(0.1, 0.2, 0.3), x2(1.1, -0.4, 0.9), t = (x2 - x1).normalized();
  EXPECT_NEAR(consistent_length(x1, t, x2, t), (x2 - x1).norm(), 1e-15);
}

// Hagemeyer, Mayr, Popp 2024, Appendix A, with the tangents before rounding; length computed independently.
TEST(Curves, CurvedElementOfAppendixA) {
  const Vec3 t1 = Vec3(1, 1, 1).normalized(), t2 = Vec3(3, -2, 1).normalized();
  EXPECT_NEAR(consistent_length(Vec3(0.15, 0.2, 0.3), t1, Vec3(0.65, 0.1, 0.1), t2), 0.6192043571449605, 1e-12);
}

TEST(Curves, ElementWithoutAChordHasNoLength) {
  EXPECT_THROW(consistent_length(Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(1, 0, 0), Vec3(0, 1, 0)), Error);
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
  mesh::CurveParameters curve;
  curve.from = Vec3(1, 0, 0);
  curve.to = Vec3(1, 0.3, 0.4);
  const auto line = make_center_line(curve);
  EXPECT_EQ(line->at(1.0).position, curve.to);
  EXPECT_NEAR((line->at(0.5).position - Vec3(1, 0.15, 0.2)).norm(), 0.0, 1e-16);
  EXPECT_NEAR((line->at(0.2).tangent - Vec3(0, 0.6, 0.8)).norm(), 0.0, 1e-15);
  EXPECT_DOUBLE_EQ(line->length(), 0.5);
}

TEST(Curves, ArcTurnsByTheRightHandRule) {
  const auto arc = make_center_line(circle(0.5 * pi));
  EXPECT_DOUBLE_EQ(arc->length(), pi);
  EXPECT_NEAR((arc->at(1.0).position - Vec3(1, 4, 3)).norm(), 0.0, 1e-15);
  EXPECT_NEAR((arc->at(1.0).tangent - Vec3(-1, 0, 0)).norm(), 0.0, 1e-15);
  const auto back = make_center_line(circle(-0.5 * pi));
  EXPECT_NEAR((back->at(1.0).position - Vec3(1, 0, 3)).norm(), 0.0, 1e-15);
  EXPECT_NEAR((back->at(0.0).tangent - Vec3(0, -1, 0)).norm(), 0.0, 1e-15);
  const auto whole = make_center_line(circle(2 * pi));
  EXPECT_NEAR((whole->at(1.0).position - whole->at(0.0).position).norm(), 0.0, 1e-14);
}

TEST(Curves, ArcThroughThreePoints) {
  mesh::CurveParameters curve;
  curve.type = mesh::CurveType::arc;
  curve.through_points = true;
  curve.from = Vec3(1, 0, 7);
  for (const double angle : {0.5, 2.0, 4.0, 6.0}) {  // to, with `through` on the way
    curve.through = Vec3(std::cos(0.3 * angle), std::sin(0.3 * angle), 7);
    curve.to = Vec3(std::cos(angle), std::sin(angle), 7);
    const auto arc = make_center_line(curve);
    EXPECT_NEAR(arc->length(), angle, 1e-13);
    EXPECT_NEAR((arc->at(1.0).position - curve.to).norm(), 0.0, 1e-14);
    EXPECT_NEAR((arc->at(0.3).position - curve.through).norm(), 0.0, 1e-14);
    EXPECT_NEAR((arc->at(0.0).tangent - Vec3(0, 1, 0)).norm(), 0.0, 1e-14);
  }
  curve.through = Vec3(1, 1, 7);
  curve.to = Vec3(1, 2, 7);
  EXPECT_NE(refusal(curve).find("lie on one line"), std::string::npos);
}

// A helix of radius 2 and pitch 2 pi/2 has the speed sqrt(4 + 1/4) in its angle; here the angle is an uneven function
// of the parameter, so the arc length has to be found.
TEST(Curves, HelixByItsArcLength) {
  const auto helix =
      make_center_line(formulas("100+2*cos(t+0.5*sin(t))", "2*sin(t+0.5*sin(t))", "0.5*(t+0.5*sin(t))", 0.0, 4 * pi));
  const double speed = std::sqrt(4.25), length = 4 * pi * speed;
  EXPECT_NEAR(helix->length() / length, 1.0, 1e-12);
  double position = 0.0, tangent = 0.0;
  for (int k = 0; k <= 37; ++k) {
    const double angle = 4 * pi * k / 37;
    const CurvePoint point = helix->at(k / 37.0);
    position =
        std::max(position, (point.position - Vec3(100 + 2 * std::cos(angle), 2 * std::sin(angle), 0.5 * angle)).norm());
    tangent = std::max(tangent, (point.tangent - Vec3(-2 * std::sin(angle), 2 * std::cos(angle), 0.5) / speed).norm());
    EXPECT_NEAR(point.tangent.norm(), 1.0, 1e-15);
  }
  EXPECT_LT(position, 1e-10);  // of coordinates of 100
  EXPECT_LT(tangent, 1e-10);
  test::record({.section = "Fibers: statics",
                .id = "",
                .check = "length of a helix given by formulas of an uneven parameter",
                .source = "exact solution",
                .reference = length,
                .ours = helix->length(),
                .bar = "1e-12"});
}

TEST(Curves, HermiteInterpolationHasOrderFour) {
  const mesh::CurveParameters helix = formulas("cos(t)", "sin(t)", "t/4", 0.0, 2 * pi);
  const double exact = 2 * pi * std::sqrt(1 + 1.0 / 16);
  double orders[2] = {};
  std::array<double, 2> last{};
  for (const int elements : {8, 16, 32}) {
    const std::array<double, 2> now = interpolate(helix, elements);
    const double error[2] = {std::abs(now[0] - exact), now[1]};
    for (int k = 0; k < 2 && elements > 8; ++k) orders[k] = std::log2(last[k] / error[k]);
    last = {error[0], error[1]};
  }
  EXPECT_NEAR(orders[0], 4.0, 0.1);
  EXPECT_NEAR(orders[1], 4.0, 0.1);
  EXPECT_LT(last[0] / exact, 3e-6);
  const char* names[2] = {"arc length of the Hermite interpolation of a helix, 8 to 32 elements a turn",
                          "position of the Hermite interpolation of a helix, 8 to 32 elements a turn"};
  for (int k = 0; k < 2; ++k)
    test::record({.section = "Fibers: statics",
                  .id = "",
                  .check = names[k],
                  .source = "exact solution",
                  .error = last[k] / exact,
                  .order = orders[k],
                  .bar = "order 4"});
}

TEST(Curves, FormulasBackwardsAndOfOneDirection) {
  const auto back = make_center_line(formulas("cos(t)", "sin(t)", "0", pi, 0.0));
  EXPECT_NEAR(back->length(), pi, 1e-13);
  EXPECT_NEAR((back->at(0.0).position - Vec3(-1, 0, 0)).norm(), 0.0, 1e-14);
  EXPECT_NEAR((back->at(0.25).tangent - Vec3(std::sqrt(0.5), std::sqrt(0.5), 0)).norm(), 0.0, 1e-13);
  const auto line = make_center_line(formulas("1", "exp(t)", "2", 0.0, 1.0));
  EXPECT_NEAR(line->length(), std::numbers::e - 1, 1e-14);
  EXPECT_NEAR((line->at(0.5).position - Vec3(1, 0.5 * (1 + std::numbers::e), 2)).norm(), 0.0, 1e-14);
}

TEST(Curves, SplineThroughPoints) {
  mesh::CurveParameters curve;
  curve.type = mesh::CurveType::spline;
  curve.points = {Vec3(0, 0, 0), Vec3(0, 1, 0), Vec3(0, 5, 0)};
  EXPECT_NEAR(make_center_line(curve)->length(), 5.0, 1e-14);
  EXPECT_NEAR((make_center_line(curve)->at(0.5).position - Vec3(0, 2.5, 0)).norm(), 0.0, 1e-14);
  double last = 0.0, order = 0.0;
  for (const int intervals : {16, 32}) {  // of a sine between inflection points, where the natural ends are right
    curve.points.clear();
    for (int k = 0; k <= intervals; ++k) curve.points.emplace_back(pi * k / intervals, std::sin(pi * k / intervals), 0);
    const auto line = make_center_line(curve);
    const double error = std::abs(line->length() - 3.820197789027712);  // 2 sqrt(2) E(1/2)
    if (last > 0.0) order = std::log2(last / error);
    last = error;
    for (const Vec3& point : curve.points) {
      double nearest = 1.0;
      for (int k = 0; k <= 2000; ++k) nearest = std::min(nearest, (line->at(k / 2000.0).position - point).norm());
      EXPECT_LT(nearest, 2e-3);
    }
  }
  EXPECT_LT(last, 1e-4);
  EXPECT_GT(order, 3.0);
}

TEST(Curves, RefusalsSayWhereAndWhy) {
  const auto contains = [](const std::string& text, const char* part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  };
  contains(refusal(formulas("1/t", "t", "0", 0.0, 1.0)), "is not finite at t = 0");
  contains(refusal(formulas("t^2", "t^3", "0", -1.0, 1.0)), "stands still");
  contains(refusal(formulas("t^2", "t^3", "0", -1.0, 1.3)), "stands still");
  contains(refusal(formulas("t^2", "0", "0", 0.0, 1.0)), "stands still near t = 0:");
  contains(refusal(formulas("t^2", "0", "0", -1.0, 2.0)), "stands still");
  contains(refusal(formulas("t", "abs(t-0.3)", "0", 0.0, 1.0)),
           "has a kink, a jump or a point where it stands still near t = 0.3:");
  contains(refusal(formulas("t", "t < 0.3 ? 0 : 1", "0", 0.0, 1.0)),
           "has a kink, a jump or a point where it stands still near t = 0.3:");
  contains(refusal(formulas("1", "2", "0", 0.0, 1.0)), "zero length");
  mesh::CurveParameters arc = circle(1.0);
  arc.normal = Vec3::Zero();
  contains(refusal(arc), "\"normal\" is zero");
  arc.normal = Vec3(0.1, 0, 1);
  contains(refusal(arc), "off the plane");
  arc.from = arc.center;
  contains(refusal(arc), "begins at the center");
}
