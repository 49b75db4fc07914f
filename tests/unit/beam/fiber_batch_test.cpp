/// Fibers in batches against the same fibers one by one: different geometry, loads, sections and supports, batches that
/// are not full, lanes that are singular.
#include "beam/fiber_batch.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "beam/beam_field.hpp"
#include "beam/fiber_equations.hpp"
#include "unit/beam/straight_fiber.hpp"

namespace fbi::beam {
namespace {

class Scene {
 public:
  mesh::FiberMesh mesh;
  std::vector<FiberParameters> groups;
  std::mt19937 generator{7};

  // Fibers of all groups mixed; elements and lengths differ.
  Scene() {
    FiberParameters clamped = test::stiffness(40.0, 0.7, 1.3);
    clamped.start = EndCondition::clamped;
    clamped.loads = {test::load(LoadType::force, {0.1, -0.2, 0.3})};
    FiberParameters pinned = test::stiffness(25.0, 0.4, 0.8);
    pinned.start = pinned.end = EndCondition::pinned;
    pinned.loads = {test::load(LoadType::line, {0.3, 0.1, 0.2})};
    FiberParameters guided = test::stiffness(30.0, 0.5, 0.9);
    guided.start = EndCondition::guided;
    const FiberParameters free = test::stiffness(35.0, 0.6, 1.1);
    FiberParameters stiff = clamped;  // shares the batches of the first group
    stiff.material.young = 50.0;
    FiberParameters moment = clamped;  // one by one
    moment.loads.push_back(test::load(LoadType::moment, {0.2, 0.1, 0.3}));
    groups = {clamped, pinned, guided, free, stiff, moment};
    for (int k = 0; k < 61; ++k) {
      const Vec3 direction = Vec3(random(), random(), random()).normalized();
      test::add_straight_fiber(mesh, {random(), random(), random()}, direction, 1.0 + 0.3 * random(),
                               k % 5 == 4 ? 1 : 3, k % static_cast<int>(groups.size()));
    }
  }
  double random() { return std::uniform_real_distribution<double>(-1.0, 1.0)(generator); }

  FiberEquations equations(TimeScheme scheme) const {
    BeamTimeParameters time;
    time.scheme = scheme;
    time.rho_inf = 0.7;
    return FiberEquations(mesh, groups, time, {0.1, -0.2, 0.3});
  }

