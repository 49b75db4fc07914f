// Identities of the coupling operators on any number of ranks, and the same operators as on one rank.
#include <gtest/gtest.h>

#include "base/counters.hpp"
#include "base/error.hpp"
#include "fem/hex8.hpp"
#include "scene.hpp"

namespace fbi::test {
namespace {

using coupling::Coupling;
using coupling::CouplingParameters;

/// Dense M of the whole scene by (file id of the fiber, its node, file id of the fluid node), summed over ranks: small
/// scenes.
std::vector<double> dense_m(const Scene& scene, const Coupling& coupling, GlobalIndex total_rows) {
  const Comm& comm = scene.comm;
  std::vector<double> file_row(coupling.global_rows(), 0.0);  // global row -> row in file order
  for (Index f = 0; f < scene.fibers.fibers(); ++f)
    for (Index n = scene.fibers.first_node[f]; n < scene.fibers.first_node[f + 1]; ++n)
      file_row[coupling.first_row() + n] =
          static_cast<double>(scene.fibers.first_node_id[f] + n - scene.fibers.first_node[f]);
  comm.sum(file_row.data(), static_cast<int>(file_row.size()));
  std::vector<double> dense(total_rows * scene.fluid.global_nodes, 0.0);
  const coupling::LocalM& m = coupling.local_m();
  for (std::size_t i = 0; i < m.row.size(); ++i)
    for (Index k = m.begin[i]; k < m.begin[i + 1]; ++k)
      dense[static_cast<GlobalIndex>(file_row[m.row[i]]) * scene.fluid.global_nodes + scene.fluid.node_id[m.node[k]]] +=
          m.value[k];
  comm.sum(dense.data(), static_cast<int>(dense.size()));
  return dense;
}

/// Coverage, identities and the linear field at `dofs`.
void expect_exact(const Scene& scene, Coupling& coupling, const std::vector<double>& dofs) {
  coupling.update(dofs);
  const double length = reference_length(scene);
  EXPECT_NEAR(coupling.coverage().covered, length, 1e-13 * length);
  EXPECT_EQ(coupling.coverage().fibers_outside, 0);
  EXPECT_LT(coupling.coverage().identity_error, 1e-14);
  EXPECT_LT(linear_field_error(scene, coupling, dofs), 1e-14);
  double kappa = 0.0;
  for (const double value : coupling.kappa()) kappa += value;
  EXPECT_NEAR(scene.comm.sum(kappa), length, 1e-13 * length);
}

/// The same M as a single rank gives.
void expect_as_serial(const mesh::HexMeshData& mesh, const mesh::FiberMeshData& fibers, double wave) {
  const Scene scene(mesh, fibers), alone(mesh, fibers, MPI_COMM_SELF);
  Coupling coupling(scene.fluid, scene.fibers, CouplingParameters()),
      serial(alone.fluid, alone.fibers, CouplingParameters());
  coupling.update(waved(scene.fibers, wave));
  serial.update(waved(alone.fibers, wave));
  const GlobalIndex rows = fibers.first_node.back();
  const std::vector<double> m = dense_m(scene, coupling, rows), expected = dense_m(alone, serial, rows);
  double largest = 0.0, difference = 0.0;
  for (std::size_t i = 0; i < m.size(); ++i) {
    largest = std::max(largest, std::abs(expected[i]));
    difference = std::max(difference, std::abs(m[i] - expected[i]));
  }
  EXPECT_LT(difference, 1e-13 * largest);
  EXPECT_EQ(coupling.coverage().segments, serial.coverage().segments);
}

TEST(Coupling, IdentitiesInBox) {
  for (const bool general : {false, true}) {
    const Scene scene(cube(6, general), random_lines(40, 0.1, 0.9, 4, 1));
    Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
    expect_exact(scene, coupling, moved(scene.fibers, Vec3::Zero()));
    expect_exact(scene, coupling, waved(scene.fibers, 0.05));
  }
}

TEST(Coupling, ManyRandomFibersInPerturbedMesh) {
  const mesh::HexMeshData mesh = perturbed(cube(8), 0.025, 3);
  const Scene scene(mesh, random_lines(1200, 0.06, 0.94, 3, 4));
  Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
  expect_exact(scene, coupling, moved(scene.fibers, Vec3::Zero()));
  expect_exact(scene, coupling, waved(scene.fibers, 0.05));
}

TEST(Coupling, SameAsOnOneRank) {
  expect_as_serial(cube(5), random_lines(30, 0.1, 0.9, 3, 5), 0.05);
  expect_as_serial(cube(5, true), random_lines(30, 0.1, 0.9, 3, 6), 0.05);
  expect_as_serial(perturbed(cube(5), 0.04, 7), random_lines(30, 0.1, 0.9, 3, 8), 0.05);
}

/// Along faces, edges, through nodes, in the domain boundary, along its edges: every rank boundary of 2, 3, 4 ranks is
/// among them.
mesh::FiberMeshData special_lines() {
  mesh::FiberMeshData fibers;
  for (const double y : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    add_line(fibers, Vec3(0.05, y, 0.3), Vec3(0.95, y, 0.6), 3);  // in faces
    add_line(fibers, Vec3(0.0, y, 0.5), Vec3(1.0, y, 0.5), 4);    // along edges, nodes on nodes
    add_line(fibers, Vec3(y, 0.0, 0.25), Vec3(y, 1.0, 0.25), 3);
    add_line(fibers, Vec3(0.25, 0.5, 0.1), Vec3(0.25, 0.5, 0.9), 2);
    add_line(fibers, Vec3(y, 0.1, 0.0), Vec3(y, 0.9, 0.0), 2);
    add_line(fibers, Vec3(0.1, 0.3, y), Vec3(0.8, 0.9, y), 2);
  }
  add_line(fibers, Vec3(0, 0, 0), Vec3(1, 1, 1), 3);  // through nodes
  add_line(fibers, Vec3(0, 0, 1), Vec3(1, 1, 1), 1);
  add_line(fibers, Vec3(1, 0, 0), Vec3(0, 1, 1), 4);
  return fibers;
}

TEST(Coupling, BoxAndGeneralMeshAgree) {
  for (const bool special : {false, true}) {
    const mesh::FiberMeshData fibers = special ? special_lines() : random_lines(20, 0.1, 0.9, 3, 2);
    const Scene box(cube(4), fibers), general(cube(4, true), fibers);
    ASSERT_TRUE(box.fluid.box.has_value());
    ASSERT_FALSE(general.fluid.box.has_value());
    Coupling a(box.fluid, box.fibers, CouplingParameters()), b(general.fluid, general.fibers, CouplingParameters());
    a.update(special ? moved(box.fibers, Vec3::Zero()) : waved(box.fibers, 0.05));
    b.update(special ? moved(general.fibers, Vec3::Zero()) : waved(general.fibers, 0.05));
    EXPECT_EQ(a.coverage().segments, b.coverage().segments);
    const std::vector<double> ma = dense_m(box, a, fibers.first_node.back());
    const std::vector<double> mb = dense_m(general, b, fibers.first_node.back());
    for (std::size_t i = 0; i < ma.size(); ++i) ASSERT_NEAR(ma[i], mb[i], 1e-15);
  }
}

TEST(Coupling, FibersOnFacesEdgesNodesAndBoundaries) {
  for (const bool general : {false, true}) {
    const Scene scene(cube(4, general), special_lines());
    Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
    expect_exact(scene, coupling, moved(scene.fibers, Vec3::Zero()));
    expect_as_serial(cube(4, general), special_lines(), 0.0);
  }
}

TEST(Coupling, FibersInPlanarFacesOfShearedMesh) {
  // x -> x + 0.3 y + 0.2 z, z -> z + 0.1 x: general cells with planar faces, the lines move along.
  const auto shear = [](double* x) {
    const double y[3] = {x[0] + 0.3 * x[1] + 0.2 * x[2], x[1], x[2] + 0.1 * x[0]};
    std::copy(y, y + 3, x);
  };
  mesh::HexMeshData mesh = cube(4, true);
  for (std::size_t n = 0; n < mesh.nodes.size(); n += 3) shear(&mesh.nodes[n]);
  const mesh::FiberMeshData straight = special_lines();
  mesh::FiberMeshData fibers;
  for (std::size_t f = 0; f < straight.name.size(); ++f) {
    Vec3 ends[2];
    const GlobalIndex first = straight.first_node[f], last = straight.first_node[f + 1] - 1;
    ends[0] = Eigen::Map<const Vec3>(&straight.position[3 * first]);
    ends[1] = Eigen::Map<const Vec3>(&straight.position[3 * last]);
    for (Vec3& end : ends) shear(end.data());
    add_line(fibers, ends[0], ends[1], static_cast<int>(last - first));
  }
  const Scene scene(mesh, fibers);
  Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
  expect_exact(scene, coupling, moved(scene.fibers, Vec3::Zero()));
  expect_as_serial(mesh, fibers, 0.0);
}

TEST(Coupling, FiberMovesAcrossRankBoundary) {
  for (const bool general : {false, true}) {
    mesh::FiberMeshData fibers;
    add_line(fibers, Vec3(0.2, 0.3, 0.1), Vec3(0.2, 0.3, 0.6), 3);
    add_line(fibers, Vec3(0.3, 0.2, 0.15), Vec3(0.35, 0.2, 0.5), 2);
    const Scene scene(cube(4, general), fibers), alone(cube(4, general), fibers, MPI_COMM_SELF);
    Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
    for (int step = 0; step <= 12; ++step) {
      const std::vector<double> dofs = moved(scene.fibers, Vec3(0.05, 0.05, 0.03) * step);
      expect_exact(scene, coupling, dofs);
      Coupling serial(alone.fluid, alone.fibers, CouplingParameters());
      serial.update(moved(alone.fibers, Vec3(0.05, 0.05, 0.03) * step));
      const std::vector<double> m = dense_m(scene, coupling, 7), expected = dense_m(alone, serial, 7);
      for (std::size_t i = 0; i < m.size(); ++i) ASSERT_NEAR(m[i], expected[i], 1e-15);
    }
  }
}

/// Straight lines on mesh edges and across warped faces, tilted and shifted by `offset` [length] at random.
mesh::FiberMeshData grazing_lines(const mesh::HexMeshData& mesh, int count, double offset, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0), sign(-1.0, 1.0);
  const auto node = [&](GlobalIndex cell, int a) {
    return Vec3(Eigen::Map<const Vec3>(&mesh.nodes[3 * mesh.cells[8 * cell + a]]));
  };
  const auto inner = [](const Vec3& x) { return x.minCoeff() > 0.01 && x.maxCoeff() < 0.99; };
  mesh::FiberMeshData fibers;
  fibers.first_node.push_back(0);
  while (static_cast<int>(fibers.name.size()) < count) {
    const GlobalIndex cell = static_cast<GlobalIndex>(unit(random) * mesh.cell_count());
    const std::array<int, 4>& face = fem::hex8_faces[static_cast<int>(6 * unit(random))];
    const bool edge = unit(random) < 0.3;
    const double s = edge ? 0.0 : unit(random);
    Vec3 from = (1 - s) * node(cell, face[0]) + s * node(cell, face[1]);
    Vec3 to = (1 - s) * node(cell, face[3]) + s * node(cell, face[2]);
    for (int i = 0; i < 3; ++i) {
      from[i] += offset * sign(random);
      to[i] += offset * sign(random);
    }
    if (inner(from) && inner(to)) add_line(fibers, from, to, 1 + static_cast<int>(3 * unit(random)));
  }
  return fibers;
}

TEST(Coupling, FibersInAndNearWarpedFacesAndEdges) {
  const mesh::HexMeshData mesh = perturbed(cube(6), 0.03, 31);
  for (int power = 0; power <= 14; ++power) {
    const Scene scene(mesh, grazing_lines(mesh, 150, power == 0 ? 0.0 : std::pow(10.0, -2 - power), 32 + power));
    Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
    SCOPED_TRACE(power);
    expect_exact(scene, coupling, moved(scene.fibers, Vec3::Zero()));
  }
  expect_as_serial(mesh, grazing_lines(mesh, 40, 0.0, 33), 0.0);
  expect_as_serial(mesh, grazing_lines(mesh, 40, 1e-7, 34), 0.0);
}

TEST(Coupling, FarFromTheOrigin) {
  mesh::HexMeshData mesh = perturbed(cube(5), 0.03, 41);
  mesh::FiberMeshData fibers = random_lines(60, 0.1, 0.9, 3, 42);
  for (double& x : mesh.nodes) x = 100.0 + 0.1 * x;
  for (double& x : fibers.position) x = 100.0 + 0.1 * x;
  for (double& length : fibers.element_length) length *= 0.1;
  const Scene scene(mesh, fibers);
  Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
  coupling.update(moved(scene.fibers, Vec3::Zero()));
  EXPECT_EQ(coupling.coverage().outside, 0.0);
  // Positions near 100 are rounded to 1.4e-14, and so is each of the 180 element lengths.
  EXPECT_NEAR(coupling.coverage().covered, reference_length(scene), 180 * 1.5e-14);
  EXPECT_LT(coupling.coverage().identity_error, 1e-14);
}

TEST(Coupling, SameDofsGiveBitwiseSameOperators) {
  for (const double amount : {0.0, 0.03}) {
    const mesh::HexMeshData mesh = amount > 0 ? perturbed(cube(5), amount, 9) : cube(5);
    const Scene scene(mesh, random_lines(25, 0.15, 0.85, 3, 10));
    Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
    coupling.update(waved(scene.fibers, 0.04));
    const coupling::LocalM first = coupling.local_m();
    const std::vector<double> kappa = coupling.kappa();
    coupling.update(moved(scene.fibers, Vec3(0.1, -0.1, 0.05)));
    coupling.update(waved(scene.fibers, 0.04));
    EXPECT_EQ(first.row, coupling.local_m().row);
    EXPECT_EQ(first.begin, coupling.local_m().begin);
    EXPECT_EQ(first.node, coupling.local_m().node);
    EXPECT_EQ(first.value, coupling.local_m().value);
    EXPECT_EQ(kappa, coupling.kappa());
  }
}

TEST(Coupling, MomentumIsHandedOverWhole) {
  const Scene scene(perturbed(cube(5), 0.03, 11), random_lines(30, 0.1, 0.9, 3, 12));
  Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
  coupling.update(waved(scene.fibers, 0.05));
  std::vector<double> lambda(3 * coupling.rows()), on_fiber(6 * static_cast<std::size_t>(scene.fibers.nodes()), 0.0);
  for (std::size_t i = 0; i < lambda.size(); ++i) lambda[i] = std::sin(1.0 + 0.37 * (3.0 * coupling.first_row() + i));
  std::vector<double> on_fluid(4 * static_cast<std::size_t>(scene.fluid.local_nodes()), 0.0);
  coupling.spread(lambda.data(), on_fluid.data(), -2.0);
  coupling.add_d_transposed(lambda.data(), on_fiber, 2.0);
  double sums[9] = {};
  for (Index n = 0; n < scene.fluid.local_nodes(); ++n) {
    for (int i = 0; i < 3; ++i) sums[i] += on_fluid[4 * n + i];
    EXPECT_EQ(on_fluid[4 * n + 3], 0.0);
  }
  for (Index n = 0; n < scene.fibers.nodes(); ++n)
    for (int i = 0; i < 3; ++i) sums[3 + i] += on_fiber[6 * n + i];
  for (Index p = 0; p < coupling.rows(); ++p)
    for (int i = 0; i < 3; ++i) sums[6 + i] += 2.0 * lambda[3 * p + i] * coupling.kappa()[p];
  scene.comm.sum(sums, 9);
  for (int i = 0; i < 3; ++i) {
    EXPECT_GT(std::abs(sums[6 + i]), 1e-3);
    EXPECT_NEAR(sums[i], -sums[6 + i], 1e-13);
    EXPECT_NEAR(sums[3 + i], sums[6 + i], 1e-13);
  }
}

TEST(Coupling, SpreadIsTransposeOfInterpolate) {
  const Scene scene(perturbed(cube(4), 0.03, 13), random_lines(10, 0.1, 0.9, 2, 14));
  Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
  coupling.update(waved(scene.fibers, 0.05));
  std::vector<double> lambda(3 * coupling.rows()), velocity(4 * static_cast<std::size_t>(scene.fluid.local_nodes()));
  for (std::size_t i = 0; i < lambda.size(); ++i) lambda[i] = std::cos(0.7 * (3.0 * coupling.first_row() + i));
  for (Index n = 0; n < scene.fluid.local_nodes(); ++n)
    for (int i = 0; i < 4; ++i) velocity[4 * n + i] = std::sin(1.3 * scene.fluid.node_id[n] + i);
  std::vector<double> mv(lambda.size()), mt_lambda(velocity.size(), 0.0);
  coupling.interpolate(velocity.data(), mv.data());
  coupling.spread(lambda.data(), mt_lambda.data(), 1.0);
  double sums[2] = {};
  for (std::size_t i = 0; i < lambda.size(); ++i) sums[0] += lambda[i] * mv[i];
  for (std::size_t i = 0; i < velocity.size(); ++i) sums[1] += velocity[i] * mt_lambda[i];
  scene.comm.sum(sums, 2);
  EXPECT_GT(std::abs(sums[0]), 1e-3);
  EXPECT_NEAR(sums[0], sums[1], 1e-14);
}

TEST(Coupling, AddDTransposedIsTransposeOfApplyD) {
  const Scene scene(cube(4), random_lines(10, 0.1, 0.9, 3, 16));
  Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
  coupling.update(waved(scene.fibers, 0.05));
  std::vector<double> q(6 * static_cast<std::size_t>(scene.fibers.nodes())), force(q.size(), 0.5);
  std::vector<double> lambda(3 * coupling.rows()), dq(lambda.size());
  double sums[2] = {};
  for (std::size_t i = 0; i < q.size(); ++i) q[i] = std::sin(0.9 * i + coupling.first_row());
  for (std::size_t i = 0; i < lambda.size(); ++i) lambda[i] = std::cos(0.7 * i + coupling.first_row());
  coupling.apply_d(q, dq.data());
  coupling.add_d_transposed(lambda.data(), force, 3.0);
  for (std::size_t i = 0; i < lambda.size(); ++i) sums[0] += 3.0 * lambda[i] * dq[i];
  for (std::size_t i = 0; i < q.size(); ++i) sums[1] += q[i] * (force[i] - 0.5);
  EXPECT_NEAR(sums[0], sums[1], 1e-13);
  EXPECT_TRUE(scene.comm.any(std::abs(sums[0]) > 1e-3));
}

TEST(Coupling, RankWithoutFibersAndRankWithoutTouchedCells) {
  mesh::FiberMeshData
      fibers;  // one fiber in one corner cell: on several ranks most have neither fibers nor touched cells
  add_line(fibers, Vec3(0.02, 0.03, 0.04), Vec3(0.1, 0.12, 0.09), 1);
  const Scene scene(cube(4), fibers);
  Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
  expect_exact(scene, coupling, moved(scene.fibers, Vec3::Zero()));
  // The fiber stays on its rank while its cells are at the other end of the mesh.
  expect_exact(scene, coupling, moved(scene.fibers, Vec3(0.8, 0.8, 0.8)));
  EXPECT_EQ(coupling.global_rows(), 2);
  EXPECT_EQ(scene.comm.sum(static_cast<GlobalIndex>(coupling.rows())), 2);
}

TEST(Coupling, TwoFibersInOneCell) {
  mesh::FiberMeshData fibers;
  add_line(fibers, Vec3(0.1, 0.2, 0.3), Vec3(0.4, 0.3, 0.2), 2);
  add_line(fibers, Vec3(0.4, 0.2, 0.3), Vec3(0.1, 0.3, 0.4), 1);
  const Scene scene(cube(2), fibers);
  Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
  expect_exact(scene, coupling, moved(scene.fibers, Vec3::Zero()));
  EXPECT_EQ(coupling.coverage().segments, 3);
  const GlobalIndex rows = scene.comm.sum(static_cast<GlobalIndex>(coupling.local_m().row.size()));
  EXPECT_EQ(rows, 5);
}

// Elements whose curve is what it was keep their segments; the operators are, bit by bit, those of a new search.
TEST(Coupling, ElementsThatDidNotMoveKeepTheirSegments) {
  for (const bool general : {false, true})
    for (const auto multiplier : {coupling::Multiplier::linear, coupling::Multiplier::gauss_point}) {
      const Scene scene(general ? perturbed(cube(6), 0.02, 3) : cube(6), random_lines(12, 0.1, 0.9, 3, 4));
      CouplingParameters parameters;
      parameters.multiplier = multiplier;
      Coupling coupling(scene.fluid, scene.fibers, parameters);
      coupling.update(moved(scene.fibers, Vec3::Zero()));
      std::vector<double> dofs = moved(scene.fibers, Vec3::Zero());
      const std::vector<double> away = waved(scene.fibers, 0.04);
      for (Index f = 0; f < scene.fibers.fibers(); ++f)  // every third fiber moves
        if (scene.fibers.fiber_id[f] % 3 == 0)
          for (Index k = 6 * scene.fibers.first_node[f]; k < 6 * scene.fibers.first_node[f + 1]; ++k) dofs[k] = away[k];
      reset_counters();
      coupling.update(dofs);
      EXPECT_EQ(scene.comm.sum(counted("elements cut")), 12);
      EXPECT_EQ(scene.comm.sum(counted("elements with old segments")), 24);
      Coupling anew(scene.fluid, scene.fibers, parameters);
      anew.update(dofs);
      EXPECT_EQ(coupling.kappa(), anew.kappa());
      EXPECT_EQ(coupling.local_m().row, anew.local_m().row);
      EXPECT_EQ(coupling.local_m().begin, anew.local_m().begin);
      EXPECT_EQ(coupling.local_m().node, anew.local_m().node);
      EXPECT_EQ(coupling.local_m().value, anew.local_m().value);
      for (Index f = 0; f < scene.fibers.fibers(); ++f) EXPECT_EQ(coupling.d_block(f), anew.d_block(f));
    }
}

TEST(Coupling, NoFibersAtAll) {
  mesh::FiberMeshData fibers;
  fibers.first_node.push_back(0);
  const Scene scene(cube(2), fibers);
  Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
  coupling.update({});
  EXPECT_EQ(coupling.global_rows(), 0);
  EXPECT_EQ(coupling.coverage().segments, 0);
}

TEST(Coupling, PositionThatIsNotANumberIsAnErrorOnAllRanks) {
  const Scene scene(cube(4), random_lines(8, 0.1, 0.9, 2, 15));
  Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
  std::vector<double> dofs = moved(scene.fibers, Vec3::Zero());
  if (!scene.fibers.fiber_id.empty() && scene.fibers.fiber_id[0] == 0) dofs[2] = std::nan("");
  EXPECT_THROW(coupling.update(dofs), Error);
}

}  // namespace
}  // namespace fbi::test
