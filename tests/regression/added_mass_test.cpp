/// The fluid that a fiber on a mesh carries along when it is set in motion: force of the first small time step.
#include "regression/straight_fibers.hpp"

namespace fbi::test {
namespace {

constexpr const char* symbol = "the discrete equations on a lattice, mode by mode";
constexpr double sigma = 1e6;  // rho h^2/(mu dt)

/// Force of the first step times dt over rho h^2 U, for a fiber that is set in motion at U along x or z.
double added_mass(int n, bool along, const Json& changes) {
  const double h = 1.0 / n, dt = h * h / sigma, depth = 2 * h;
  Json json = periodic_array(n, 0.5, 0.5);
  json["fluid"]["density"] = 1.0;
  json["fluid"].erase("body_force");
  json["fibers"][0]["formulation"] = "prescribed";
  json["fibers"][0]["motion"] = {along ? "0" : log::format("%.17g*t", h), "0", along ? log::format("%.17g*t", h) : "0"};
  json["coupling"]["penalty"] = 1e4 * sigma;
  json["time"] = {{"step", dt}, {"end", dt}, {"fluid", {{"scheme", "one_step_theta"}}}};
  json["solver"]["linear"] = "direct";
  if (along)
    for (const char* face : {"zmin", "zmax"})
      json["channel"]["boundaries"][face] = parse_json(R"({ "type": "mixed", "velocity": ["0", "0", null] })");
  json.merge_patch(changes);
  CoupledCase run(json);
  run.step();
  return -run.drag()[along ? 2 : 0] / depth * dt / (h * h * h);
}

Json fluid(const char* text) {
  Json json;
  json["fluid"] = parse_json(text);
  return json;
}

struct Choice {
  const char* name;
  Json changes;
  double tau, tau_c = 0.0;
  bool projection = false;
};

TEST(AddedMass, OfTheFirstStep) {
  const std::vector<Choice> choices = {
      {"franca_valentin", fluid(R"({ "tau_time": true })"), 1 / (sigma + 12)},
      {"franca_valentin without time step", fluid("{}"), 1.0 / 12},
      {"whiting_jansen", fluid(R"({ "tau": "whiting_jansen", "tau_time": true })"), 0.5 / sigma},
      {"whiting_jansen with grad-div", fluid(R"({ "tau": "whiting_jansen", "tau_time": true, "grad_div": true })"),
       0.5 / sigma, sigma / 6},
      {"pressure projection", fluid(R"({ "pressure_stabilization": "projection" })"), 0.0, 0.0, true}};
  for (const int n : {16, 17})
    for (const Choice& choice : choices) {
      Json changes = choice.changes;
      if (choice.projection) {
        for (const char* key : {"viscous_residual", "tau", "tau_time"}) changes["fluid"][key] = nullptr;
      }
      const double ours = added_mass(n, false, changes);
      Lattice lattice;
      lattice.cells = n;
      lattice.position[0] = lattice.position[1] = n % 2 == 0 ? 0.0 : 0.5;
      lattice.tau = choice.tau;
      lattice.tau_c = choice.tau_c;
      lattice.sigma = sigma;
      lattice.projection = choice.projection;
      const double reference = 1 / (sigma * lattice_velocity(lattice)[0]);
      const std::string check =
          log::format("added mass of the first small step over rho h^2, %s, fiber %s", choice.name, place_of(n));
      check_number("0.4", check, symbol, reference, ours, 5e-3);
      if (choice.name != std::string("whiting_jansen")) continue;
      check_number("0.4", check, "computed independently", n % 2 == 0 ? 0.38 : 3.1, ours, 0.015);
    }
}

TEST(AddedMass, AlongTheFiber) {
  for (const int n : {16, 17}) {
    Lattice lattice;
    lattice.cells = n;
    lattice.position[0] = lattice.position[1] = n % 2 == 0 ? 0.0 : 0.5;
    lattice.sigma = sigma;
    const double ours = added_mass(n, true, fluid("{}")), reference = 1 / (sigma * lattice_velocity(lattice)[1]);
    const std::string check = log::format("the same along the fiber, %s", place_of(n));
    check_number("0.4", check, symbol, reference, ours, 5e-3);
  }
}

}  // namespace
}  // namespace fbi::test
