/// What limits Dirichlet-Neumann coupling: the mass of fluid that the mesh moves with a fiber, against the fiber's own.
#include "record.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

constexpr double h = 1.0 / 11.0, pi = 3.14159265358979324;

/// The first step of the obstacle in a shorter duct, by constant relaxation: does the iteration close in on a solution?
bool converges(double x, double z, double density, double relaxation) {
  Json json = read_case("obstacle");
  json["channel"]["size"] = {15 * h, 1, 1};
  json["channel"]["elements"] = {15, 11, 11};
  json["fibers"][0]["curve"] = {{"type", "line"}, {"from", {x, 0, z}}, {"to", {x, 0.5, z}}};
  json["fibers"][0]["elements"] = 5;  // as long as the cells: shorter ones have modes that move more fluid a mass
  json["fibers"][0]["material"]["density"] = density;
  json["coupling"] = {{"scheme", "constant"}, {"relaxation", relaxation}, {"multiplier", "linear"},
                      {"penalty", 1e4},       {"tolerance", 1e-3},        {"max_iterations", 25}};
  json["solver"] = {{"newton_tolerance", 1e-5}, {"krylov_iterations", 60}};
  json["output"]["probes"] = Json::array();
  CoupledCase run(json);
  return run.solve().residual < 0.3;  // it starts at 1
}

/// The iteration multiplies errors by 1 - omega (1 + m_f/m_b): its limit omega = 2/(1 + m_f/m_b) gives the mass of
/// fluid m_f = c rho h^2 per length.
void measure(const std::string& where, double x, double z, double density, double expected) {
  const double fiber_mass = density * pi * 1e-4;
  const double limit = 2.0 / (1.0 + expected * h * h / fiber_mass);
  double low = 0.75 * limit, high = 1.33 * limit;
  EXPECT_TRUE(converges(x, z, density, low)) << where;
  EXPECT_FALSE(converges(x, z, density, high)) << where;
  for (int k = 0; k < 2; ++k) {
    const double middle = std::sqrt(low * high);
    (converges(x, z, density, middle) ? low : high) = middle;
  }
  const double found = (2.0 / std::sqrt(low * high) - 1.0) * fiber_mass / (h * h);
  report(where + ", m_f/(rho h^2)", found);
  record(
      {.section = "Coupling",
       .id = "0.4",
       .check = "added mass of the mesh over rho h^2 per length from the limit of constant relaxation, fiber " + where,
       .source = "independent computation of the mesh added mass",
       .reference = expected,
       .ours = found,
       .bar = "relaxation 0.75 of the limit converges, 1.33 diverges"});
}

TEST(RelaxationLimit, fiber_through_cell_centers) { measure("through cell centers", 7.5 * h, 0.5, 10.0, 3.1); }
TEST(RelaxationLimit, fiber_along_nodes) { measure("along nodes", 7.0 * h, 5.0 * h, 2.5, 0.38); }

}  // namespace
}  // namespace fbi::test
