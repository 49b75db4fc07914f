/// A fiber alone in a stream at small Reynolds numbers: Lamb's drag with the radius that the mesh gives it.
#include "regression/straight_fibers.hpp"

namespace fbi::test {
namespace {

constexpr int core = 10;  // cells of size 1 on each side of the fiber; beyond, each is `growth` times the last
constexpr double growth = 1.25;

/// Coordinates from -reach to reach or more, the fiber at 0: on a node or in the middle of a cell.
std::vector<double> stretched(bool on_node, double reach) {
  std::vector<double> positive;
  double x = on_node ? 1.0 : 0.5, size = 1.0;
  for (int k = 0; x < reach; ++k) {
    positive.push_back(x);
    if (k > core) size *= growth;
    x += size;
  }
  positive.push_back(x);
  std::vector<double> all;
  for (std::size_t k = positive.size(); k-- > 0;) all.push_back(-positive[k]);
  if (on_node) all.push_back(0.0);
  all.insert(all.end(), positive.begin(), positive.end());
  return all;
}

/// F/(mu U) of a fiber in a stream U = 1, rho = 1, on cells that are 1 around it.
double stream_drag(bool on_node, double viscosity, double reach) {
  const std::vector<double> x = stretched(on_node, reach);
  const int n = static_cast<int>(x.size()) - 1;
  Json json = box_with_fiber(n, n, 1.0, 0.0, 0.0);
  json["fluid"] = {{"density", 1.0},    {"viscosity", viscosity}, {"viscous_residual", "none"},
                   {"grad_div", false}, {"tau_time", false},      {"initial_velocity", {"1", "0", "0"}}};
  json["channel"]["origin"] = {-0.5 * n, -0.5 * n, 0.0};
  Json& faces = json["channel"]["boundaries"];
  faces["xmin"] = parse_json(R"({ "type": "inflow", "velocity": ["1", "0", "0"] })");
  faces["xmax"] = parse_json(R"({ "type": "outflow" })");
  faces["ymin"] = faces["ymax"] = parse_json(R"({ "type": "mixed", "velocity": ["1", null, "0"] })");
  json["coupling"]["penalty"] = 1e6 * viscosity;
  json["solver"]["linear"] = "direct";
  CoupledCase run(json, MPI_COMM_WORLD, [&](mesh::HexMeshData& mesh) {
    for (std::size_t k = 0; k < mesh.nodes.size(); ++k)
      if (k % 3 != 2) mesh.nodes[k] = x.at(static_cast<std::size_t>(std::lround(mesh.nodes[k] + 0.5 * n)));
    mesh.box->coordinates[0] = mesh.box->coordinates[1] = x;
  });
  return solve_for_force(run, 2.0)[0] / viscosity;
}

TEST(Lamb, FiberInAStream) {
  for (const bool on_node : {false, true}) {
    const double radius = transverse_radius(on_node ? 32 : 33);
    for (const double reynolds : {0.1, 0.5}) {
      if (on_node && reynolds > 0.2) continue;
      const double viscosity = 2 * radius / reynolds;
      const double s = 0.5 - std::numbers::egamma + std::log(8 / reynolds);
      const double lamb = 4 * std::numbers::pi / s, kaplun = lamb * (1 - 0.8669 / (s * s));
      const double ours = stream_drag(on_node, viscosity, 100 * viscosity);
      const std::string check =
          log::format("fiber in a stream %s, Re %g of its diameter: F/(mu U)", place_of(on_node ? 0 : 1), reynolds);
      report(check, ours);
      report("Lamb", lamb);
      report("Kaplun", kaplun);
      record({.section = "Coupling",
              .id = "S-H5",
              .check = check,
              .source = "Lamb 1911",
              .reference = lamb,
              .ours = ours,
              .bar = "reported"});
      record({.section = "Coupling",
              .id = "S-H5",
              .check = check,
              .source = "Kaplun 1957, one term more",
              .reference = kaplun,
              .ours = ours,
              .bar = reynolds > 0.2 ? "3 %" : "1 %"});
      EXPECT_NEAR(ours, kaplun, (reynolds > 0.2 ? 0.03 : 0.01) * kaplun);
    }
  }
}

}  // namespace
}  // namespace fbi::test
