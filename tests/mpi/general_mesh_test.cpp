/// Flows on general and periodic meshes: exact solutions, order, independence of numbering, place and ranks.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "record.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

constexpr double pi = std::numbers::pi;

// A square cell of the vortex of Taylor and Green, one cell deep, periodic in all directions.
Json vortex(int n, double shift = 0.0) {
  Json json = parse_json(R"({
    "fluid": { "density": 1.0, "viscosity": 0.02 },
    "channel": { "boundaries": {
      "xmin": { "type": "periodic", "with": "xmax" }, "xmax": { "type": "periodic" },
      "ymin": { "type": "periodic" }, "ymax": { "type": "periodic", "with": "ymin" },
      "zmin": { "type": "periodic", "with": "zmax" }, "zmax": { "type": "periodic", "with": "zmin" } } },
    "time": { "end": 0.1, "fluid": { "theta": 0.5 } } })");
  json["channel"]["size"] = {1.0, 1.0, 1.0 / n};
  json["channel"]["elements"] = {n, n, 1};
  json["fluid"]["initial_velocity"] = {log::format("sin(2*pi*(x-%.17g))*cos(2*pi*y)", shift),
                                       log::format("-cos(2*pi*(x-%.17g))*sin(2*pi*y)", shift), "0"};
  json["time"]["step"] = 0.1 / (1.25 * n);
  json["solver"]["newton_tolerance"] = 1e-12;
  json["solver"]["newton_absolute_tolerance"] = 1e-15;
  return json;
}

// Root mean square over the nodes of the velocity minus the exact one, relative to its amplitude.
double vortex_error(CoupledCase& run) {
  const mesh::HexMesh& mesh = *run.setup.fluid_mesh;
  const double amplitude = std::exp(-8.0 * pi * pi * 0.02 * run.time());
  fluid::LocalArray u(run.fluid().accepted());
  double sum = 0.0;
  for (Index n = 0; n < mesh.owned_nodes; ++n) {
    const double x = 2.0 * pi * mesh.node(n)[0], y = 2.0 * pi * mesh.node(n)[1];
    const double exact[3] = {amplitude * std::sin(x) * std::cos(y), -amplitude * std::cos(x) * std::sin(y), 0.0};
    for (int i = 0; i < 3; ++i) sum += std::pow(u[4 * static_cast<std::size_t>(n) + i] - exact[i], 2);
  }
  return std::sqrt(run.comm().sum(sum) / static_cast<double>(mesh.independent_nodes)) / amplitude;
}

Json cylinder_case() {
  Json json = parse_json(R"({
    "fluid": { "density": 1.0, "viscosity": 0.001 },
    "channel": { "size": [2.2, 0.41, 0.02], "cylinder": { "center": [0.2, 0.2], "radius": 0.05, "around": 24 },
      "boundaries": { "xmin": { "type": "inflow", "velocity": ["1.2*y*(0.41-y)/0.41^2", 0, 0] },
        "xmax": { "type": "outflow" }, "ymin": { "type": "no_slip" }, "ymax": { "type": "no_slip" },
        "zmin": { "type": "slip" }, "zmax": { "type": "slip" }, "cylinder": { "type": "no_slip" } } },
    "time": { "step": 0.01, "end": 0.03 } })");
  json["solver"] = parse_json(R"({ "linear": "iterative", "newton_tolerance": 1e-11, "newton_absolute_tolerance": 1e-16,
    "krylov_tolerance": 1e-6, "newton_iterations": 30, "krylov_iterations": 400 })");
  return json;
}

