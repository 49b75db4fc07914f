// Search and cutting under stress: ten thousand curved fibers in warped cells, fibers along edges and faces and through
// nodes, many in one cell, and fibers that cross, enter and leave parts and fluid while they move.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <complex>

#include "base/log.hpp"
#include "record.hpp"
#include "scene.hpp"

namespace fbi::test {
namespace {

using coupling::Coupling;
using coupling::CouplingParameters;
using coupling::Outside;

CouplingParameters allow_outside() {
  CouplingParameters parameters;
  parameters.outside = Outside::allow;
  return parameters;
}

/// Real parts of the roots of c_0 + c_1 x + c_2 x^2 + c_3 x^3 that are nearly real, from the companion matrix, made
/// exact by Newton's method; leading coefficients of round-off are dropped.
std::vector<double> roots_of(const std::array<double, 4>& c) {
  double largest = 0.0;
  for (const double value : c) largest = std::max(largest, std::abs(value));
  int degree = 3;
  while (degree > 0 && std::abs(c[degree]) <= 1e-14 * largest) --degree;
  Eigen::MatrixXd companion = Eigen::MatrixXd::Zero(degree, degree);
  for (int i = 0; i < degree; ++i) companion(i, degree - 1) = -c[i] / c[degree];
  for (int i = 0; i + 1 < degree; ++i) companion(i + 1, i) = 1.0;
  std::vector<double> roots;
  if (degree == 0) return roots;
  const Eigen::VectorXcd values = companion.eigenvalues();
  for (Eigen::Index k = 0; k < values.size(); ++k) {
    double x = values[k].real();
    if (!(std::abs(x) < 1.5) || std::abs(values[k].imag()) > 1e-3) continue;
    for (int iteration = 0; iteration < 8; ++iteration) {
      const double value = c[0] + x * (c[1] + x * (c[2] + x * c[3]));
      const double slope = c[1] + x * (2 * c[2] + x * 3 * c[3]);
      if (!(std::abs(slope) > 1e-9) || std::abs(value) > std::abs(slope)) break;
      x -= value / slope;
    }
    roots.push_back(x);
  }
  return roots;
}

/// Part of [-1, 1] on which a Hermite curve lies in the unit cube, by the roots of its components.
double share_inside(const double* a, const double* b, double length) {
  std::array<std::array<double, 4>, 3> c;  // by component, from values and slopes at the ends
  for (int i = 0; i < 3; ++i) {
    const double p = a[i], q = b[i], s = 0.5 * length * a[3 + i], t = 0.5 * length * b[3 + i];
    c[i] = {0.5 * (p + q) + 0.25 * (s - t), 0.75 * (q - p) - 0.25 * (s + t), 0.25 * (t - s),
            0.25 * (p - q) + 0.25 * (s + t)};
  }
  std::vector<double> cuts = {-1.0, 1.0};
  for (int i = 0; i < 3; ++i)
    for (const double level : {0.0, 1.0})
      for (const double x : roots_of({c[i][0] - level, c[i][1], c[i][2], c[i][3]}))
        if (x > -1.0 && x < 1.0) cuts.push_back(x);
  std::sort(cuts.begin(), cuts.end());
  double inside = 0.0;
  for (std::size_t k = 0; k + 1 < cuts.size(); ++k) {
    const double x = 0.5 * (cuts[k] + cuts[k + 1]);
    bool in = true;
    for (int i = 0; i < 3; ++i) {
      const double value = c[i][0] + x * (c[i][1] + x * (c[i][2] + x * c[i][3]));
      in = in && value >= 0.0 && value <= 1.0;
    }
    if (in) inside += cuts[k + 1] - cuts[k];
  }
  return 0.5 * inside;
}

/// Length of each fiber of this rank inside the unit cube; references are straight, so that lengths follow parameters.
std::vector<double> exact_lengths(const mesh::FiberMesh& fibers, const std::vector<double>& dofs) {
  std::vector<double> lengths;
  for (Index f = 0; f < fibers.fibers(); ++f) {
    double sum = 0.0;
    for (Index e = fibers.first_element(f); e < fibers.first_element(f + 1); ++e) {
      const double* node = &dofs[6 * static_cast<std::size_t>(e + f)];
      sum += fibers.element_length[e] * share_inside(node, node + 6, fibers.element_length[e]);
    }
    lengths.push_back(sum);
  }
  return lengths;
}

/// kappa of each fiber of this rank, added up: the length that its segments cover.
std::vector<double> covered_lengths(const mesh::FiberMesh& fibers, const Coupling& coupling) {
  std::vector<double> lengths;
  for (Index f = 0; f < fibers.fibers(); ++f) {
    double sum = 0.0;
    for (Index p = coupling.first_row_of(f); p < coupling.first_row_of(f + 1); ++p) sum += coupling.kappa()[p];
    lengths.push_back(sum);
  }
  return lengths;
}

/// Bends every fiber: nodes and tangents moved at random by numbers that belong to the node, not to its rank.
std::vector<double> tangled(const mesh::FiberMesh& fibers, double move, double turn) {
  std::vector<double> dofs = moved(fibers, Vec3::Zero());
  for (Index f = 0; f < fibers.fibers(); ++f)
    for (Index n = fibers.first_node[f]; n < fibers.first_node[f + 1]; ++n) {
      std::mt19937 random(static_cast<unsigned>(fibers.first_node_id[f] + n - fibers.first_node[f]) + 17U);
      std::uniform_real_distribution<double> number(-1.0, 1.0);
      for (int i = 0; i < 6; ++i) dofs[6 * static_cast<std::size_t>(n) + i] += (i < 3 ? move : turn) * number(random);
    }
  return dofs;
}

/// Largest difference of covered and exact lengths of a fiber, and of their sums. Collective.
struct LengthErrors {
  double fiber = 0.0, sum = 0.0, total = 0.0;
};
LengthErrors length_errors(const Scene& scene, const Coupling& coupling, const std::vector<double>& dofs) {
  const std::vector<double> found = covered_lengths(scene.fibers, coupling), exact = exact_lengths(scene.fibers, dofs);
  LengthErrors errors;
  double sum = 0.0;
  for (std::size_t f = 0; f < exact.size(); ++f) {
    errors.fiber = std::max(errors.fiber, std::abs(found[f] - exact[f]));
    sum += found[f] - exact[f];
    errors.total += exact[f];
  }
  errors.fiber = scene.comm.max(errors.fiber);
  errors.sum = std::abs(scene.comm.sum(sum));
  errors.total = scene.comm.sum(errors.total);
  return errors;
}

/// kappa and M v of a linear field, by file numbers of the fibers, in one array on every rank. Collective.
std::vector<double> by_fiber(const Scene& scene, const Coupling& coupling) {
  std::vector<double> nodal(4 * static_cast<std::size_t>(scene.fluid.local_nodes()));
  for (Index n = 0; n < scene.fluid.local_nodes(); ++n) {
    const Vec3 x = Eigen::Map<const Vec3>(scene.fluid.node(n));
    const double v[4] = {1 + x[0] * x[1] + x[2], x[1] - 2 * x[2] * x[0], x[0] + x[1] * x[2], 0.0};
    std::copy(v, v + 4, &nodal[4 * static_cast<std::size_t>(n)]);
  }
  std::vector<double> value(3 * static_cast<std::size_t>(coupling.rows()) + 3, 0.0);
  coupling.interpolate(nodal.data(), value.data());
  std::vector<double> all(4 * static_cast<std::size_t>(scene.fibers.global_fibers), 0.0);
  for (Index f = 0; f < scene.fibers.fibers(); ++f) {
    double* out = &all[4 * static_cast<std::size_t>(scene.fibers.fiber_id[f])];
    for (Index p = coupling.first_row_of(f); p < coupling.first_row_of(f + 1); ++p) {
      out[0] += coupling.kappa()[p];
      // weighted, so that values in wrong rows are seen
      for (int i = 0; i < 3; ++i)
        out[1 + i] += (1 + p - coupling.first_row_of(f)) * value[3 * static_cast<std::size_t>(p) + i];
    }
  }
  scene.comm.sum(all.data(), static_cast<int>(all.size()));
  return all;
}

/// Largest difference to the same on one rank. Collective.
double difference_to_one_rank(const mesh::HexMeshData& mesh, const mesh::FiberMeshData& fibers, const Scene& scene,
                              const Coupling& coupling,
                              const std::function<std::vector<double>(const mesh::FiberMesh&)>& positions) {
  if (scene.comm.size() == 1) return 0.0;
  std::vector<double> here = by_fiber(scene, coupling), alone(here.size(), 0.0);
  if (scene.comm.rank() == 0) {
    const Scene serial(mesh, fibers, MPI_COMM_SELF);
    Coupling one(serial.fluid, serial.fibers, allow_outside());
    one.update(positions(serial.fibers));
    alone = by_fiber(serial, one);
  }
  MPI_Bcast(alone.data(), static_cast<int>(alone.size()), MPI_DOUBLE, 0, scene.comm.get());
  double largest = 0.0;
  for (std::size_t k = 0; k < here.size(); ++k) largest = std::max(largest, std::abs(here[k] - alone[k]));
  return largest;
}

TEST(Stress, TenThousandCurvedFibersInWarpedCells) {
  const mesh::HexMeshData mesh = perturbed(cube(12), 0.02, 5);
  const mesh::FiberMeshData data = random_lines(10000, -0.15, 1.15, 2, 6);
  const Scene scene(mesh, data);
  Coupling coupling(scene.fluid, scene.fibers, allow_outside());
  const auto positions = [](const mesh::FiberMesh& fibers) { return tangled(fibers, 0.1, 0.7); };
  const std::vector<double> dofs = positions(scene.fibers);
  coupling.update(dofs);
  const LengthErrors errors = length_errors(scene, coupling, dofs);
  const double linear = linear_field_error(scene, coupling, dofs), all = reference_length(scene);
  const coupling::Coverage& coverage = coupling.coverage();
  const double ranks = difference_to_one_rank(mesh, data, scene, coupling, positions);
  if (scene.comm.rank() == 0)
    std::printf(
        "length of 1e4 fibers %.6f, inside %.6f in %lld segments: error %.1e, of one fiber %.1e, of a linear "
        "field %.1e, M.1 - kappa %.1e, to one rank %.1e\n",
        all, errors.total, static_cast<long long>(coverage.segments), errors.sum, errors.fiber, linear,
        coverage.identity_error, ranks);
  EXPECT_GT(errors.total, 0.5 * all);
  EXPECT_LT(errors.total, 0.95 * all);
  EXPECT_GT(coverage.fibers_outside, 1000);
  EXPECT_LE(errors.fiber, 1e-12);
  EXPECT_LE(errors.sum, 1e-12 * errors.total);
  EXPECT_NEAR(coverage.covered + coverage.outside, all, 1e-12 * all);
  EXPECT_LE(linear, 1e-12);
  EXPECT_LE(coverage.identity_error, 1e-13);
  EXPECT_LE(ranks, 1e-12);
  record({.section = "Coupling",
          .check = "1e4 curved fibers, partly outside, in 1728 warped cells: length inside, all of them",
          .source = "roots of the cubics",
          .reference = errors.total,
          .ours = coverage.covered,
          .error = errors.sum / errors.total,
          .bar = "1e-12"});
}

// Straight fibers from node to node: along edges of warped cells, along diagonals of their faces (which leave a
// bilinear face) and through cells.
TEST(Stress, AlongEdgesDiagonalsAndThroughNodesOfWarpedCells) {
  const int n = 6;
  double all_errors = 0.0;
  for (const double amount : {0.0, 0.02}) {
    const mesh::HexMeshData mesh = amount > 0 ? perturbed(cube(n), amount, 9) : cube(n, true);
    const auto id = [](int i, int j, int k) { return i + (n + 1) * (j + (n + 1) * k); };
    mesh::FiberMeshData data;
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i)
          for (const auto& [a, b, c] :
               {std::array{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, 1, 0}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}}) {
            const Vec3 from(&mesh.nodes[3 * static_cast<std::size_t>(id(i, j, k))]),
                to(&mesh.nodes[3 * static_cast<std::size_t>(id(i + a, j + b, k + c))]);
            add_line(data, from, to, 1);
          }
    const Scene scene(mesh, data);
    Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
    const auto positions = [](const mesh::FiberMesh& fibers) { return moved(fibers, Vec3::Zero()); };
    const std::vector<double> dofs = positions(scene.fibers);
    coupling.update(dofs);
    const coupling::Coverage& coverage = coupling.coverage();
    const double all = reference_length(scene), linear = linear_field_error(scene, coupling, dofs);
    const double ranks = difference_to_one_rank(mesh, data, scene, coupling, positions);
    const std::vector<double> covered = covered_lengths(scene.fibers, coupling);
    double error = 0.0;
    for (Index f = 0; f < scene.fibers.fibers(); ++f)
      error = std::max(error, std::abs(covered[f] - scene.fibers.element_length[scene.fibers.first_element(f)]));
    error = scene.comm.max(error);
    all_errors = std::max({all_errors, error, linear, ranks});
    if (scene.comm.rank() == 0)
      std::printf(
          "%lld elements on edges, faces, diagonals: outside %.1e, of one %.1e, linear field %.1e, ranks %.1e\n",
          static_cast<long long>(scene.fibers.global_elements), coverage.outside, error, linear, ranks);
    EXPECT_LE(coverage.outside, 1e-13);
    EXPECT_NEAR(coverage.covered, all, 1e-12 * all);
    EXPECT_LE(error, 1e-14);
    EXPECT_LE(linear, 1e-13);
    EXPECT_LE(coverage.identity_error, 1e-13);
    EXPECT_LE(ranks, 1e-13);
  }
  record({.section = "Coupling",
          .check =
              "fibers along all edges, face and space diagonals of 216 cells, straight and warped: lengths, linear "
              "field, one rank against several",
          .source = "identity",
          .error = all_errors,
          .bar = "1e-13"});
}

