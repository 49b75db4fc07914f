/// Straight fibers whose radius the mesh decides: along and across ducts, between plates, falling. What a calibration
/// on the same cells predicts.
#include "regression/straight_fibers.hpp"

namespace fbi::test {
namespace {

constexpr double pi = std::numbers::pi;

double duct_drag(int n) {
  CoupledCase run(duct(n));
  return solve_for_force(run, 2.0 / n)[2] * -1.0;
}

TEST(Duct, FiberAlongItsAxis) {
  constexpr double known_drag[2][2] = {{1.252878, 1.100799}, {1.905502, 1.580681}}, known_radius[] = {0.1146, 0.6582};
  for (const int odd : {0, 1}) {
    double calibrated = 0.0;
    for (const int level : {0, 1}) {
      const int n = (level == 0 ? 32 : 64) + odd;
      const double drag = duct_drag(n), radius = n * duct_radius(drag);
      const std::string check = log::format("fiber along a square duct, %d cells, %s: ", n, place_of(n));
      check_number("S-H2", check + "F/(mu U)", "the discrete equations, sums of sines", 1 / duct_velocity(n), drag,
                   1e-4);
      check_number("S-H2", check + "F/(mu U)", "2D finite elements, computed independently", known_drag[odd][level],
                   drag, 1e-4);
      check_number("S-H2", check + "radius of the mesh a/h", "the same", known_radius[odd], radius, 1e-2);
      if (level == 0)
        calibrated = radius;
      else
        check_number("S-H2", check + "F/(mu U) predicted from the radius on half as many", "2 pi/ln(0.539 L/a)",
                     2 * pi / std::log(duct_constant * n / calibrated), drag, 1e-2);
    }
  }
}

double plates_drag(int n) {
  CoupledCase run(plates(n));
  return -solve_for_force(run, 2.0 / n)[0];
}

TEST(Plates, FiberMidwayBetweenThem) {
  for (const int n : {24, 25}) {
    const double radius = transverse_radius(n);  // over h, from the square array
    check_number(
        "S-H3",
        log::format("fiber midway between plates, %d cells, %s: F/(mu U) from the radius in the array", n, place_of(n)),
        "Faxen 1946", faxen(2 * radius / n), plates_drag(n), 2e-2);
  }
}

/// A light fiber reaches its final speed in some 1e-4; it falls 1e-5 until then.
TEST(Duct, FallingFiber) {
  const double weight = 0.02, mass = 1e-4, dt = 2e-5, area = pi * 1e-4;
  for (const int n : {12, 13}) {
    Json json = duct(n);
    for (const char* face : {"xmin", "xmax", "ymin", "ymax"})
      json["channel"]["boundaries"][face] = parse_json(R"({ "type": "no_slip" })");
    json["fibers"][0]["formulation"] = "rigid";
    json["fibers"][0]["section"] = {{"radius", 0.01}};
    json["fibers"][0]["material"] = {{"density", mass / area}};
    json["gravity"] = {0.0, 0.0, weight / mass};
    json["buoyancy"] = false;
    json["time"] = parse_json(R"({ "fluid": { "scheme": "one_step_theta" } })");
    json["time"]["step"] = dt;
    json["time"]["end"] = 40 * dt;
    json["solver"]["linear"] = "direct";
    json["solver"]["newton_absolute_tolerance"] = 1e-6;  // of inertial forces, which are small here
    CoupledCase run(json);
    run.run(39);
    const double before = run.tip()[2];
    run.step();
    const double speed = (run.tip()[2] - before) / dt;
    check_number("S-H4", log::format("rigid fiber falling along a square duct, %d cells, %s: U mu/W", n, place_of(n)),
                 "ln(0.539 L/a)/(2 pi), a of the fixed fiber",
                 std::log(duct_constant / duct_radius(duct_drag(n))) / (2 * pi), speed / weight, 1e-3);
  }
}

}  // namespace
}  // namespace fbi::test