// Nodes and cells in another order, cells turned about their zeta axis; `node` receives the new number of each node.
void shuffle(mesh::HexMeshData& mesh, unsigned seed, std::vector<GlobalIndex>& node) {
  constexpr int about_z[8] = {1, 2, 3, 0, 5, 6, 7, 4};
  constexpr Index face_after[6] = {3, 2, 0,
                                   1, 4, 5};  // where a face of the cell lies when corner a is corner about_z[a]
  std::mt19937 random(seed);
  node.resize(mesh.node_count());
  std::vector<GlobalIndex> cell(mesh.cell_count());
  std::iota(node.begin(), node.end(), GlobalIndex{0});
  std::iota(cell.begin(), cell.end(), GlobalIndex{0});
  std::shuffle(node.begin(), node.end(), random);
  std::shuffle(cell.begin(), cell.end(), random);
  mesh::HexMeshData result = mesh;
  std::vector<char> turned(mesh.cell_count());
  for (GlobalIndex n = 0; n < mesh.node_count(); ++n) std::copy_n(&mesh.nodes[3 * n], 3, &result.nodes[3 * node[n]]);
  for (GlobalIndex c = 0; c < mesh.cell_count(); ++c) {
    turned[c] = random() % 2 == 0;
    for (int a = 0; a < 8; ++a)
      result.cells[8 * cell[c] + a] = node[mesh.cells[8 * c + (turned[c] != 0 ? about_z[a] : a)]];
  }
  for (auto& [name, faces] : result.faces)
    for (mesh::Face& face : faces) face = {cell[face.cell], turned[face.cell] != 0 ? face_after[face.face] : face.face};
  for (auto& pair : result.periodic) pair = {node[pair[0]], node[pair[1]]};
  mesh = result;
}

Snapshot serial(const Json& json, int steps) {
  CoupledCase run(json, MPI_COMM_SELF);
  run.run(steps);
  return run.snapshot();
}

TEST(Periodic, taylor_green_vortex_decays_at_second_order) {
  double before = 0.0;
  for (const int n : {8, 16, 32}) {
    CoupledCase run(vortex(n));
    run.run(static_cast<int>(run.setup.steps));
    const double error = vortex_error(run);
    const double order = before > 0.0 ? std::log2(before / error) : not_given;
    report("error, " + std::to_string(n) + " cells", error);
    if (n == 32) {
      report("order", order);
      EXPECT_GT(order, 1.9);
      EXPECT_LT(error, 5e-3);
    }
    record({.section = "General meshes",
            .check = "Taylor-Green vortex, periodic in x, y, z, velocity at t = 0.1, " + std::to_string(n) + " cells",
            .source = "exact solution",
            .reference_text = "0",
            .ours_text = log::format("%.3e", error),
            .error = error,
            .order = order,
            .bar = "order above 1.9"});
    before = error;
  }
}

// The vortex moved by three cells: the periodic faces cut it elsewhere.
TEST(Periodic, the_place_of_the_faces_does_not_matter) {
  const int n = 16, cells = 3;
  CoupledCase run(vortex(n)), moved(vortex(n, static_cast<double>(cells) / n));
  run.run(5);
  moved.run(5);
  const Snapshot a = run.snapshot(), b = moved.snapshot();
  double difference = 0.0;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i)
      for (int d = 0; d < 3; ++d) {
        const std::size_t here = i + static_cast<std::size_t>(n + 1) * j;
        const std::size_t there = (i + cells) % n + static_cast<std::size_t>(n + 1) * j;
        difference = std::max(difference, std::abs(a.velocity[3 * here + d] - b.velocity[3 * there + d]));
      }
  report("largest difference", difference);
  EXPECT_LT(difference, 1e-9);
  record({.section = "General meshes",
          .check = "vortex moved by three cells through a periodic face: largest difference of velocities",
          .source = "identity",
          .reference_text = "0",
          .ours_text = log::format("%.1e", difference),
          .bar = "1e-9"});
}

TEST(Periodic, poiseuille_flow_is_exact) {
  const Json box = parse_json(R"({
    "fluid": { "density": 2.0, "viscosity": 0.5, "body_force": [0.5, 0, 0] },
    "channel": { "size": [1, 1, 0.5], "elements": [3, 8, 2], "boundaries": {
      "xmin": { "type": "periodic", "with": "xmax" }, "xmax": { "type": "periodic" },
      "ymin": { "type": "no_slip" }, "ymax": { "type": "no_slip" },
      "zmin": { "type": "periodic" }, "zmax": { "type": "periodic", "with": "zmin" } } },
    "time": { "fluid": { "scheme": "steady" } } })");
  for (const bool general : {false, true}) {
    Json json = box;
    json["channel"]["general"] = general;
    CoupledCase run(json);
    EXPECT_TRUE(run.fluid().pressure_is_free());
    run.run(1);
    const mesh::HexMesh& mesh = *run.setup.fluid_mesh;
    EXPECT_EQ(mesh.global_nodes, 4 * 9 * 3);
    EXPECT_EQ(mesh.independent_nodes, 3 * 9 * 2);
    fluid::LocalArray u(run.fluid().accepted());
    double largest = 0.0;
    for (Index n = 0; n < mesh.local_nodes(); ++n) {                                // images, too
      const double y = mesh.node(n)[1], exact[4] = {y * (1.0 - y), 0.0, 0.0, 0.0};  // rho b/(2 mu) y (1 - y)
      for (int i = 0; i < 4; ++i)
        largest = std::max(largest, std::abs(u[4 * static_cast<std::size_t>(n) + i] - exact[i]));
    }
    largest = run.comm().max(largest);
    EXPECT_LT(largest, 1e-12);
    record({.section = "General meshes",
            .check = std::string("periodic Poiseuille flow driven by a body force, nodal error, ") +
                     (general ? "general mesh" : "box"),
            .source = "exact solution",
            .reference_text = "0",
            .ours_text = log::format("%.1e", largest),
            .bar = "1e-12"});
  }
}

