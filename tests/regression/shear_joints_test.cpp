/// Joints and moved supports of fibers with shear and torsion: against one fiber in one piece, closed forms and
/// statics.
#include <Eigen/Geometry>
#include <numbers>

#include "base/error.hpp"
#include "case_fixture.hpp"
#include "record.hpp"

namespace fbi::test {
namespace {

constexpr double pi = std::numbers::pi;

Json point(const Vec3& x) { return {x[0], x[1], x[2]}; }

Json line(const Vec3& from, const Vec3& to) { return {{"type", "line"}, {"from", point(from)}, {"to", point(to)}}; }

/// Part of the circle of radius 1 about (0, 1, 0) in the plane x, y, from angle `begin` after its lowest point.
Json arc(double begin, double angle) {
  return {{"type", "arc"},
          {"from", {std::sin(begin), 1 - std::cos(begin), 0}},
          {"center", {0, 1, 0}},
          {"normal", {0, 0, 1}},
          {"angle", angle}};
}

/// EA = 1e4, k GA = 3000, EI2 = 2, EI3 = 1, GJ = 0.8, rho A = 0.5; axis 2 along z at the start.
Json shear_fiber(const std::string& name, const Json& curve, int elements) {
  return {{"name", name},
          {"curve", curve},
          {"elements", elements},
          {"formulation", "simo_reissner"},
          {"section",
           {{"area", 0.01},
            {"inertia_2", 2e-6},
            {"inertia_3", 1e-6},
            {"torsion", 2e-6},
            {"shear_correction", 0.75},
            {"direction", {0, 0, 1}}}},
          {"material", {{"young", 1e6}, {"density", 50}, {"shear_modulus", 4e5}}}};
}

/// Round: E, radius and slenderness such that EI = 1, GJ = 1/(1 + nu).
Json round_fiber(const std::string& name, const Json& curve, int elements, double poisson = 0.25,
                 double radius = 0.02) {
  const double inertia = 0.25 * pi * std::pow(radius, 4);
  return {{"name", name},
          {"curve", curve},
          {"elements", elements},
          {"formulation", "simo_reissner"},
          {"section", {{"radius", radius}}},
          {"material", {{"young", 1 / inertia}, {"density", 100}, {"poisson", poisson}}}};
}

Json joint(const std::string& a, const std::string& b, const std::string& type, const std::string& at_a = "end",
           const std::string& at_b = "start") {
  return {{"a", a}, {"at_a", at_a}, {"b", b}, {"at_b", at_b}, {"type", type}};
}
Json end_load(const std::string& type, const Vec3& value, const std::string& at = "end") {
  return {{"type", type}, {"at", at}, {"value", point(value)}};
}
Json dynamic(double step, double end, double rho_inf = 1.0) {
  return {{"step", step}, {"end", end}, {"beam", {{"rho_inf", rho_inf}, {"tolerance", 1e-12}}}};
}
Json statics(double step = 1.0) {
  return {{"step", step}, {"end", 1.0}, {"beam", {{"scheme", "static"}, {"tolerance", 1e-12}}}};
}

const std::vector<double>& state(CoupledCase& test, const char* name) {
  for (const auto& [key, values] : test.beams().state())
    if (key == name) return *values;
  throw std::logic_error(name);
}

/// Positions, tangents and triads of nodes of the accepted state; rows of nodes [0, nodes) without node `skip`.
std::vector<double> configuration(CoupledCase& test, int skip) {
  std::vector<double> all;
  const std::vector<double>&q = test.beams().accepted_dofs(), &rotation = state(test, "rotation");
  for (std::size_t n = 0; n < q.size() / 6; ++n) {
    if (static_cast<int>(n) == skip) continue;
    all.insert(all.end(), &q[6 * n], &q[6 * n] + 6);
    const Vec3 r(&rotation[6 * n]);
    const Mat3 triad = Eigen::AngleAxisd(r.norm(), r.normalized()).toRotationMatrix();
    all.insert(all.end(), triad.data(), triad.data() + 9);
  }
  return all;
}

TEST(ShearJoints, HalvesAreOneFiber) {
  for (const bool curved : {false, true})
    for (const bool moving : {false, true}) {
      int iterations[2] = {0, 0};
      const auto run = [&](bool halves) {
        const auto half = [&](int i) {
          return curved ? arc(i * pi / 4, pi / 4) : line({0.5 * i, 0, 0}, {0.5 * (i + 1), 0, 0});
        };
        Json json;
        if (halves) {
          json["fibers"] = Json::array({shear_fiber("near", half(0), 3), shear_fiber("far", half(1), 3)});
          json["joints"] = Json::array({joint("near", "far", "rigid")});
        } else {
          json["fibers"] = Json::array({shear_fiber("all", curved ? arc(0, pi / 2) : line({0, 0, 0}, {1, 0, 0}), 6)});
        }
        json["fibers"][0]["clamped"] = "start";
        json["fibers"].back()["loads"] =
            Json::array({end_load("force", {0.3, 1.5, 0.9}), end_load("moment", {0.5, 0.2, -0.3})});
        json["time"] = moving ? dynamic(2e-3, 0.2, 0.9) : statics(0.25);
        CoupledCase test(json);
        for (int step = 0; step < (moving ? 100 : 4); ++step) iterations[halves] += test.step().newton;
        EXPECT_EQ(test.fibers().joints.size(), halves ? 1u : 0u);
        return configuration(test, halves ? 4 : -1);
      };
      const std::vector<double> one = run(false), two = run(true);
      const double difference = relative_difference(two, one), rotation = std::abs(one.back() - 1);
      const std::string name = std::string(curved ? "curved" : "straight") + (moving ? ", dynamic" : ", static");
      report("two halves, " + name, difference);
      report("two halves, " + name + ", turn of the end", rotation);
      report("Newton iterations of one", iterations[0]);
      report("Newton iterations of two", iterations[1]);
      EXPECT_GT(rotation, 0.01);
      EXPECT_LE(difference, 1e-9);
      record(
          {.section = moving ? "Fibers: dynamics" : "Fibers: statics",
           .check = "simo_reissner, " + std::string(curved ? "quarter circle" : "straight") +
                    " cut into two halves with a rigid joint against one piece, end force and moment with torsion, " +
                    (moving ? "100 steps: positions, tangents, sections" : "positions, tangents, sections"),
           .source = "identity",
           .error = difference,
           .bar = "1e-9"});
    }
}

// The other way round and with other axes: the second half runs from its tip to the joint.
TEST(ShearJoints, HalvesThatMeetHeadOnWithOtherAxes) {
  for (const bool moving : {false, true}) {
    const auto run = [&](bool halves) {
      Json json;
      json["fibers"] = Json::array({round_fiber("near", halves ? arc(0, pi / 4) : arc(0, pi / 2), halves ? 3 : 6)});
      if (halves) {
        json["fibers"].push_back(round_fiber("far", arc(pi / 2, -pi / 4), 3));
        json["fibers"][1]["section"]["direction"] = {0.3, 0.2, 1};
        json["joints"] = Json::array({joint("far", "near", "rigid", "end", "end")});
      }
      json["fibers"][0]["clamped"] = "start";
      json["fibers"].back()["loads"] = Json::array({end_load("force", {0.3, 1.5, 0.9}, halves ? "start" : "end"),
                                                    end_load("moment", {0.5, 0.2, -0.3}, halves ? "start" : "end")});
      json["time"] = moving ? dynamic(2e-3, 0.1) : statics(0.25);
      CoupledCase test(json);
      test.run(moving ? 50 : 4);
      const std::vector<double>& q = test.beams().accepted_dofs();
      const std::size_t tip = halves ? 6 * 4 : q.size() - 6;
      return std::vector<double>(q.begin() + tip, q.begin() + tip + 3);
    };
    const double difference = relative_difference(run(true), run(false));
    report("halves head on", difference);
    EXPECT_LE(difference, 1e-9);
  }
}

// An elbow of two arms a, b under a tip force F across: F (a^3 + b^3)/(3 EI) + F a b^2/(GJ) + F (a + b)/(k G A), the
// last term of an arm only where it can shear. The clamp carries F, F a and the torque F b.
TEST(ShearJoints, ElbowBendsAndTwists) {
  const double a = 1.0, b = 0.6, force = 1e-5, nu = 0.25, radius = 0.02;
  const double shear = 0.9 / (2 * (1 + nu)) * pi * radius * radius / (0.25 * pi * std::pow(radius, 4));
  for (const std::string second : {"simo_reissner", "torsion_free"}) {
    Json json;
    json["fibers"] = Json::array({round_fiber("first", line({0, 0, 0}, {a, 0, 0}), 3, nu, radius),
                                  round_fiber("second", line({a, 0, 0}, {a, b, 0}), 3, nu, radius)});
    if (second == "torsion_free") {
      json["fibers"][1]["formulation"] = second;
      json["fibers"][1]["material"].erase("poisson");
    }
    json["fibers"][0]["clamped"] = "start";
    json["fibers"][1]["loads"] = Json::array({end_load("force", {0, 0, force})});
    json["joints"] = Json::array({joint("first", "second", "rigid")});
    json["time"] = statics();
    CoupledCase test(json);
    test.run(1);
    const double sheared = second == "torsion_free" ? a : a + b;
    const double exact = force * ((a * a * a + b * b * b) / 3 + a * b * b * (1 + nu) + sheared / shear);
    const double found = test.tip(1)[2];
    report("elbow, " + second + ", tip error", found / exact - 1);
    EXPECT_NEAR(found / exact, 1.0, 1e-6);
    record({.section = "Fibers: statics",
            .check = "elbow of a simo_reissner and a " + second +
                     " arm with a rigid joint under a force across its plane (bending, torsion, shear): tip",
            .source = "beam theory",
            .reference = exact,
            .ours = found,
            .bar = "1e-6"});
    const std::vector<double> r = test.beams().reactions({});
    const Vec3 expected(-b * force, a * force, 0);
    const double error = (Vec3(&r[3]) - expected).norm() / expected.norm();
    report("elbow, clamp moment", error);
    EXPECT_LE(std::abs(r[2] + force), 1e-9 * force);
    EXPECT_LE(error, 1e-6);
    record({.section = "Fibers: statics",
            .check = "the same elbow, moment of the clamp (torque F b, bending F a)",
            .source = "statics",
            .error = error,
            .bar = "1e-6"});
  }
}

// A fixed fiber holds the section of a jointed one as a clamp does.
TEST(ShearJoints, JointToAFixedFiberIsAClamp) {
  for (const bool moving : {false, true}) {
    const auto run = [&](bool jointed) {
      Json json;
      json["fibers"] = Json::array({shear_fiber("arm", arc(0, 1.0), 4)});
      json["fibers"][0]["loads"] =
          Json::array({end_load("force", {0.3, 1.5, 0.9}), end_load("moment", {0.5, 0.2, -0.3})});
      if (jointed) {
        json["fibers"].push_back({{"name", "wall"},
                                  {"curve", line({0, 0, 0}, {-0.2, 0.5, 0.3})},
                                  {"elements", 1},
                                  {"formulation", "fixed"}});
        json["joints"] = Json::array({joint("arm", "wall", "rigid", "start", "start")});
      } else {
        json["fibers"][0]["clamped"] = "start";
      }
      json["time"] = moving ? dynamic(2e-3, 0.1) : statics(0.25);
      CoupledCase test(json);
      test.run(moving ? 50 : 4);
      std::vector<double> q = test.beams().accepted_dofs();
      q.resize(6 * 5);
      return q;
    };
    const double difference = relative_difference(run(true), run(false));
    report("joint to a fixed fiber against a clamp", difference);
    EXPECT_LE(difference, 1e-9);
    if (!moving) continue;
    record({.section = "Fibers: dynamics",
            .check = "simo_reissner with a rigid joint to a fixed fiber against a clamped one, 50 steps",
            .source = "identity",
            .error = difference,
            .bar = "1e-9"});
  }
}

// A rod that turns about hinges between others: the hinge carries no moment.
TEST(ShearJoints, HingeBetweenBothFormulations) {
  Json json;
  json["fibers"] = Json::array({round_fiber("left", line({0, 0, 0}, {0, 1, 0}), 2),
                                round_fiber("right", line({2, 0, 0}, {2, 1, 0}), 2),
                                round_fiber("beam", line({0, 1, 0}, {2, 1, 0}), 2)});
  json["fibers"][1]["formulation"] = "torsion_free";
  json["fibers"][1]["material"].erase("poisson");
  json["fibers"][2]["formulation"] = "torsion_free";
  json["fibers"][2]["material"].erase("poisson");
  for (int side = 0; side < 2; ++side) json["fibers"][side]["clamped"] = "start";
  const double force = 1e-5, shear = 0.9 / 2.5 * 4 / (0.02 * 0.02);
  json["fibers"][0]["loads"] = Json::array({end_load("force", {force, 0, 0})});
  json["joints"] = Json::array({Json{{"touching", 1e-6}}});
  json["time"] = statics();
  CoupledCase test(json);
  test.run(1);
  // the columns share the force by their compliances 1/3 + 1/(k G A) and, behind the beam, 1/3 + 2/(E A)
  const double c = 1.0 / 3 + 1 / shear, d = 1.0 / 3 + 2 * 0.02 * 0.02 / 4, exact = force * c * d / (c + d);
  report("hinged frame, sway error", test.tip(0)[0] / exact - 1);
  EXPECT_NEAR(test.tip(0)[0] / exact, 1.0, 1e-5);
}

// Large deflections in space: the clamp carries the moment of the loads on the deformed fiber.
TEST(Reactions, MomentOfAClampUnderLargeDeflections) {
  Json json;
  json["fibers"] = Json::array({shear_fiber("arm", arc(0, 1.2), 6)});
  json["fibers"][0]["clamped"] = "start";
  const Vec3 force(0.5, 1.5, 2.0), moment(0.4, -0.3, 0.2);
  json["fibers"][0]["loads"] = Json::array({end_load("force", force), end_load("moment", moment)});
  json["time"] = statics(0.2);
  CoupledCase test(json);
  test.run(5);
  const std::vector<double>&r = test.beams().reactions({}), &q = test.beams().accepted_dofs();
  const Vec3 tip(&q[q.size() - 6]), foot(&q[0]), expected = -((tip - foot).cross(force) + moment);
  const double error = (Vec3(&r[3]) - expected).norm() / expected.norm();
  report("moment of the clamp", expected.norm());
  report("moment of the clamp, error", error);
  EXPECT_LE((Vec3(&r[0]) + force).norm(), 1e-9 * force.norm());
  EXPECT_LE(error, 1e-9);
  record({.section = "Fibers: statics",
          .check = "simo_reissner, curved, large deflection by end force and moment: moment of the clamp against "
                   "r x F + M at the deformed fiber",
          .source = "statics",
          .reference = expected.norm(),
          .ours = Vec3(&r[3]).norm(),
          .error = error,
          .bar = "1e-9"});
}

// A free body of three fibers at angles, both formulations, under a dead force.
TEST(ShearJoints, FreeBodyKeepsMomentumAndAngles) {
  for (const double rho_inf : {1.0, 0.8}) {
    Json json;
    json["fibers"] = Json::array({shear_fiber("first", line({0, 0, 0}, {1, 0, 0}), 3),
                                  shear_fiber("second", line({1, 0, 0}, {1.4, 0.6, 0.3}), 3),
                                  round_fiber("third", line({1, 0, 0}, {1, 0, -1}), 3)});
    json["fibers"][2]["formulation"] = "torsion_free";
    json["fibers"][2]["material"].erase("poisson");
    const Vec3 force(0.0, 1.0, -0.5);
    json["fibers"][1]["loads"] = Json::array({end_load("force", force)});
    json["joints"] =
        Json::array({joint("first", "second", "rigid"), joint("second", "third", "rigid", "start", "start")});
    json["time"] = dynamic(4e-3, 1.2, rho_inf);
    CoupledCase test(json);
    double momentum = 0.0, angle = 0.0, energy = 0.0, largest = 0.0;
    Mat3 before;
    for (int step = 0; step <= 150; ++step) {
      if (step > 0) test.step();
      const std::vector<double>&q = test.beams().accepted_dofs(), &rotation = state(test, "rotation");
      const auto triad = [&](int node) {
        const Vec3 r(&rotation[6 * static_cast<std::size_t>(node)]);
        return Mat3(Eigen::AngleAxisd(r.norm(), r.normalized()).toRotationMatrix());
      };
      Mat3 now = triad(3).transpose() * triad(4);  // between sections, and from a section to the third tangent
      now.row(0) = (triad(3).transpose() * Vec3(&q[6 * 8 + 3]).normalized()).transpose();
      if (step == 0) before = now;
      angle = std::max(angle, (now - before).cwiseAbs().maxCoeff());
      const Vec3 expected = test.time() * force;
      momentum = std::max(momentum, (test.beams().linear_momentum(test.beams().accepted_velocity()) - expected).norm());
      const beam::Energy e = test.beams().energy();
      energy = std::max(energy, std::abs(e.internal + e.kinetic - e.external_work));
      largest = std::max(largest, e.kinetic + e.internal);
    }
    const double impulse = test.time() * force.norm();
    report("free body, momentum against impulse", momentum / impulse);
    report("free body, change of its angles", angle);
    report("free body, energy error", energy / largest);
    EXPECT_LE(momentum / impulse, 1e-9);
    EXPECT_LE(angle, 1e-9);
    EXPECT_LE(energy / largest, 0.02);
    record({.section = "Fibers: dynamics",
            .id = "S-D6",
            .check = log::format("free body of simo_reissner and torsion_free fibers with rigid joints, rho_inf %g: "
                                 "momentum against impulse",
                                 rho_inf),
            .source = "identity",
            .error = momentum / impulse,
            .bar = "1e-9"});
  }
}

// One step in time from rest under sudden loads, solved as the monolithic scheme does: residuals fall quadratically.
TEST(ShearJoints, NewtonConvergesQuadratically) {
  Json json;
  json["fibers"] = Json::array({shear_fiber("first", arc(0, 1.0), 3),
                                shear_fiber("second", line({std::sin(1.0), 1 - std::cos(1.0), 0}, {1.2, 0.9, 0.5}), 3),
                                round_fiber("third", line({std::sin(1.0), 1 - std::cos(1.0), 0}, {1, 0, -0.5}), 3)});
  json["fibers"][2]["formulation"] = "torsion_free";
  json["fibers"][2]["material"].erase("poisson");
  json["fibers"][0]["clamped"] = "start";
  json["fibers"][1]["loads"] = Json::array({end_load("force", {2, 1, 3}), end_load("moment", {0.3, 0.5, 0.2})});
  json["joints"] =
      Json::array({joint("first", "second", "rigid"), joint("second", "third", "rigid", "start", "start")});
  json["time"] = dynamic(0.01, 0.1);
  CoupledCase test(json), check(json);
  beam::BeamField& field = test.beams();
  field.begin_step(0.01, 0.01);
  std::vector<double> norms;
  for (int iteration = 0; iteration < 8; ++iteration) {
    field.linearize();
    std::vector<double> delta = field.residual();
    double sum = field.squared_moment_residual() + field.squared_joint_residual();
    for (double& entry : delta) {
      sum += entry * entry;
      entry = -entry;
    }
    norms.push_back(std::sqrt(sum));
    field.solve(delta);
    field.increment(delta);
  }
  double order = 0.0;  // of the last iteration above round-off
  std::string text;
  for (const double norm : norms) text += log::format(" %.1e", norm);
  for (std::size_t k = 0; k + 2 < norms.size(); ++k) {
    if (norms[k + 2] > 1e-11 * norms[0])
      order = std::log(norms[k + 2] / norms[k + 1]) / std::log(norms[k + 1] / norms[k]);
  }
  std::printf("residuals:%s\n", text.c_str());
  report("order of Newton", order);
  EXPECT_GE(order, 1.8);
  EXPECT_LE(norms.back(), 1e-11 * norms.front());
  record({.section = "Fibers: dynamics",
          .check = "three jointed fibers of both formulations, one step from rest: order of Newton's method",
          .source = "identity",
          .reference = 2.0,
          .ours = order,
          .bar = "at least 1.8"});
  // the built-in Newton finds the same
  check.step();
  EXPECT_LE(relative_difference(field.dofs(), check.beams().accepted_dofs()), 1e-10);
}

// A rigid frame thrown with a spin about no principal axis: its parts have the spins of one body.
TEST(ShearJoints, InitialVelocityOfARigidRotation) {
  Json json;
  json["fibers"] = Json::array({shear_fiber("first", line({0, 0, 0}, {1, 0, 0}), 3),
                                shear_fiber("second", line({1, 0, 0}, {1.4, 0.6, 0.3}), 3)});
  for (int f = 0; f < 2; ++f) json["fibers"][f]["velocity"] = {"-1*z-2*y", "2*x-0.5*z", "0.5*y+1*x"};
  json["joints"] = Json::array({joint("first", "second", "rigid")});
  json["time"] = dynamic(1e-3, 0.1);
  CoupledCase test(json);
  const Vec3 omega(0.5, -1, 2);
  const std::vector<double>&rotation = state(test, "rotation"), &spin = state(test, "spin");
  for (const std::size_t n : {std::size_t(0), std::size_t(3), std::size_t(4), std::size_t(7)}) {
    const Vec3 r(&rotation[6 * n]);
    EXPECT_LE((Eigen::AngleAxisd(r.norm(), r.normalized()) * Vec3(&spin[6 * n]) - omega).norm(), 1e-9);
  }
  test.run(5);
}

// ------------------------------------------------------------------------------------------------------ moved supports

// A clamped-clamped fiber of length L whose middle is moved by d: P (L^3/(192 EI) + L/(4 k G A)) = d.
TEST(MovedSupports, SettlementOfTheMiddle) {
  Json json;
  const double length = 2.0, settled = 1e-4, radius = 0.02, shear = 0.9 / 2.5 * 4 / (radius * radius);
  json["fibers"] = Json::array({round_fiber("beam", line({0, 0, 0}, {length, 0, 0}), 16, 0.25, radius)});
  json["fibers"][0]["clamped"] = "both";
  json["fibers"][0]["supports"] = Json::array(
      {Json{{"arc_length", 1.0}, {"type", "pinned"}, {"motion", {"0", log::format("%.17g*t", settled), "0"}}}});
  json["time"] = statics();
  CoupledCase test(json);
  test.run(1);
  const std::vector<double> r = test.beams().reactions({});
  const double exact = settled / (std::pow(length, 3) / 192 + length / (4 * shear)), found = r[6 * 8 + 1];
  report("settlement, reaction error", found / exact - 1);
  EXPECT_NEAR(found / exact, 1.0, 1e-4);  // the shear jumps at the support, the center line has no kink
  const double moment = exact * length / 8;
  EXPECT_NEAR(r[5] / moment, -1.0, 1e-4);
  record({.section = "Fibers: statics",
          .check = "simo_reissner, both ends clamped, middle support moved: its reaction",
          .source = "Timoshenko beam theory",
          .reference = exact,
          .ours = found,
          .bar = "1e-4"});
}

Json moved_pin() {
  return {{"arc_length", 0.5},
          {"type", "pinned"},
          {"motion", {"0.05*sin(6*t)^4", "0.15*sin(8*t)^4", "0.1*(1-cos(10*t))^2"}}};
}

// A fiber whose middle moves is that of two halves whose joint moves.
TEST(MovedSupports, MiddleOfOneFiberAndEndOfAHalf) {
  const auto run = [](bool halves) {
    Json json;
    Json pin = moved_pin();
    if (halves) {
      json["fibers"] = Json::array(
          {shear_fiber("near", line({0, 0, 0}, {0.5, 0, 0}), 3), shear_fiber("far", line({0.5, 0, 0}, {1, 0, 0}), 3)});
      json["joints"] = Json::array({joint("near", "far", "rigid")});
      pin.erase("arc_length");
      pin["at"] = "start";
    } else {
      json["fibers"] = Json::array({shear_fiber("all", line({0, 0, 0}, {1, 0, 0}), 6)});
    }
    json["fibers"].back()["supports"] = Json::array({pin});
    json["fibers"][0]["clamped"] = "start";
    json["fibers"].back()["loads"] = Json::array({end_load("moment", {0.5, 0.2, -0.3})});
    json["time"] = dynamic(2e-3, 0.3, 0.8);
    CoupledCase test(json);
    test.run(150);
    std::vector<double> all = configuration(test, halves ? 4 : -1);
    const Vec3 carried = test.total(test.beams().reactions({}));
    all.insert(all.end(), carried.data(), carried.data() + 3);
    return all;
  };
  const double difference = relative_difference(run(true), run(false));
  report("moved middle, halves against one piece", difference);
  EXPECT_LE(difference, 1e-9);
  record({.section = "Fibers: dynamics",
          .check = "simo_reissner whose middle support moves against two halves whose joint moves, 150 steps: "
                   "positions, tangents, sections, reactions",
          .source = "identity",
          .error = difference,
          .bar = "1e-9"});
}

TEST(MovedSupports, TiedToWhatIsHeldIsRefused) {
  Json json;
  json["fibers"] = Json::array(
      {shear_fiber("near", line({0, 0, 0}, {0.5, 0, 0}), 2), shear_fiber("far", line({0.5, 0, 0}, {1, 0, 0}), 2)});
  Json pin = moved_pin();
  pin.erase("arc_length");
  pin["at"] = "start";
  json["fibers"][0]["clamped"] = "end";
  json["fibers"][1]["supports"] = Json::array({pin});
  json["joints"] = Json::array({joint("near", "far", "position")});
  json["time"] = dynamic(2e-3, 0.3);
  try {
    CoupledCase test(json);
    FAIL() << "not refused";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::geometry);
    EXPECT_NE(std::string(error.what()).find("support that moves"), std::string::npos) << error.what();
  }
}

// Seen from clamps that all move by u(t), a fiber is one with fixed clamps under the line load -rho A u''.
TEST(MovedSupports, MovedClampsAreAnInertialLoad) {
  const auto tip = [](bool moved, int steps) {
    Json json;
    json["fibers"] = Json::array({shear_fiber("arm", line({0, 0, 0}, {1.2, 0, 0}), 4)});
    Json clamp = {{"arc_length", 0.6}, {"type", "clamped"}};
    if (moved) {
      clamp["motion"] = {"0.1*t^4", "0.3*t^5", "-0.2*t^4"};
    } else {
      json["fibers"][0]["loads"] =
          Json::array({Json{{"type", "line"}, {"value", {"-0.5*1.2*t^2", "-0.5*6*t^3", "0.5*2.4*t^2"}}}});
    }
    json["fibers"][0]["supports"] = Json::array({clamp});
    json["time"] = dynamic(1.0 / steps, 1.0, 0.9);
    CoupledCase test(json);
    test.run(steps);
    Vec3 u = test.tip();
    if (moved) u -= Vec3(0.1, 0.3, -0.2);
    return u;
  };
  double error[2], size = 0.0;
  for (int i = 0; i < 2; ++i) {
    const int steps = 100 << i;
    const Vec3 still = tip(false, steps);
    error[i] = (tip(true, steps) - still).norm();
    size = still.norm();
  }
  const double order = std::log2(error[0] / error[1]);
  report("moved clamps against the inertial load, difference", error[1] / size);
  report("its order", order);
  EXPECT_LE(error[1] / size, 1e-3);
  EXPECT_NEAR(order, 2.0, 0.2);
  record({.section = "Fibers: dynamics",
          .check = "simo_reissner, clamp in the middle moved by formulas against the inertial line load in its frame: "
                   "tip at t = 1, dt = 1/200, 1/100",
          .source = "exact equivalence",
          .error = error[1] / size,
          .order = order,
          .bar = "1e-3, order 2"});
}

}  // namespace
}  // namespace fbi::test