// Two hundred fibers, of which every pair of neighbors crosses, in one cell; the cell's share of M is theirs.
TEST(Stress, ManyFibersThatCrossInOneCell) {
  const mesh::HexMeshData mesh = perturbed(cube(5), 0.02, 3);
  mesh::FiberMeshData data;
  std::mt19937 random(8);
  std::uniform_real_distribution<double> place(0.46, 0.54);
  for (int pair = 0; pair < 100; ++pair) {
    const Vec3 center(place(random), place(random), place(random));
    for (int axis = 0; axis < 2; ++axis) {
      const Vec3 half = 0.02 * Vec3(place(random) - 0.5, place(random) - 0.5, place(random) - 0.5).normalized();
      add_line(data, center - half, center + half, 1);
    }
  }
  const Scene scene(mesh, data);
  Coupling coupling(scene.fluid, scene.fibers, CouplingParameters());
  const auto positions = [](const mesh::FiberMesh& fibers) { return moved(fibers, Vec3::Zero()); };
  const std::vector<double> dofs = positions(scene.fibers);
  coupling.update(dofs);
  EXPECT_EQ(coupling.coverage().segments, 200);
  EXPECT_NEAR(coupling.coverage().covered, 200 * 0.04, 1e-13);
  EXPECT_LE(linear_field_error(scene, coupling, dofs), 1e-15);
  EXPECT_LE(difference_to_one_rank(mesh, data, scene, coupling, positions), 1e-14);
}