TEST(GeneralMesh, ranks_agree_on_the_flow_around_a_cylinder) {
  Json json = cylinder_case();
  const Snapshot expected = serial(json, 3);
  for (const char* partition : {"coordinates", "graph"}) {
    if (partition == std::string("graph") && !linalg::has_graph_partition()) continue;
    json["channel"]["cylinder"]["partition"] = partition;
    CoupledCase run(json);
    run.run(3);
    const Snapshot result = run.snapshot();
    const double velocity = relative_difference(result.velocity, expected.velocity);
    const double pressure = relative_difference(result.pressure, expected.pressure);
    report(std::string("velocity, ") + partition, velocity);
    report(std::string("pressure, ") + partition, pressure);
    EXPECT_LT(velocity, 1e-8);
    EXPECT_LT(pressure, 1e-7);
  }
}

// Repeatable on as many ranks: the same bits in a second run of the case.
TEST(GeneralMesh, parts_of_the_graph_are_repeatable) {
  if (!linalg::has_graph_partition()) GTEST_SKIP() << "a build without PT-Scotch";
  Json json = cylinder_case();
  json["channel"]["cylinder"]["partition"] = "graph";
  CoupledCase first(json), second(json);
  first.run(2);
  second.run(2);
  EXPECT_EQ(first.setup.fluid_mesh->cell_id, second.setup.fluid_mesh->cell_id);
  EXPECT_EQ(first.snapshot().velocity, second.snapshot().velocity);
  EXPECT_EQ(first.snapshot().pressure, second.snapshot().pressure);
}

TEST(GeneralMesh, ranks_agree_on_a_periodic_vortex) {
  const Json json = vortex(12);
  const Snapshot expected = serial(json, 4);
  CoupledCase run(json);
  EXPECT_TRUE(run.fluid().pressure_is_free());  // although nothing is left of a constant pressure anywhere
  run.run(4);
  EXPECT_LT(relative_difference(run.snapshot().velocity, expected.velocity), 1e-8);
}

TEST(GeneralMesh, numbering_does_not_matter) {
  Json json = cylinder_case();
  json["channel"]["cylinder"]["around"] = 16;
  json["solver"]["linear"] = "direct";
  json["channel"]["boundaries"]["zmin"] = parse_json(R"({ "type": "periodic", "with": "zmax" })");
  json["channel"]["boundaries"]["zmax"] = parse_json(R"({ "type": "periodic" })");
  CoupledCase run(json);
  run.run(2);
  const Snapshot expected = run.snapshot();
  double largest = 0.0;
  for (unsigned seed = 1; seed <= 3; ++seed) {
    std::vector<GlobalIndex> node;
    CoupledCase other(json, MPI_COMM_WORLD, [&](mesh::HexMeshData& mesh) { shuffle(mesh, seed, node); });
    other.run(2);
    const Snapshot result = other.snapshot();
    std::vector<double> back(result.velocity.size());
    for (std::size_t n = 0; n < node.size(); ++n) std::copy_n(&result.velocity[3 * node[n]], 3, &back[3 * n]);
    largest = std::max(largest, relative_difference(back, expected.velocity));
  }
  report("largest difference", largest);
  EXPECT_LT(largest, 1e-10);
  record({.section = "General meshes",
          .check = "nodes and cells numbered at random, cells turned: largest difference of velocities",
          .source = "identity",
          .reference_text = "0",
          .ours_text = log::format("%.1e", largest),
          .bar = "1e-10"});
}

}  // namespace
}  // namespace fbi::test