  // An iterate and a state without order.
  void disturb(FiberEquations& equations) {
    for (NodalField* field : {&equations.dofs, &equations.acceleration, &equations.acceleration_n,
                              &equations.internal_n, &equations.external_n})
      for (double& value : *field) value += 0.01 * random();
    equations.level = {};
    equations.level.dynamic = equations.parameters.scheme != TimeScheme::static_;
    if (!equations.level.dynamic) return;
    equations.level.dt = 0.05;
    equations.level.internal = 1 - equations.scheme.alpha_f;
    equations.level.previous = equations.scheme.alpha_f;
    equations.level.inertia = equations.scheme.inertia_per_displacement(0.05);
  }
};

void expect_equal(const double* expected, const double* actual, std::size_t size, double tolerance, const char* what) {
  double scale = 0.0;
  for (std::size_t i = 0; i < size; ++i) scale = std::max(scale, std::abs(expected[i]));
  for (std::size_t i = 0; i < size; ++i)
    ASSERT_NEAR(actual[i], expected[i], tolerance * (scale + 1e-300)) << what << ", entry " << i;
}

TEST(FiberBatch, EqualsOneFiberAfterTheOther) {
  for (const TimeScheme scheme : {TimeScheme::static_, TimeScheme::generalized_alpha}) {
    Scene scene;
    FiberEquations one = scene.equations(scheme), many = scene.equations(scheme);
    scene.generator.seed(3);
    scene.disturb(one);
    scene.generator.seed(3);
    scene.disturb(many);
    many.evaluate_all(true);
    many.factorize_all();
    std::vector<double> all_b(one.dofs.size());
    for (double& value : all_b) value = scene.random();
    std::vector<double> all_x = all_b;
    many.batches->solve(all_x.data());
    Index batched = 0, factorized = 0;
    for (Index f = 0; f < scene.mesh.fibers(); ++f) {
      one.evaluate(f, true);
      one.factorize(f);
      const Fiber& fiber = one.fibers[f];
      const std::size_t first = fiber.first_dof(), size = static_cast<std::size_t>(fiber.dofs());
      expect_equal(&one.internal[first], &many.internal[first], size, 1e-13, "internal");
      expect_equal(&one.external[first], &many.external[first], size, 0.0, "external");
      expect_equal(&one.full[first], &many.full[first], size, 1e-13, "full");
      expect_equal(&one.residual[first], &many.residual[first], size, 1e-13, "residual");
      expect_equal(&one.scale[f], &many.scale[f], 1, 1e-13, "scale");
      expect_equal(&one.round_off[f], &many.round_off[f], 1, 1e-13, "round_off");
      EXPECT_EQ(many.batches->has(f), scene.mesh.group[f] != 5);
      batched += many.batches->has(f);
      factorized += many.batches->is_factorized(f);
      EXPECT_EQ(one.singular[f], many.singular[f]);
      if (one.singular[f]) continue;
      // In statics nothing but round-off holds those that can move as a whole.
      const bool determined = scheme != TimeScheme::static_ || scene.mesh.group[f] == 1 || scene.mesh.group[f] == 0 ||
                              scene.mesh.group[f] >= 4;
      if (!determined) continue;
      for (const Index columns : {1, 11}) {
        std::vector<double> x(size * columns), y;
        for (double& value : x) value = scene.random();
        y = x;
        one.solve(f, x.data(), columns);
        many.solve(f, y.data(), columns);
        expect_equal(x.data(), y.data(), x.size(), 1e-9, "solve");
      }
      if (!many.batches->is_factorized(f)) continue;
      std::vector<double> x(&all_b[first], &all_b[first] + size);
      one.solve(f, x.data(), 1);
      expect_equal(x.data(), &all_x[first], size, 1e-9, "solve of all");
    }
    EXPECT_GT(batched, 48);
    if (scheme != TimeScheme::static_) {
      EXPECT_EQ(factorized, batched);
    }
    many.evaluate_all(false);
    expect_equal(one.residual.data(), many.residual.data(), one.residual.size(), 1e-13, "residual alone");
  }
}

TEST(FiberBatch, SingularLanesAreSolvedOneByOneAndIndefiniteOnesGoDownhill) {
  // Eight and three fibers: one whose iterate is not a number, and two that are compressed.
  mesh::FiberMesh mesh;
  FiberParameters clamped = test::stiffness(40.0, 0.7);
  clamped.start = EndCondition::clamped;
  for (int k = 0; k < 11; ++k) test::add_straight_fiber(mesh, {0, 0, 0.5 * k}, {1, 0, 0}, 1.0, 3);
  BeamTimeParameters time;
  time.scheme = TimeScheme::static_;
  FiberEquations one(mesh, {clamped}, time, Vec3::Zero()), many(mesh, {clamped}, time, Vec3::Zero());
  const double none = std::numeric_limits<double>::quiet_NaN();
  for (FiberEquations* equations : {&one, &many}) {
    // fiber 1: not a number; fiber 4 and 9: compressed along the axis beyond buckling
    equations->dofs[equations->fibers[1].first_dof() + 7] = none;
    for (const Index f : {4, 9})
      for (Index node = 0; node < 4; ++node) {
        double* q = &equations->dofs[equations->fibers[f].first_dof() + 6 * static_cast<std::size_t>(node)];
        q[0] *= 0.7;
        q[3] *= 0.7;
      }
  }
  many.evaluate_all(true);
  many.factorize_all();
  for (Index f = 0; f < mesh.fibers(); ++f)
    EXPECT_EQ(many.batches->is_factorized(f), f != 1 && f != 4 && f != 9) << f;
  many.downhill = true;
  many.evaluate_all(true);
  many.factorize_all();
  for (Index f = 0; f < mesh.fibers(); ++f) {
    one.evaluate(f, true);
    one.factorize(f);
    const bool compressed = f == 4 || f == 9;
    EXPECT_EQ(many.batches->is_factorized(f), f != 1) << f;
    EXPECT_EQ(many.singular[f] != 0, f == 1) << f;
    std::vector<double> x(24, 1.0), y(24, 1.0);
    one.solve(f, x.data(), 1);
    many.solve(f, y.data(), 1);
    for (std::size_t i = 0; i < x.size(); ++i) {
      if (f == 1) {
        EXPECT_TRUE(std::isnan(y[i]));
      } else if (!compressed) {
        EXPECT_NEAR(y[i], x[i], 1e-10 * (1 + std::abs(x[i])));
      }
    }
    if (!compressed) continue;
    // Force times displacement: of K_b negative for some force, across the fiber, of what replaces it for none.
    double work_of_k = 0.0, work = 0.0;
    std::vector<double> b(24, 0.0);
    for (int node = 1; node < 4; ++node) b[6 * static_cast<std::size_t>(node) + 1] = node;
    for (const bool batched : {false, true}) {
      std::vector<double> u = b;
      (batched ? many : one).solve(f, u.data(), 1);
      double& sum = batched ? work : work_of_k;
      for (std::size_t i = 0; i < u.size(); ++i) sum += b[i] * u[i];
    }
    EXPECT_LT(work_of_k, 0.0);
    EXPECT_GT(work, 0.0);
    for (std::size_t k = 6; k < 24; ++k) {
      std::vector<double> unit(24, 0.0);
      unit[k] = 1.0;
      many.solve(f, unit.data(), 1);
      EXPECT_GT(unit[k], 0.0) << k;
    }
  }
}

TEST(FiberBatch, CompliancesAreThoseOfEachFiber) {
  Scene scene;
  BeamTimeParameters time;
  time.rho_inf = 0.7;
  BeamField field(scene.mesh, scene.groups, time, {0.1, -0.2, 0.3});
  field.initialize({});
  field.begin_step(0.05, 0.05);
  std::vector<double> delta(6 * static_cast<std::size_t>(scene.mesh.nodes()));
  for (double& value : delta) value = 0.02 * scene.random();
  field.increment(delta);
  field.evaluate();
  EXPECT_FALSE(field.is_linearized());
  const std::vector<double> residual = field.residual();
  field.linearize();
  EXPECT_TRUE(field.is_linearized());
  expect_equal(field.residual().data(), residual.data(), residual.size(), 1e-13, "residual alone");
  std::vector<std::vector<double>> d(scene.mesh.fibers());
  std::vector<const double*> d_of;
  std::vector<Index> rows;
  for (Index f = 0; f < scene.mesh.fibers(); ++f) {
    const Index functions = 2 * (scene.mesh.first_node[f + 1] - scene.mesh.first_node[f]);
    rows.push_back(f % 7);  // none, or several on the same functions
    d[f].assign(static_cast<std::size_t>(rows[f] * functions), 0.0);
    for (Index r = 0; r < rows[f]; ++r)
      for (Index i = 0; i < functions; ++i)
        if (r == 0 || std::abs(r - i / 2) <= 1) d[f][static_cast<std::size_t>(r * functions + i)] = scene.random();
    d_of.push_back(d[f].data());
  }
  std::vector<int> taken(scene.mesh.fibers(), 0);
  field.compliances(d_of, rows, [&](Index f, const RowMatrix& block) {
    ++taken[f];
    RowMatrix expected;
    field.compliance(f, d_of[f], rows[f], expected);
    ASSERT_EQ(block.rows(), 3 * rows[f]);
    expect_equal(expected.data(), block.data(), static_cast<std::size_t>(expected.size()), 1e-11, "compliance");
  });
  for (const int count : taken) EXPECT_EQ(count, 1);
}

}  // namespace
}  // namespace fbi::beam
