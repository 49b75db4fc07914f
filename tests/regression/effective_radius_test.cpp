/// The radius that the mesh gives a fiber coupled at its center line, from the flow across a square array: positions in
/// the cell, tau, options of the stabilisation, penalty. Every number against an analysis of the discrete equations,
/// mode by mode.
#include "regression/straight_fibers.hpp"

namespace fbi::test {
namespace {

constexpr const char* symbol = "the discrete equations on a lattice, mode by mode";

Json options(const char* tau, bool grad_div = false, const char* viscous = "none") {
  Json json;
  json["fluid"] = {{"tau", tau}, {"grad_div", grad_div}, {"viscous_residual", viscous}};
  return json;
}

Lattice lattice_of(const Json& changes, int n) {
  Lattice lattice;
  lattice.cells = n;
  lattice.position[0] = lattice.position[1] = n % 2 == 0 ? 0.0 : 0.5;
  const bool metric = changes["fluid"]["tau"] != "franca_valentin";
  lattice.tau = metric ? tau_of_metric : 1.0 / 12.0;
  if (changes["fluid"]["tau"] == "whiting_jansen" && changes["fluid"]["grad_div"])
    lattice.tau_c = 1 / (12 * lattice.tau);
  lattice.viscous_residual = changes["fluid"]["viscous_residual"] == "full";
  return lattice;
}

void row(const std::string& check, const char* source, double reference, double ours, double bar,
         const char* id = "S-H1") {
  check_number(id, check, source, reference, ours, bar);
}

/// a/h of one choice of options at both positions against the lattice; `known` are other people's numbers, 0 for none.
void check_radius(const std::string& name, const Json& changes, std::array<double, 2> known) {
  for (const int n : {32, 33}) {
    const double radius = transverse_radius(n, changes);
    const std::string check = "radius of the mesh a/h, " + name + ", fiber " + place_of(n);
    row(check, symbol, lattice_radius(lattice_of(changes, n)), radius, 1e-3);
    row(check, "2D finite elements, computed independently", known[n % 2], radius, 1e-2);
  }
}

TEST(RadiusOfTheMesh, FrancaValentin) { check_radius("tau h^2/(12 nu)", options("franca_valentin"), {0.0643, 0.5793}); }
TEST(RadiusOfTheMesh, WhitingJansen) { check_radius("whiting_jansen", options("whiting_jansen"), {0.0862, 0.6341}); }
TEST(RadiusOfTheMesh, TaylorHughesZarins) {
  check_radius("taylor_hughes_zarins", options("taylor_hughes_zarins"), {0.0862, 0.6341});
}
TEST(RadiusOfTheMesh, ViscousResidual) {
  check_radius("tau h^2/(12 nu), viscous residual full", options("franca_valentin", false, "full"), {0.0605, 0.5747});
}
TEST(RadiusOfTheMesh, PressureProjection) {
  Json changes;
  changes["fluid"] = {{"pressure_stabilization", "projection"}, {"viscous_residual", nullptr}};
  for (const int n : {32, 33}) {
    Lattice lattice;
    lattice.cells = n;
    lattice.position[0] = lattice.position[1] = n % 2 == 0 ? 0.0 : 0.5;
    lattice.projection = true;
    row(log::format("radius of the mesh a/h, pressure projection, fiber %s", place_of(n)), symbol,
        lattice_radius(lattice), transverse_radius(n, changes), 1e-3);
  }
}
TEST(RadiusOfTheMesh, GradDiv) {
  check_radius("whiting_jansen with grad-div", options("whiting_jansen", true), {0.162, 0.692});
  check_radius("whiting_jansen with grad-div, viscous residual full", options("whiting_jansen", true, "full"),
               {0.159, 0.690});
}

/// Between the two extremes, on a line from the node to the center of the cell; force along the axes and their average.
TEST(RadiusOfTheMesh, PositionsInTheCell) {
  const int n = 24;
  for (const std::array<double, 2> at : {std::array{0.0, 0.5}, {0.5, 0.0}, {0.25, 0.25}, {0.1, 0.35}}) {
    const ArrayDrag drag = array_drag(periodic_array(n, (n / 2 + at[0]) / n, (n / 2 + at[1]) / n), n);
    Lattice lattice;
    lattice.cells = n;
    std::copy(at.begin(), at.end(), lattice.position);
    row(log::format("radius of the mesh a/h, fiber at (%g, %g) h from a node", at[0], at[1]), symbol,
        lattice_radius(lattice), n * hasimoto_radius(drag.resistance), 1e-3);
    EXPECT_LT(drag.imbalance, 1e-8);
  }
}

/// 1/Z + 1/epsilon: a finite penalty subtracts 4 pi mu/epsilon from ln a across the fiber, 2 pi mu/epsilon along it.
TEST(RadiusOfTheMesh, Penalty) {
  const double pi = std::numbers::pi;
  for (const int n : {16, 17}) {
    Json across = array_cell(n), along = duct(n);
    const double a = n * hasimoto_radius(array_drag(across, n).resistance);
    CoupledCase stiff(along);
    const double axial = solve_for_force(stiff, 2.0 / n)[2];
    for (const double penalty : {5.0, 50.0}) {
      across["coupling"]["penalty"] = along["coupling"]["penalty"] = penalty;
      const double shift = std::log(n * hasimoto_radius(array_drag(across, n).resistance) / a);
      row(log::format("shift of ln a by penalty %g mu, across, fiber %s", penalty, place_of(n)), "-4 pi mu/epsilon",
          -4 * pi / penalty, shift, 1e-3, "0.2");
      CoupledCase run(along);
      const double weak = -solve_for_force(run, 2.0 / n)[2];
      row(log::format("shift of ln a by penalty %g mu, along, fiber %s", penalty, place_of(n)), "-2 pi mu/epsilon",
          -2 * pi / penalty, std::log(duct_radius(weak) / duct_radius(-axial)), 1e-3, "0.2");
    }
  }
}

}  // namespace
}  // namespace fbi::test
