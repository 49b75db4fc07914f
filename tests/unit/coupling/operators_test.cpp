// Every multiplier basis, operator and integration: identities, linear fields, the same on any number of ranks; and the
// law that keeps a fiber's own radius.
#include <gtest/gtest.h>

#include <numbers>

#include "base/error.hpp"
#include "base/log.hpp"
#include "coupling/multiplier.hpp"
#include "coupling/ring.hpp"
#include "scene.hpp"

namespace fbi::test {
namespace {

using coupling::Coupling;
using coupling::CouplingParameters;
using coupling::Integration;
using coupling::Multiplier;
using coupling::Operator;

constexpr Multiplier bases[] = {Multiplier::linear, Multiplier::quadratic, Multiplier::cubic, Multiplier::gauss_point};

CouplingParameters parameters_of(Multiplier multiplier, Operator kernel, Integration integration,
                                 bool automatic = false) {
  CouplingParameters parameters;
  parameters.multiplier = multiplier;
  parameters.kernel = kernel;
  parameters.integration = integration;
  parameters.automatic = automatic;
  parameters.viscosity = 0.7;
  parameters.radius = {0.01};
  parameters.gauss_points = 4;
  return parameters;
}

/// Field that follows from the file number of a node alone.
std::vector<double> rough_field(const mesh::HexMesh& mesh) {
  std::vector<double> field(4 * static_cast<std::size_t>(mesh.local_nodes()));
  for (Index n = 0; n < mesh.local_nodes(); ++n)
    for (int i = 0; i < 3; ++i) field[4 * n + i] = std::sin(1.7 * static_cast<double>(mesh.node_id[n]) + i);
  return field;
}

/// sum over all rows of |M v|^2, |kappa|^2 and the trace of S squared: they do not depend on the order of rows.
std::array<double, 3> fingerprint(const Scene& scene, Coupling& coupling) {
  coupling.update(waved(scene.fibers, 0.03));
  if (coupling.needs_stabilization())
    coupling.set_stabilization(
        std::vector<coupling::CellViscosity>(scene.fluid.local_cells(), coupling::CellViscosity{1.0 / 12, 0.3}));
  std::vector<double> values(3 * static_cast<std::size_t>(coupling.rows()));
  coupling.interpolate(rough_field(scene.fluid).data(), values.data());
  std::array<double, 3> sums{};
  for (const double value : values) sums[0] += value * value;
  for (const double value : coupling.kappa()) sums[1] += value * value;
  for (const coupling::Symmetric& s : coupling.interface_rows()) sums[2] += (s[0] + s[3] + s[5]) * (s[0] + s[3] + s[5]);
  scene.comm.sum(sums.data(), 3);
  return sums;
}

void check(const mesh::HexMeshData& mesh, const CouplingParameters& parameters) {
  const mesh::FiberMeshData fibers = random_lines(12, 0.25, 0.75, 3, 9);
  const Scene scene(mesh, fibers), alone(mesh, fibers, MPI_COMM_SELF);
  Coupling coupling(scene.fluid, scene.fibers, parameters), serial(alone.fluid, alone.fibers, parameters);
  const std::array<double, 3> some = fingerprint(scene, coupling), all = fingerprint(alone, serial);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(some[k], all[k], 1e-12 * all[k]);
  EXPECT_GT(all[0], 0.0);
  EXPECT_GT(all[2], 0.0);
  EXPECT_EQ(coupling.global_rows(), serial.global_rows());
  EXPECT_LT(coupling.coverage().identity_error, 1e-13);
  EXPECT_LT(linear_field_error(scene, coupling, waved(scene.fibers, 0.03)), 1e-14);
  double kappa = 0.0;
  for (const double value : coupling.kappa()) kappa += value;
  EXPECT_NEAR(scene.comm.sum(kappa), reference_length(scene), 1e-12);
}

TEST(Operators, EveryOneOnBoxAndGeneralMeshes) {
  for (const Multiplier multiplier : bases)
    for (const Operator kernel : {Operator::centerline, Operator::ring})
      for (const Integration integration : {Integration::segments, Integration::element}) {
        SCOPED_TRACE(testing::Message() << "multiplier " << static_cast<int>(multiplier) << " operator "
                                        << static_cast<int>(kernel) << " integration "
                                        << static_cast<int>(integration));
        check(cube(5), parameters_of(multiplier, kernel, integration));
        check(perturbed(cube(5), 0.03, 5), parameters_of(multiplier, kernel, integration));
        if (kernel == Operator::ring) check(cube(5), parameters_of(multiplier, kernel, integration, true));
      }
}

TEST(Operators, RowsOfEveryBasis) {
  mesh::FiberMeshData fibers;
  add_line(fibers, Vec3(0.11, 0.5, 0.5), Vec3(0.91, 0.5, 0.5), 3);
  const Scene scene(cube(5), fibers);
  const std::vector<double> dofs = moved(scene.fibers, Vec3::Zero());
  for (const Multiplier multiplier : bases) {
    Coupling coupling(scene.fluid, scene.fibers,
                      parameters_of(multiplier, Operator::centerline, Integration::segments));
    coupling.update(dofs);
    const GlobalIndex expected = multiplier == Multiplier::linear      ? 4
                                 : multiplier == Multiplier::quadratic ? 7
                                 : multiplier == Multiplier::cubic     ? 10
                                                                       : 4 * coupling.coverage().segments;
    EXPECT_EQ(coupling.global_rows(), expected);
    EXPECT_EQ(coupling.has_fixed_rows(), multiplier != Multiplier::gauss_point);
  }
}

TEST(Operators, BasesAreAPartitionOfUnityAndInterpolate) {
  for (const Multiplier multiplier : {Multiplier::linear, Multiplier::quadratic, Multiplier::cubic}) {
    const coupling::Basis basis(multiplier);
    for (const double x : {-1.0, -0.7, 0.1, 0.66, 1.0}) {
      const coupling::BasisValues phi = basis.at(x, 0);
      double sum = 0.0, power = 0.0;
      for (int p = 0; p < phi.count; ++p) {
        sum += phi.value[p];
        power += phi.value[p] * std::pow(2.0 * p / basis.order() - 1.0, basis.order());
      }
      EXPECT_NEAR(sum, 1.0, 1e-15);
      EXPECT_NEAR(power, std::pow(x, basis.order()), 1e-15);
    }
  }
}

/// The multiplier field that is linear in space is found at the nodes, for every basis.
TEST(Operators, ValuesAtTheNodes) {
  const Scene scene(cube(5), random_lines(6, 0.2, 0.8, 3, 2));
  for (const Multiplier multiplier : bases) {
    Coupling coupling(scene.fluid, scene.fibers,
                      parameters_of(multiplier, Operator::centerline, Integration::segments));
    coupling.update(moved(scene.fibers, Vec3::Zero()));
    const std::vector<double> ones(3 * static_cast<std::size_t>(coupling.rows()), 2.5);
    for (const double value : coupling.at_nodes(ones)) EXPECT_NEAR(value, 2.5, 1e-14);
  }
}

/// Fibers at the wall, whose rings are cut off by it: what is left still has mean one.
TEST(Operators, RingsThatLeaveTheFluid) {
  mesh::FiberMeshData fibers;
  add_line(fibers, Vec3(0.5, 0.0, 0.5), Vec3(0.5, 0.6, 0.5), 2);  // its foot stands on the wall
  add_line(fibers, Vec3(0.2, 0.0, 0.2), Vec3(0.8, 0.0, 0.3), 2);  // lies on the wall
  for (const bool general : {false, true}) {
    const Scene scene(cube(5, general), fibers);
    Coupling coupling(scene.fluid, scene.fibers,
                      parameters_of(Multiplier::linear, Operator::ring, Integration::segments));
    coupling.update(moved(scene.fibers, Vec3::Zero()));
    EXPECT_LT(coupling.coverage().identity_error, 1e-14);
  }
}

/// A ring around a fiber on a periodic face reads the other side.
TEST(Operators, RingsWrapAtPeriodicFaces) {
  mesh::FiberMeshData fibers;
  add_line(fibers, Vec3(0.5, 0.2, 0.0), Vec3(0.5, 0.8, 0.0), 2);
  for (const bool general : {false, true}) {
    const Scene scene(cube(5, general), fibers);
    CouplingParameters parameters = parameters_of(Multiplier::linear, Operator::ring, Integration::segments);
    parameters.periods = {Vec3(0, 0, 1)};
    Coupling coupling(scene.fluid, scene.fibers, parameters);
    coupling.update(moved(scene.fibers, Vec3::Zero()));
    EXPECT_LT(coupling.coverage().identity_error, 1e-14);
    // v_x = 1 in the upper half: half of every ring is there.
    std::vector<double> field(4 * static_cast<std::size_t>(scene.fluid.local_nodes()), 0.0);
    for (Index n = 0; n < scene.fluid.local_nodes(); ++n) field[4 * n] = scene.fluid.node(n)[2] > 0.5 ? 1.0 : 0.0;
    std::vector<double> values(3 * static_cast<std::size_t>(coupling.rows()));
    coupling.interpolate(field.data(), values.data());
    double sum = 0.0;
    for (Index p = 0; p < coupling.rows(); ++p) sum += values[3 * static_cast<std::size_t>(p)];
    EXPECT_NEAR(scene.comm.sum(sum), 0.3, 1e-14);
  }
}

/// Fibers that are all outside may enter later, but multipliers of higher order need some fluid to begin with.
TEST(Operators, NothingInTheFluidAtTheStart) {
  mesh::FiberMeshData fibers;
  add_line(fibers, Vec3(0.5, 1.2, 0.5), Vec3(0.5, 1.7, 0.5), 3);
  const Scene scene(cube(4), fibers);
  for (const Multiplier multiplier : bases) {
    CouplingParameters parameters = parameters_of(multiplier, Operator::centerline, Integration::segments);
    parameters.outside = coupling::Outside::allow;
    Coupling coupling(scene.fluid, scene.fibers, parameters);
    if (multiplier == Multiplier::quadratic || multiplier == Multiplier::cubic) {
      EXPECT_THROW(coupling.update(moved(scene.fibers, Vec3::Zero())), Error);
      continue;
    }
    coupling.update(moved(scene.fibers, Vec3::Zero()));
    EXPECT_EQ(coupling.coverage().covered, 0.0);
    coupling.update(moved(scene.fibers, Vec3(0, -1, 0)));
    EXPECT_NEAR(coupling.coverage().covered, 0.5, 1e-14);
    EXPECT_LT(coupling.coverage().identity_error, 1e-14);
  }
}

TEST(Ring, StandsNormalToTheFiber) {
  for (const Vec3& t : {Vec3(0, 0, 1), Vec3(1, 2, 3), Vec3(1, 1, 1), Vec3(-0.2, 0.9, 0.1)}) {
    const Vec3 tangent = t.normalized();
    const coupling::Ring ring = coupling::make_ring(0.3, 0.1, tangent);
    EXPECT_EQ(ring.radius, 0.3);
    EXPECT_EQ(ring.points, 38);  // ceil(12 pi)
    Vec3 mean = Vec3::Zero();
    Mat3 second = Mat3::Zero();
    for (Index q = 0; q < ring.points; ++q) {
      const Vec3 offset = ring.offset(q);
      EXPECT_NEAR(offset.norm(), 0.3, 1e-15);
      EXPECT_NEAR(offset.dot(tangent), 0.0, 1e-16);
      mean += offset / ring.points;
      second += offset * offset.transpose() / ring.points;
    }
    EXPECT_LT(mean.norm(), 1e-15);
    EXPECT_LT((second - 0.045 * (Mat3::Identity() - tangent * tangent.transpose())).norm(), 1e-15);
  }
  EXPECT_EQ(coupling::make_ring(0.001, 0.1, Vec3::UnitZ()).radius, 0.05);
  EXPECT_EQ(coupling::make_ring(0.001, 0.1, Vec3::UnitZ()).points, 8);
}

/// What is in series with the resistance of the ring is the logarithm between the two radii.
TEST(Ring, LawBridgesTheRadii) {
  const double a = 0.01, h = 0.1, mu = 0.7, pi = std::numbers::pi;
  const coupling::Compliance law = coupling::own_radius_law(a, 0.05, h, mu, {1.0 / 12, 0.0});
  const double b = 0.175 - 0.32 / 12 / std::sqrt(1.0 / 12 + 0.03);
  EXPECT_NEAR(4 * pi * mu * law.across, std::log((0.05 + b * h) / a), 1e-14);
  EXPECT_NEAR(2 * pi * mu * law.along, std::log((0.05 + (0.15 + 0.015 * 2) * h) / a), 1e-14);
  const coupling::Compliance divergence = coupling::own_radius_law(a, 0.05, h, mu, {1.0 / 12, 5.0});
  EXPECT_NEAR(4 * pi * mu * divergence.across, std::log((0.05 + (b + 0.02) * h) / a), 1e-14);
  // A radius beyond that of the ring: no compliance below zero.
  EXPECT_EQ(coupling::own_radius_law(1.0, 0.05, h, mu, {1.0 / 12, 0.0}).across, 1e-6 / mu);
}

/// S of a fiber across the axes: compliance along its tangent and normal to it.
TEST(Operators, LawFollowsTheTangent) {
  mesh::FiberMeshData fibers;
  const Vec3 from(0.2, 0.3, 0.4), to(0.7, 0.8, 0.6);
  add_line(fibers, from, to, 1);
  const Scene scene(cube(4), fibers);
  Coupling coupling(scene.fluid, scene.fibers,
                    parameters_of(Multiplier::linear, Operator::ring, Integration::segments, true));
  coupling.update(moved(scene.fibers, Vec3::Zero()));
  coupling.set_stabilization(
      std::vector<coupling::CellViscosity>(scene.fluid.local_cells(), coupling::CellViscosity{1.0 / 12, 0.0}));
  double sums[6] = {};
  for (const coupling::Symmetric& s : coupling.interface_rows())
    for (int k = 0; k < 6; ++k) sums[k] += s[k];
  scene.comm.sum(sums, 6);
  Mat3 s;
  s << sums[0], sums[1], sums[2], sums[1], sums[3], sums[4], sums[2], sums[4], sums[5];
  const Vec3 t = (to - from).normalized();
  const Mat3 normal = Mat3::Identity() - t * t.transpose();
  double h = 0.0;  // largest edge normal to the fiber
  for (int k = 0; k < 3; ++k) h = std::max(h, 0.25 * (normal * Vec3::Unit(k)).norm());
  const coupling::Compliance law = coupling::own_radius_law(0.01, 0.5 * h, h, 0.7, {1.0 / 12, 0.0});
  const double length = (to - from).norm();
  EXPECT_LT((s - length * (law.across * normal + law.along * t * t.transpose())).norm(), 1e-14);
}

}  // namespace
}  // namespace fbi::test