// Fibers that turn about the center and drift through the cube, leaving it and coming back, 60 steps: in every step the
// length inside is that of the roots, and the operators are those of an object that knows no earlier step.
TEST(Stress, FibersThatCrossPartsAndLeaveTheFluid) {
  for (const double amount : {0.0, 0.02}) {
    const mesh::HexMeshData mesh = amount > 0 ? perturbed(cube(8), amount, 4) : cube(8);
    const mesh::FiberMeshData data = random_lines(60, 0.1, 0.9, 3, 12);
    const Scene scene(mesh, data);
    Coupling coupling(scene.fluid, scene.fibers, allow_outside());
    double sum = 0.0, linear = 0.0, ranks = 0.0, identity = 0.0, least = 1e300, most = 0.0;
    for (int step = 0; step <= 60; ++step) {
      const auto positions = [&](const mesh::FiberMesh& fibers) {
        const double t = step / 60.0;
        const Mat3 turn = Eigen::AngleAxisd(4 * t, Vec3(0.2, 0.5, 1).normalized()).toRotationMatrix();
        const Vec3 center(0.5, 0.5, 0.5), drift(0.8 * std::sin(6.3 * t), 0.3 * t, -0.2 * t);
        return deformed(
            fibers, [&](const Vec3& x) { return Vec3(center + drift + turn * (x - center) - x); },
            [&](const Vec3&) { return Mat3(turn - Mat3::Identity()); });
      };
      const std::vector<double> dofs = positions(scene.fibers);
      coupling.update(dofs);
      const LengthErrors errors = length_errors(scene, coupling, dofs);
      sum = std::max(sum, errors.fiber);
      least = std::min(least, errors.total);
      most = std::max(most, errors.total);
      linear = std::max(linear, linear_field_error(scene, coupling, dofs));
      identity = std::max(identity, coupling.coverage().identity_error);
      if (step % 6 == 0) ranks = std::max(ranks, difference_to_one_rank(mesh, data, scene, coupling, positions));
    }
    if (scene.comm.rank() == 0)
      std::printf(
          "moving fibers, inside %.3f to %.3f: error of one fiber %.1e, linear field %.1e, M.1 - kappa %.1e, "
          "ranks %.1e\n",
          least, most, sum, linear, identity, ranks);
    EXPECT_LT(least, 0.5 * most);
    EXPECT_LE(sum, 1e-12);
    EXPECT_LE(linear, 1e-13);
    EXPECT_LE(identity, 1e-13);
    EXPECT_LE(ranks, 1e-13);
    record({.section = "Coupling",
            .check = log::format("60 fibers that turn and drift through %s cells, leave them and return, 60 steps: "
                                 "length inside of every fiber",
                                 amount > 0 ? "512 warped" : "8 x 8 x 8"),
            .source = "roots of the cubics",
            .error = sum,
            .bar = "1e-12"});
  }
}

