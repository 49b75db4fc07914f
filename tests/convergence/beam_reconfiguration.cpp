/// S-C4: a flexible blade that a fast stream bends, with a drag that follows from its shape (Luhar and Nepf 2011).
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "base/log.hpp"
#include "fem/line_shapes.hpp"
#include "record.hpp"
#include "unit/beam/straight_fiber.hpp"

namespace fbi::beam {
namespace {

constexpr int elements = 40, degree = 16;

/// Center line of a static shape, clamped at s = 0, along z at rest.
struct Shape {
  const std::vector<double>& dofs;
  Vec3 tangent(double s) const {
    const int e = std::min(elements - 1, static_cast<int>(s * elements));
    const double length = 1.0 / elements;
    const std::array<double, 4> h = fem::hermite_first(2 * (s * elements - e) - 1);
    Vec3 r = Vec3::Zero();
    for (int i = 0; i < 4; ++i) r += h[i] * (i % 2 == 0 ? 1.0 : 0.5 * length) * Vec3(&dofs[6 * e + 3 * i]);
    return r.normalized();
  }
};

/// Formula of z with the values g(s) at the Chebyshev points of [0, 1]: powers of x = 2 z - 1 in Horner's form.
std::string formula(const std::vector<double>& g) {
  const int n = degree + 1;
  std::vector<double> power(n, 0.0), before(n, 0.0), now(n, 0.0);
  now[0] = 1.0;
  for (int k = 0; k < n; ++k) {  // T_k in powers, times its coefficient
    double c = 0.0;
    for (int j = 0; j < n; ++j) c += (k == 0 ? 1.0 : 2.0) / n * g[j] * std::cos(M_PI * k * (j + 0.5) / n);
    for (int i = 0; i < n; ++i) power[i] += c * now[i];
    std::vector<double> next(n, 0.0);
    for (int i = 0; i < n; ++i) {
      if (i + 1 < n) next[i + 1] += (k == 0 ? 1.0 : 2.0) * now[i];
      if (k > 0) next[i] -= before[i];
    }
    before = now;
    now = next;
  }
  std::string text = log::format("%.17g", power[n - 1]);
  for (int i = n - 2; i >= 0; --i) text = log::format("(%.17g)+(2*z-1)*(%s)", power[i], text.c_str());
  return text;
}

struct Blade {
  double effective = 0.0, height = 0.0, reach = 0.0;  ///< int cos^3, tip z, tip x
};

/// Load Ca cos^2(theta) across the blade and B along z, both dead loads; theta is that of the last shape.
Blade blade(double ca, double buoyancy) {
  FiberParameters group = test::stiffness(1e6, 1.0);
  group.start = EndCondition::clamped;
  Load load;
  load.type = LoadType::line;
  std::vector<double> across(degree + 1, 1.0), down(degree + 1, 0.0);
  double level = std::min(ca, 1.0);
  const double relaxation = 1 / (1 + std::sqrt(ca) / 2);
  Blade result;
  for (int iteration = 0; iteration < 1000; ++iteration) {
    const auto value = [&](double factor, const std::vector<double>& g, double constant) {
      return input::Expression(log::format("%.17g+%.17g*(", constant, factor) + formula(g) + ")");
    };
    load.value = {value(level, across, 0.0), 0.0, value(-level, down, buoyancy)};
    group.loads = {load};
    const mesh::FiberMesh fiber = test::straight_fiber({0, 0, 0}, {0, 0, 1}, 1.0, elements);
    const test::StaticSolution s = test::solve_static(fiber, group, 8);
    EXPECT_TRUE(s.converged) << "Ca " << level;
    if (!s.converged) return result;
    const Shape shape{s.dofs};
    double change = 0.0;
    for (int j = 0; j <= degree; ++j) {
      const Vec3 t = shape.tangent(0.5 * (1 + std::cos(M_PI * (j + 0.5) / (degree + 1))));
      const double step[2] = {t[2] * t[2] * t[2] - across[j], t[2] * t[2] * t[0] - down[j]};
      change = std::max({change, std::abs(step[0]), std::abs(step[1])});
      across[j] += relaxation * step[0];
      down[j] += relaxation * step[1];
    }
    if (level >= ca && change < 1e-8) {
      constexpr int points = 4000;
      for (int p = 0; p < points; ++p) result.effective += std::pow(shape.tangent((p + 0.5) / points)[2], 3) / points;
      result.height = s.tip()[2];
      result.reach = s.tip()[0];
      return result;
    }
    level = std::min(ca, level * 1.2);
  }
  ADD_FAILURE() << "no shape found";
  return result;
}

void check(double buoyancy, double ca, const Blade& reference, double bar) {
  const Blade ours = blade(ca, buoyancy);
  const auto row = [&](const char* name, double value, double known) {
    std::printf("B %g, Ca %g, %s: %.7f, reference %.7f, error %.1e\n", buoyancy, ca, name, value, known,
                value / known - 1);
    fbi::test::record({.section = "Fibers: statics",
                       .id = "S-C4",
                       .check = log::format("blade in a stream, Ca %g, B %g: %s", ca, buoyancy, name),
                       .source = "Luhar and Nepf 2011, computed independently",
                       .reference = known,
                       .ours = value,
                       .bar = log::format("%g", bar)});
    EXPECT_NEAR(value, known, bar * known);
  };
  row("effective length", ours.effective, reference.effective);
  row("height of the tip", ours.height, reference.height);
  row("reach of the tip", ours.reach, reference.reach);
}

TEST(Reconfiguration, OfABladeInAStream) {
  check(0, 1, {0.9748331, 0.9915185, 0.1215333}, 1e-5);
  check(0, 10, {0.5236123, 0.7906237, 0.5682945}, 1e-5);
  check(0, 100, {0.1917895, 0.4534606, 0.8241673}, 1e-4);
  check(10, 10, {0.7447088, 0.9039939, 0.4032350}, 1e-5);
  check(10, 100, {0.2284358, 0.5362697, 0.7899429}, 1e-4);
  check(50, 100, {0.3867685, 0.7114638, 0.6735082}, 1e-4);
}

}  // namespace
}  // namespace fbi::beam
