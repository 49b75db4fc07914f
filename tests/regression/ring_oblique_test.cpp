/// A fiber on a ring, from corner to corner through a periodic cube along (1,1,0): its radius, and how smooth its force
/// is.
#include "regression/rigid_fiber_flow.hpp"

namespace fbi::test {
namespace {

constexpr double pi = std::numbers::pi;
constexpr int n = 12;

/// Unit cube of n^3 cells, driven by a force of 1 per volume along `direction`; the fiber lies at z.
Json oblique(const Vec3& direction, double z, double radius, int elements) {
  Json json = fiber_in_cube(n, 0);
  for (int i = 0; i < 3; ++i) json["fluid"]["body_force"][i] = log::format("%.17g", 1e6 * direction[i]);
  json["fibers"][0]["curve"] = {{"type", "line"}, {"from", {0.0, 0.0, z}}, {"to", {1.0, 1.0, z}}};
  json["fibers"][0]["elements"] = elements;
  json["fibers"][0]["section"] = {{"radius", radius}};
  json["coupling"] = {{"operator", "ring"}, {"penalty", 1e6}};
  return json;
}

TEST(ObliqueFiber, RadiusWithoutCompliance) {
  struct Way {
    const char* name;
    Vec3 direction;
    double factor, constant, radius;
  };
  const double d = std::numbers::sqrt2 / 2;
  const Way ways[] = {{"along", {d, d, 0}, 2 * pi, 1.44369, 0.664},
                      {"out of plane", {0, 0, 1}, 4 * pi, 1.68171, 0.550},
                      {"in plane", {d, -d, 0}, 4 * pi, 1.20567, 0.579}};
  const double above = 0.25;  // height of the fiber over a plane of nodes, in h
  const Mat3 lattice = oblique_ring_velocity(n, above);
  for (const Way& way : ways) {
    CoupledCase run(oblique(way.direction, 0.5 + above / n, 0.1 / n, n));
    run.step();
    const double force = run.drag().dot(way.direction) / std::numbers::sqrt2;
    EXPECT_NEAR(force * std::numbers::sqrt2, 1.0, 1e-5);
    const double velocity = mean_velocity(run).dot(way.direction);
    const double ours = n * std::exp(-(way.factor * velocity / force + way.constant));
    const std::string check = log::format(
        "ring of radius h/2, fiber along (1,1,0) through a periodic cube, flow %s: radius over h", way.name);
    report(check, ours);
    const double exact = n * std::exp(-(way.factor * way.direction.dot(lattice * way.direction) + way.constant));
    const auto row = [&](const char* source, double reference, double bar) {
      record({.section = "Coupling",
              .check = check,
              .source = source,
              .reference = reference,
              .ours = ours,
              .bar = log::format("%g %%", 100 * bar)});
      EXPECT_NEAR(ours, reference, bar * reference);
    };
    row("the discrete equations, mode by mode, uniform force", exact, 0.01);
    row("the same operator, computed independently", way.radius, 0.03);
  }
}

/// Largest |lambda/mean - 1| along the force, multipliers 0.35 h apart.
double ripple(const char* multiplier, bool automatic, const Vec3& direction) {
  const bool points = multiplier == std::string("gauss_point");
  const int pieces = static_cast<int>(std::lround(std::numbers::sqrt2 * n / 0.35));
  Json json = oblique(direction, 0.5, 0.3 / n, points ? (pieces + 1) / 2 : pieces);
  json["coupling"]["multiplier"] = multiplier;
  if (points) {
    json["coupling"]["integration"] = "element";
    json["coupling"]["gauss_points"] = 2;
  }
  if (automatic) json["coupling"]["penalty"] = "auto";
  CoupledCase run(json);
  run.step();
  const std::vector<double>& lambda = run.system().lambda();
  double mean = 0.0, largest = 0.0;
  for (std::size_t k = 0; k < lambda.size(); k += 3) mean += Vec3(&lambda[k]).dot(direction) * 3 / lambda.size();
  for (std::size_t k = 0; k < lambda.size(); k += 3)
    largest = std::max(largest, std::abs(Vec3(&lambda[k]).dot(direction) / mean - 1));
  return largest;
}

TEST(ObliqueFiber, RippleOfTheForce) {
  const double d = std::numbers::sqrt2 / 2;
  for (const char* multiplier : {"linear", "gauss_point"})
    for (const auto& [name, direction] : {std::pair{"along", Vec3(d, d, 0)}, {"out of plane", Vec3(0, 0, 1)}}) {
      const double ours = ripple(multiplier, true, direction), infinite = ripple(multiplier, false, direction);
      report(std::string("ripple with auto, ") + multiplier + ", " + name, ours);
      report("the same with an infinite penalty", infinite);
      record({.section = "Coupling",
              .check = log::format("ring, %s multipliers 0.35 h apart, flow %s: largest |lambda/mean - 1| with auto; "
                                   "with penalty 1e6 mu %.3g",
                                   multiplier, name, infinite),
              .source = "smooth force",
              .reference = 0.0,
              .ours = ours,
              .bar = "0.12, a tenth of the other"});
      EXPECT_LT(ours, 0.12);
      EXPECT_LT(ours, 0.1 * infinite);
    }
}

}  // namespace
}  // namespace fbi::test