// A fiber slides along the plane, the edge and the point in which parts of the mesh meet, exactly in them.
TEST(Stress, SlidingInTheFacesBetweenParts) {
  for (const bool general : {false, true}) {
    const mesh::HexMeshData mesh = cube(8, general);
    mesh::FiberMeshData data;
    for (const double y : {0.25, 0.5, 0.75})
      for (const double z : {0.25, 0.5, 0.75}) {
        add_line(data, Vec3(0.0, y, z), Vec3(0.375, y, z), 3);
        add_line(data, Vec3(y, 0.0, z), Vec3(y, 0.375, z), 3);
        add_line(data, Vec3(y, z, 0.0), Vec3(y, z, 0.375), 3);
      }
    const Scene scene(mesh, data);
    Coupling coupling(scene.fluid, scene.fibers, allow_outside());
    for (int step = 0; step <= 15; ++step) {  // at 16 nothing would be left in the fluid
      const auto positions = [&](const mesh::FiberMesh& fibers) {
        std::vector<double> dofs = moved(fibers, Vec3::Zero());
        for (Index f = 0; f < fibers.fibers(); ++f)
          for (Index n = fibers.first_node[f]; n < fibers.first_node[f + 1]; ++n)
            dofs[6 * static_cast<std::size_t>(n) + static_cast<std::size_t>(fibers.fiber_id[f] % 3)] += step * 0.0625;
        return dofs;
      };
      const std::vector<double> dofs = positions(scene.fibers);
      coupling.update(dofs);
      const double inside = std::clamp(1.0 - step * 0.0625, 0.0, 0.375);
      EXPECT_NEAR(coupling.coverage().covered, 27 * inside, 1e-13) << "step " << step;
      EXPECT_LE(coupling.coverage().identity_error, 1e-14);
      EXPECT_LE(linear_field_error(scene, coupling, dofs), 1e-14);
      EXPECT_LE(difference_to_one_rank(mesh, data, scene, coupling, positions), 1e-14);
    }
  }
}

}  // namespace
}  // namespace fbi::test
