// Parts of the preconditioner against what they approximate, on any number of ranks.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <set>
#include <type_traits>
#include <utility>

#include "fsi/box_lines.hpp"
#include "fsi/mesh_lines.hpp"
#include "fsi/pressure_convection.hpp"
#include "fsi/velocity_weight.hpp"
#include "linalg/vector_access.hpp"
#include "unit/fluid/fluid_scene.hpp"

namespace fbi::fluid::test {
namespace {

constexpr Option scenes[] = {
    {"box", 0, ConvectiveForm::advective, ViscousResidual::full, TimeScheme::one_step_theta, 0.5},
    {"general", 0.2, ConvectiveForm::advective, ViscousResidual::full, TimeScheme::one_step_theta, 0.5},
};
const Vec3 slope(0.3, -1.1, 0.7);

/// Mean velocity of the corners of a cell; `velocity` has four numbers a node.
Vec3 mean_velocity(const mesh::HexMesh& mesh, const double* velocity, Index cell) {
  Vec3 v = Vec3::Zero();
  for (int a = 0; a < 8; ++a)
    v += 0.125 * Eigen::Map<const Vec3>(velocity + 4 * mesh.cells[8 * static_cast<std::size_t>(cell) + a]);
  return v;
}

/// Volume integral of rho v . slope by one point a cell, and its first moments: shares of a cell are its corners'.
Eigen::Vector4d convected(Scene& scene) {
  LocalArray velocity(scene.field.iterate());
  Eigen::Vector4d sums = Eigen::Vector4d::Zero();
  for (Index c = 0; c < scene.mesh.local_cells(); ++c) {
    const double amount = scene.field.parameters().density * scene.field.cell_volume(c) *
                          mean_velocity(scene.mesh, velocity.data(), c).dot(slope);
    sums[0] += amount;
    for (int a = 0; a < 8; ++a)
      sums.tail<3>() += 0.125 * amount *
                        Eigen::Map<const Vec3>(scene.mesh.node(scene.mesh.cells[8 * static_cast<std::size_t>(c) + a]));
  }
  scene.mesh.comm.sum(sums.data(), 4);
  return sums;
}

/// The same of what was added to the fourth entries of nodes.
Eigen::Vector4d added(const Scene& scene, const std::vector<float>& y) {
  Eigen::Vector4d sums = Eigen::Vector4d::Zero();
  for (Index n = 0; n < scene.mesh.local_nodes(); ++n) {
    const double amount = y[4 * static_cast<std::size_t>(n) + 3];
    sums[0] += amount;
    sums.tail<3>() += amount * Eigen::Map<const Vec3>(scene.mesh.node(n));
  }
  scene.mesh.comm.sum(sums.data(), 4);
  return sums;
}

std::vector<float> pressure(const Scene& scene, const std::function<double(const Vec3&)>& q) {
  std::vector<float> nodal(4 * static_cast<std::size_t>(scene.mesh.local_nodes()), 7.0f);
  for (Index n = 0; n < scene.mesh.local_nodes(); ++n)
    nodal[4 * static_cast<std::size_t>(n) + 3] = static_cast<float>(q(Eigen::Map<const Vec3>(scene.mesh.node(n))));
  return nodal;
}

TEST(PressureConvection, OfLinearPressures) {
  linalg::initialize_petsc();
  for (const Option& option : scenes) {
    Scene scene(Comm(MPI_COMM_WORLD), option);
    fsi::PressureConvection convection(scene.field);
    convection.renew();
    const std::vector<float> q = pressure(scene, [](const Vec3& x) { return 2.0 + slope.dot(x); });
    std::vector<float> y(q.size(), 0.0f);
    convection.add(q.data(), y.data());
    const Eigen::Vector4d exact = convected(scene);
    EXPECT_LT((added(scene, y) - exact).norm(), 1e-5 * exact.norm()) << option.name;
    for (std::size_t k = 0; k < y.size(); ++k) EXPECT_TRUE(k % 4 == 3 || y[k] == 0.0f);
    const std::vector<float> constant = pressure(scene, [](const Vec3&) { return 3.0; });
    std::vector<float> nothing(q.size(), 0.0f);
    convection.add(constant.data(), nothing.data());
    for (const float value : nothing) EXPECT_NEAR(value, 0.0, 1e-6);
  }
}

TEST(PressureConvection, FollowsTheIterate) {
  linalg::initialize_petsc();
  Scene scene(Comm(MPI_COMM_WORLD), scenes[1]);
  fsi::PressureConvection convection(scene.field);
  convection.renew();
  const Eigen::Vector4d before = convected(scene);
  linalg::VecHandle delta = scene.field.create_vector();
  fill(scene.mesh, delta, [](GlobalIndex node, int c) { return noise(node, c, 9); });
  scene.drop_dirichlet(delta);
  scene.field.increment(delta);
  convection.renew();
  const std::vector<float> q = pressure(scene, [](const Vec3& x) { return slope.dot(x); });
  std::vector<float> y(q.size(), 0.0f);
  convection.add(q.data(), y.data());
  const Eigen::Vector4d after = convected(scene);
  EXPECT_GT((after - before).norm(), 1e-2 * after.norm());
  EXPECT_LT((added(scene, y) - after).norm(), 1e-5 * after.norm());
}

// The nodal mean of tau_C keeps its integral.
TEST(VelocityWeight, GradDivAtNodes) {
  linalg::initialize_petsc();
  for (const Option& option : scenes) {
    Scene scene(Comm(MPI_COMM_WORLD), option);
    fsi::VelocityWeight weight(scene.field);
    weight.renew();
    const std::vector<double> grad_div = weight.grad_div();
    ASSERT_EQ(grad_div.size(), static_cast<std::size_t>(scene.mesh.local_nodes()));
    LocalArray velocity(scene.field.iterate());
    double sums[2] = {0.0, 0.0};
    for (Index c = 0; c < scene.mesh.local_cells(); ++c) {
      const double volume = scene.field.cell_volume(c);
      sums[0] += volume * 0.5 * scene.field.parameters().density *
                 mean_velocity(scene.mesh, velocity.data(), c).norm() * std::cbrt(volume);
    }
    for (Index n = 0; n < scene.mesh.owned_nodes; ++n) sums[1] += scene.field.lumped_volume()[n] * grad_div[n];
    scene.mesh.comm.sum(sums, 2);
    // Volumes of warped cells and of their middles' parallelepipeds differ.
    EXPECT_NEAR(sums[1], sums[0], (option.warp > 0.0 ? 1e-2 : 1e-12) * sums[0]) << option.name;
  }
}

/// A flow along y or z through a box that is longest in x, so that ranks of a box have whole lines along the flow.
/// Cells, and with them tau, change along the flow only.
template <class Lines>
struct Channel {
  /// Whether the velocity along the lines has an L of its own.
  static constexpr bool tells_apart = std::is_same_v<Lines, fsi::BoxLines>;
  mesh::HexMesh mesh;
  FluidField field;
  fsi::VelocityWeight weight;
  Lines lines;
  Channel(int axis, const Vec3& velocity)
      : mesh(box_mesh(
            Comm(MPI_COMM_WORLD),
            {uniform(0, 3, 13), graded(0, 1, 7, axis == 1 ? 1.3 : 1.0), graded(0, 0.8, 6, axis == 2 ? 0.8 : 1.0)},
            std::is_same_v<Lines, fsi::MeshLines>)),
        field(mesh, parameters(velocity), conditions(axis, velocity), {TimeScheme::one_step_theta, 1.0}),
        weight(field),
        lines(field) {
    field.initialize();
    field.begin_step(0.05, 0.05);
    field.linearize();
    weight.renew();
    lines.renew(weight);
  }
  static FluidParameters parameters(const Vec3& velocity) {
    FluidParameters p;
    p.density = 1.7;
    p.viscosity = 1e-6;
    p.grad_div = tells_apart;  // else V has a third of it, which is not there in what changes along the flow
    p.initial_velocity =
        expressions(std::to_string(velocity[0]), std::to_string(velocity[1]), std::to_string(velocity[2]));
    return p;
  }
  static BoundaryConditions conditions(int axis, const Vec3& velocity_there) {
    BoundaryConditions all;
    for (const std::string& face : box_faces) all[face] = of_type(BoundaryType::traction);
    all[box_faces[2 * axis]] = velocity(parameters(velocity_there).initial_velocity);
    return all;
  }
  Index place(Index node, int direction) const {
    constexpr std::array<Index, 3> n = {14, 8, 7};
    const GlobalIndex id = mesh.node_id[node];
    return static_cast<Index>(direction == 0 ? id % n[0] : direction == 1 ? id / n[0] % n[1] : id / n[0] / n[1]);
  }
};

template <class Lines>
class VelocityLines : public testing::Test {};
using AllLines = testing::Types<fsi::BoxLines, fsi::MeshLines>;
TYPED_TEST_SUITE(VelocityLines, AllLines);

/// 1 for owned nodes whose line is whole: ranks of a general mesh may share a layer of cells, and cut lines.
std::vector<char> on_whole_lines(const Channel<fsi::BoxLines>& channel, int) {
  return std::vector<char>(channel.mesh.owned_nodes, 1);
}
std::vector<char> on_whole_lines(const Channel<fsi::MeshLines>& channel, int axis) {
  std::vector<char> whole(channel.mesh.owned_nodes, 0);
  for (const std::vector<Index>& line : channel.lines.lines())
    for (const Index a : line) whole[a] = line.size() == (axis == 1 ? 8u : 7u);
  return whole;
}

// What changes along the flow alone: the velocity block and V are inverse to each other.
TYPED_TEST(VelocityLines, InvertTheBlockAlongTheFlow) {
  linalg::initialize_petsc();
  for (const int axis : {1, 2}) {
    Vec3 flow = Vec3::Zero();
    flow[axis] = 2.0;
    Channel<TypeParam> channel(axis, flow);
    if constexpr (std::is_same_v<TypeParam, fsi::BoxLines>) {
      ASSERT_TRUE(fsi::BoxLines::supports(channel.mesh));
      EXPECT_EQ(channel.lines.axis(), axis);
    }
    const std::vector<char> whole = on_whole_lines(channel, axis);
    // The velocities across, and the one along, which grad-div has forces across from, where the box ends.
    for (const bool along : {false, true}) {
      if (along && !Channel<TypeParam>::tells_apart) continue;
      const auto tested = [&](int c) { return c < 3 && (c == axis) == along; };
      linalg::VecHandle u = channel.field.create_vector(), r = channel.field.create_vector();
      const Index owned = channel.mesh.owned_nodes;
      {
        linalg::Write to(u);
        for (Index a = 0; a < owned; ++a)
          for (int c = 0; c < 4; ++c) {
            const Index at = channel.place(a, axis);
            to.get()[4 * a + c] = tested(c) && at > 0 ? noise(at, c, 4) : 0.0;
          }
      }
      channel.field.apply_jacobian(u, r);
      const std::vector<double> exact = owned_values(u), right = owned_values(r);
      std::vector<float> b(right.begin(), right.end()), x(right.size(), 7.0f);
      channel.lines.apply(b.data(), x.data());
      GlobalIndex nodes = 0;
      for (Index a = 0; a < owned; ++a) {
        EXPECT_EQ(x[4 * a + 3], 7.0f);
        if (whole[a] == 0 || channel.place(a, axis) == 0) continue;
        ++nodes;
        for (int c = 0; c < 3; ++c)
          if (tested(c)) {
            EXPECT_NEAR(x[4 * a + c], exact[4 * a + c], 2e-4);
          }
      }
      EXPECT_GT(channel.mesh.comm.sum(nodes), 14 * 8 * 7 / 2);
    }
  }
}

// The diagonal is that of fields that are rough along x and constant along z; where velocities are told apart, of the
// one that grad-div does not act on there. Forces reach what `reached` says.
TYPED_TEST(VelocityLines, DiagonalAndReach) {
  linalg::initialize_petsc();
  Channel<TypeParam> channel(1, Vec3(0.1, 2.0, -0.2));
  const Index owned = channel.mesh.owned_nodes;
  const std::vector<double> diagonal = channel.lines.diagonal(), grad_div = channel.weight.grad_div();
  for (const Index y : {2, 7}) {
    std::vector<float> r(4 * static_cast<std::size_t>(owned), 0.0f), x = r, part = r;
    std::vector<Index> nodes;
    for (Index a = 0; a < owned; ++a)
      if (channel.place(a, 0) == 2 && channel.place(a, 1) == y) {
        nodes.push_back(a);
        const Index z = channel.place(a, 2);
        for (int c = 0; c < 3; ++c) r[4 * a + c] = z == 0 || z == 6 ? 0.5f : 1.0f;  // a force for each area
      }
    channel.lines.apply(r.data(), x.data());
    for (const Index a : nodes)
      for (int c = 0; c < 3; ++c) {
        const double of_diagonal = x[4 * a + c] / r[4 * a + c] / diagonal[3 * a + c];
        if (!Channel<TypeParam>::tells_apart || c == 2) {
          EXPECT_NEAR(of_diagonal, 1.0, 1e-5);
        } else if (c == 0) {  // along the edges that the field is rough on: grad-div takes from B
          const FluidParameters& p = channel.field.parameters();
          const double inertia = p.density * channel.field.sigma(), square = 13.0 * 13.0 / 9.0;
          const auto factor = [&](double stiffness) { return 1.0 / (2.0 / 3.0 + 2.0 * stiffness / inertia); };
          const double expected = std::max(0.75, factor(grad_div[a] * square)) / factor(0.0);
          EXPECT_LT(expected, 0.9);
          EXPECT_NEAR(of_diagonal, expected, 1e-4);
        } else {
          EXPECT_LT(of_diagonal, 1.0);
        }
      }
    const std::vector<char> reached = channel.lines.reached(nodes);
    channel.lines.apply(r.data(), part.data(), &reached);
    EXPECT_EQ(part, x);
    const std::vector<char> on_lines = channel.lines.nodes_of(reached);
    for (Index a = 0; a < owned; ++a) EXPECT_TRUE(x[4 * a] == 0.0f || on_lines[a] != 0);
    Index lines = 0;
    for (const char line : reached) lines += line;
    if (channel.mesh.comm.size() == 1) {
      EXPECT_EQ(lines, 3 * 7);
    }
  }
  // Ghosts have what their owners have, given velocities nothing.
  for (Index a = 0; a < channel.mesh.local_nodes(); ++a) EXPECT_EQ(diagonal[3 * a] == 0.0, channel.place(a, 1) == 0);
}

// Any flow, any wall and any cells: finite, and positive definite on what is rough.
template <class Lines>
void expect_positive(const Option& option) {
  Scene scene(Comm(MPI_COMM_WORLD), option);
  fsi::VelocityWeight weight(scene.field);
  Lines lines(scene.field);
  weight.renew();
  lines.renew(weight);
  for (const double value : lines.diagonal()) EXPECT_TRUE(std::isfinite(value) && value >= 0.0);
  const std::size_t size = 4 * static_cast<std::size_t>(scene.mesh.owned_nodes);
  std::vector<float> r(size, 0.0f), x(size, 0.0f);
  for (std::size_t k = 0; k < size; ++k)
    if (k % 4 != 3 && scene.field.is_dirichlet()[k] == 0)
      r[k] = static_cast<float>(noise(scene.mesh.node_id[k / 4], static_cast<int>(k % 4), 3));
  lines.apply(r.data(), x.data());
  double product = 0.0;
  for (std::size_t k = 0; k < size; ++k) product += r[k] * x[k];
  EXPECT_GT(scene.mesh.comm.sum(product), 0.0);
}
TEST(VelocityLines, StayPositive) {
  linalg::initialize_petsc();
  expect_positive<fsi::BoxLines>(scenes[0]);
  expect_positive<fsi::MeshLines>(scenes[0]);
  expect_positive<fsi::MeshLines>(scenes[1]);
}

// A rough flow between warped cells: lines of all lengths, each owned node on one of them, edges between neighbors.
TEST(MeshLines, HoldEveryNodeOnceAlongEdges) {
  linalg::initialize_petsc();
  Scene scene(Comm(MPI_COMM_WORLD), scenes[1]);
  fsi::VelocityWeight weight(scene.field);
  fsi::MeshLines lines(scene.field);
  weight.renew();
  lines.renew(weight);
  std::set<std::pair<Index, Index>> edges;
  for (std::size_t c = 0; c < static_cast<std::size_t>(scene.mesh.local_cells()); ++c)
    for (const auto& direction : fsi::line_edges)
      for (const auto& ends : direction) {
        const Index a = scene.mesh.cells[8 * c + ends[0]], b = scene.mesh.cells[8 * c + ends[1]];
        edges.insert({a, b});
        edges.insert({b, a});
      }
  std::vector<int> times(scene.mesh.owned_nodes, 0);
  std::size_t longest = 0, before = times.size();
  for (const std::vector<Index>& line : lines.lines()) {
    EXPECT_LE(line.size(), before);
    before = line.size();
    longest = std::max(longest, line.size());
    for (std::size_t t = 0; t < line.size(); ++t) {
      ++times[line[t]];
      if (t > 0) {
        EXPECT_EQ(edges.count({line[t - 1], line[t]}), 1u);
      }
    }
  }
  for (const int count : times) EXPECT_EQ(count, 1);
  EXPECT_GE(scene.mesh.comm.max(static_cast<double>(longest)), 3.0);
}

// The lines of a flow that has not turned stay what they are, and the same flow gives the same ones.
TEST(MeshLines, ChangeWithTheFlowOnly) {
  linalg::initialize_petsc();
  Channel<fsi::MeshLines> channel(1, Vec3(0.1, 2.0, -0.2));
  const int version = channel.lines.version();
  const std::vector<std::vector<Index>> first = channel.lines.lines();
  for (int k = 0; k < 20; ++k) channel.lines.renew(channel.weight);
  EXPECT_EQ(channel.lines.version(), version);
  EXPECT_EQ(channel.lines.lines(), first);
  // What is given by ends of lines on a box: whole rows of nodes along y.
  for (const std::vector<Index>& line : first)
    for (std::size_t t = 0; t < line.size(); ++t) EXPECT_EQ(channel.place(line[t], 1), static_cast<Index>(t));
}

}  // namespace
}  // namespace fbi::fluid::test
