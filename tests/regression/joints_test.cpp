/// Joints between fibers against closed forms, against one fiber in one piece, and in a fluid.
#include <numbers>

#include "case_fixture.hpp"
#include "record.hpp"

namespace fbi::test {
namespace {

constexpr double pi = std::numbers::pi;

Json point(const Vec3& x) { return {x[0], x[1], x[2]}; }

/// EA = 1e8, EI = stiffness, rho A = 1.
Json fiber(const std::string& name, const Vec3& from, const Vec3& to, int elements, double stiffness = 1e6) {
  return {{"name", name},
          {"curve", {{"type", "line"}, {"from", point(from)}, {"to", point(to)}}},
          {"elements", elements},
          {"section", {{"area", 0.01}, {"inertia", stiffness / 1e10}}},
          {"material", {{"young", 1e10}, {"density", 100}}}};
}

Json joint(const std::string& a, const std::string& b, const std::string& type, const std::string& at_a = "end",
           const std::string& at_b = "start") {
  return {{"a", a}, {"at_a", at_a}, {"b", b}, {"at_b", at_b}, {"type", type}};
}

Json end_force(const Vec3& value) {
  return Json::array({Json{{"type", "force"}, {"at", "end"}, {"value", point(value)}}});
}

Json dynamic(double step, double end, double rho_inf = 1.0) {
  return {{"step", step}, {"end", end}, {"beam", {{"rho_inf", rho_inf}, {"tolerance", 1e-12}}}};
}
Json statics(double step = 1.0) {
  return {{"step", step}, {"end", 1.0}, {"beam", {{"scheme", "static"}, {"tolerance", 1e-12}}}};
}

/// Displacements of the halves without the second node at the joint.
std::vector<double> as_one(const std::vector<double>& halves, int nodes) {
  std::vector<double> one(halves.begin(), halves.begin() + 6 * nodes);
  one.insert(one.end(), halves.begin() + 6 * (nodes + 1), halves.end());
  return one;
}

TEST(Joints, HalvesAreOneFiber) {
  for (const bool moving : {false, true}) {
    const auto run = [moving](bool halves) {
      Json json;
      const Vec3 foot(0, 0, 0), middle(0.5, 0, 0), tip(1, 0, 0);
      if (halves) {
        json["fibers"] = Json::array({fiber("near", foot, middle, 4, 1e2), fiber("far", middle, tip, 4, 1e2)});
        json["joints"] = Json::array({joint("near", "far", "rigid")});
      } else {
        json["fibers"] = Json::array({fiber("all", foot, tip, 8, 1e2)});
      }
      json["fibers"][0]["clamped"] = "start";
      json["fibers"].back()["loads"] = end_force({10, 150, 60});
      json["time"] = moving ? dynamic(2e-3, 0.2) : statics(0.25);
      CoupledCase test(json);
      test.run(moving ? 100 : 4);
      return test.snapshot().displacement;
    };
    const std::vector<double> one = run(false), two = run(true);
    EXPECT_GT(std::abs(one[one.size() - 5]), 0.2);
    const double difference = relative_difference(as_one(two, 4), one);
    report(moving ? "two halves, dynamic" : "two halves, static", difference);
    EXPECT_LE(difference, 1e-8);
    record({.section = moving ? "Fibers: dynamics" : "Fibers: statics",
            .id = "",
            .check = moving ? "two halves with a rigid joint against one fiber, 100 steps of a large motion"
                            : "two halves with a rigid joint against one fiber, large deflection under an end force",
            .source = "identity",
            .error = difference,
            .bar = "1e-8"});
  }
}

// The other way round: the second half runs from its tip to the joint.
TEST(Joints, HalvesThatMeetHeadOn) {
  const auto run = [](bool halves) {
    Json json;
    json["fibers"] = Json::array({fiber("near", {0, 0, 0}, {0.5, 0, 0}, 4, 1e2)});
    if (halves)
      json["fibers"].push_back(fiber("far", {1, 0, 0}, {0.5, 0, 0}, 4, 1e2));
    else
      json["fibers"][0] = fiber("all", {0, 0, 0}, {1, 0, 0}, 8, 1e2);
    if (halves) json["joints"] = Json::array({joint("far", "near", "rigid", "end", "end")});
    json["fibers"][0]["clamped"] = "start";
    Json load = end_force({10, 150, 60});
    if (halves) load[0]["at"] = "start";
    json["fibers"].back()["loads"] = load;
    json["time"] = statics(0.25);
    CoupledCase test(json);
    test.run(4);
    const std::vector<double> u = test.snapshot().displacement;
    const std::size_t tip = halves ? 6 * 5 : u.size() - 6;
    return std::vector<double>(u.begin() + tip, u.begin() + tip + 3);
  };
  EXPECT_LE(relative_difference(run(true), run(false)), 1e-8);
}

// Two uniform rods of length l and mass m hang on hinges: with x = omega^2 l/g,
// (3/2 - 4/3 x)(1/2 - 1/3 x) = x^2/4 for small angles.
TEST(Joints, DoublePendulumFrequencies) {
  const double g = 9.81, a = 7.0 / 36, b = -7.0 / 6, c = 0.75;
  for (const int mode : {0, 1}) {
    const double x = (-b + (mode == 0 ? -1 : 1) * std::sqrt(b * b - 4 * a * c)) / (2 * a);
    const double omega = std::sqrt(x * g), period = 2 * pi / omega;
    const double angle = 1e-3, second = angle * (1.5 - 4 * x / 3) / (0.5 * x);
    const Vec3 hinge(std::sin(angle), -std::cos(angle), 0);
    const int steps = 400;  // a quarter of a period has 100: the scheme's error of omega is (omega dt)^2/12
    Json json;
    json["gravity"] = {0, -g, 0};
    json["fibers"] = Json::array({fiber("upper", {0, 0, 0}, hinge, 2),
                                  fiber("lower", hinge, hinge + Vec3(std::sin(second), -std::cos(second), 0), 2)});
    json["fibers"][0]["pinned"] = "start";
    json["joints"] = Json::array({joint("upper", "lower", "position")});
    json["time"] = dynamic(period / steps, period);
    CoupledCase test(json);
    double before = hinge[0], time = 0.0, crossing = 0.0, gap = 0.0;
    while (time < 0.3 * period && crossing == 0.0) {
      test.step();
      time = test.time();
      const std::vector<double>& q = test.beams().accepted_dofs();
      gap = std::max(gap, (Vec3(&q[12]) - Vec3(&q[18])).norm());
      const double now = q[12];
      if (now <= 0.0) crossing = time - test.setup.dt * (0.0 - now) / (before - now);
      before = now;
    }
    const double found = 0.5 * pi / crossing, discrete = 2 / test.setup.dt * std::atan(0.5 * omega * test.setup.dt);
    report("double pendulum, omega of mode " + std::to_string(mode + 1), found);
    report("double pendulum, error", found / omega - 1);
    EXPECT_NEAR(found / omega, 1.0, 1e-4);
    EXPECT_NEAR(found / discrete, 1.0, 5e-5);
    EXPECT_LE(gap, 1e-13);
    record({.section = "Fibers: dynamics",
            .id = "",
            .check = "double pendulum of two stiff fibers with a hinge, omega of mode " + std::to_string(mode + 1) +
                     ", 400 steps a period",
            .source = "exact solution of two rigid rods",
            .reference = omega,
            .ours = found,
            .bar = "1e-4"});
  }
}

// Clamped feet, height h, span b, k = (I_b/b)/(I_c/h): sway stiffness 24 E I_c/h^3 (6k + 1)/(6k + 4).
TEST(Joints, PortalFrame) {
  const double h = 1.0, b = 2.0, column = 100.0, force = 1e-3;
  for (const double beam : {50.0, 800.0}) {
    Json json;
    json["fibers"] =
        Json::array({fiber("left", {0, 0, 0}, {0, h, 0}, 4, column), fiber("right", {b, 0, 0}, {b, h, 0}, 4, column),
                     fiber("beam", {0, h, 0}, {b, h, 0}, 4, beam)});
    for (int side = 0; side < 2; ++side) json["fibers"][side]["clamped"] = "start";
    json["fibers"][0]["loads"] = end_force({force, 0, 0});
    json["joints"] = Json::array({joint("left", "beam", "rigid"), joint("right", "beam", "rigid", "end", "end")});
    json["time"] = statics();
    CoupledCase test(json);
    test.run(1);
    const double k = (beam / b) / (column / h);
    const double exact = force / (24 * column / (h * h * h) * (6 * k + 1) / (6 * k + 4));
    const double sway = test.tip(0)[0];
    report("portal frame, sway error", sway / exact - 1);
    EXPECT_NEAR(sway / exact, 1.0, 1e-4);
    EXPECT_NEAR(test.tip(1)[0] / exact, 1.0, 1e-4);
    const Vec3 reaction = test.total(test.beams().reactions({}));
    EXPECT_NEAR(reaction[0] / force, -1.0, 1e-6);  // round-off of EA = 1e8 against a force of 1e-3
    record({.section = "Fibers: statics",
            .id = "",
            .check = log::format("portal frame with rigid joints, EI of beam/column %g: sway", beam / column),
            .source = "slope-deflection method",
            .reference = exact,
            .ours = sway,
            .bar = "1e-4"});
  }
}

// A hinge at the corner: the columns are cantilevers that share the force.
TEST(Joints, PortalFrameWithHinges) {
  Json json;
  json["fibers"] =
      Json::array({fiber("left", {0, 0, 0}, {0, 1, 0}, 2, 100), fiber("right", {2, 0, 0}, {2, 1, 0}, 2, 100),
                   fiber("beam", {0, 1, 0}, {2, 1, 0}, 2, 50)});
  for (int side = 0; side < 2; ++side) json["fibers"][side]["clamped"] = "start";
  json["fibers"][0]["loads"] = end_force({1e-3, 0, 0});
  json["joints"] = Json::array({Json{{"touching", 1e-6}}});
  json["time"] = statics();
  CoupledCase test(json);
  test.run(1);
  const double exact = 0.5 * 1e-3 / (3 * 100.0);
  report("hinged frame, sway error", test.tip(0)[0] / exact - 1);
  EXPECT_NEAR(test.tip(0)[0] / exact, 1.0, 1e-4);
}

// A free elbow of two fibers under a dead force: the momentum is the impulse, the angle stays.
TEST(Joints, FreeElbowKeepsMomentumAndAngle) {
  for (const double rho_inf : {1.0, 0.8}) {
    Json json;
    json["fibers"] =
        Json::array({fiber("first", {0, 0, 0}, {1, 0, 0}, 4, 1e2), fiber("second", {1, 0, 0}, {1.4, 0.6, 0.3}, 4, 1e2),
                     fiber("third", {1, 0, 0}, {1, 0, -1}, 3, 1e2)});
    const Vec3 force(0.0, 30.0, -50.0);
    json["fibers"][1]["loads"] = end_force(force);
    json["joints"] =
        Json::array({joint("first", "second", "rigid"), joint("second", "third", "rigid", "start", "start")});
    json["time"] = dynamic(2e-3, 1.0, rho_inf);
    CoupledCase test(json);
    double momentum = 0.0, angle = 0.0, energy = 0.0, largest = 0.0;
    const int node[3] = {4, 5, 10};
    Mat3 before;
    for (int step = 0; step <= 300; ++step) {
      if (step > 0) test.step();
      const std::vector<double>& q = test.beams().accepted_dofs();
      Mat3 now;
      for (int i = 0; i < 3; ++i) now.col(i) = Vec3(&q[6 * node[i] + 3]).normalized();
      if (step == 0) before = now;
      angle = std::max(angle, (now.transpose() * now - before.transpose() * before).cwiseAbs().maxCoeff());
      const Vec3 expected = test.time() * force;
      momentum = std::max(momentum, (test.beams().linear_momentum(test.beams().accepted_velocity()) - expected).norm());
      const beam::Energy e = test.beams().energy();
      energy = std::max(energy, std::abs(e.internal + e.kinetic - e.external_work));
      largest = std::max(largest, e.kinetic + e.internal);
    }
    const double impulse = test.time() * force.norm();
    report("elbow, momentum against impulse", momentum / impulse);
    report("elbow, change of the cosines of its angles", angle);
    report("elbow, energy error", energy / largest);
    EXPECT_LE(momentum / impulse, 1e-9);
    EXPECT_LE(angle, 1e-9);
    EXPECT_LE(energy / largest, 0.02);
    record({.section = "Fibers: dynamics",
            .id = "S-D6",
            .check = log::format("free body of three fibers with one rigid joint, rho_inf %g: momentum against impulse",
                                 rho_inf),
            .source = "identity",
            .error = momentum / impulse,
            .bar = "1e-9"});
  }
}

// The parts of a net are joined where nodes meet, each place once.
TEST(Joints, NetOfTouchingFibers) {
  Json json;
  json["fibers"] =
      Json::array({fiber("warp", {0, 0, 0}, {3, 0, 0}, 3, 1e2), fiber("weft", {0, 0, 0}, {0, 3, 0}, 3, 1e2)});
  json["fibers"][0]["array"] = {{"counts", {1, 4, 1}}, {"spacing", {0, 1, 0}}};
  json["fibers"][1]["array"] = {{"counts", {4, 1, 1}}, {"spacing", {1, 0, 0}}};
  json["fibers"][0]["clamped"] = "both";
  json["joints"] = Json::array({Json{{"touching", 1e-6}, {"type", "rigid"}}});
  json["gravity"] = {0, 0, -1};
  json["time"] = statics();
  CoupledCase test(json);
  EXPECT_EQ(test.fibers().joints.size(), 16u);
  ASSERT_EQ(test.fibers().joined.size(), 1u);
  EXPECT_EQ(test.fibers().joined[0].size(), 8u);
  test.run(1);
  const Vec3 weight = test.total(test.beams().reactions({}));
  EXPECT_NEAR(weight[2], 24.0, 1e-6);
  const std::vector<double>& q = test.beams().accepted_dofs();
  for (const mesh::FiberMesh::LocalJoint& pair : test.fibers().joints)
    EXPECT_LE((Vec3(&q[6 * pair.a]) - Vec3(&q[6 * pair.b])).norm(), 1e-12);
}

}  // namespace
}  // namespace fbi::test
