/// Identities of the coupling that hold in every step to round-off (SPEC section 6).
#include "record.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

/// Largest errors over the steps, each relative to the largest term in it.
struct Identities {
  double m_one = 0.0;          ///< M.1 - kappa, relative to the largest kappa
  double d_one = 0.0;          ///< D.1 - kappa
  double monitor = 0.0;        ///< the same as the running program reports it
  double length = 0.0;         ///< covered length - fiber length
  double force = 0.0;          ///< force on fluid + force on fibers, relative to the force
  double work = 0.0;           ///< power of the fluid - power of the fibers - dissipation, relative to the largest
  double dissipation = 1e300;  ///< the smallest
};

double dot(const Comm& comm, const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return comm.sum(sum);
}

void check_step(CoupledCase& run, double fiber_length, Identities& worst) {
  const Comm& comm = run.comm();
  fsi::System& system = run.system();
  const coupling::Coupling& coupling = run.coupling();
  const std::size_t rows = coupling.rows();
  const mesh::HexMesh& mesh = *run.setup.fluid_mesh;
  const auto raise = [&comm](double& value, double by) { value = std::max(value, comm.max(std::abs(by))); };

  const std::vector<double> ones(4 * static_cast<std::size_t>(mesh.local_nodes()), 1.0);
  std::vector<double> m_one(3 * rows), d_one(3 * rows), unit(6 * static_cast<std::size_t>(run.fibers().nodes()), 0.0);
  coupling.interpolate(ones.data(), m_one.data());
  for (std::size_t k = 0; k < unit.size(); ++k) unit[k] = k % 6 < 3 ? 1.0 : 0.0;
  coupling.apply_d(unit, d_one.data());
  double largest = 0.0;
  for (const double kappa : coupling.kappa()) largest = std::max(largest, kappa);
  largest = comm.max(largest);
  double m_error = 0.0, d_error = 0.0;
  for (std::size_t k = 0; k < 3 * rows; ++k) {
    m_error = std::max(m_error, std::abs(m_one[k] - coupling.kappa()[k / 3]));
    d_error = std::max(d_error, std::abs(d_one[k] - coupling.kappa()[k / 3]));
  }
  raise(worst.m_one, m_error / largest);
  raise(worst.d_one, d_error / largest);
  raise(worst.monitor, coupling.coverage().identity_error);
  raise(worst.length, (coupling.coverage().covered - fiber_length) / fiber_length);

  // Forces: M^T lambda summed over all fluid nodes, D^T lambda over all fiber nodes.
  const std::vector<double>& lambda = system.lambda();
  linalg::VecHandle spread = run.fluid().create_vector();
  system.solver().add_spread(lambda, spread, true);
  std::vector<double> on_fibers(unit.size(), 0.0);
  coupling.add_d_transposed(lambda.data(), on_fibers, 1.0);
  Vec3 on_fluid = Vec3::Zero();
  double fluid_power = 0.0;
  {
    fluid::LocalArray force(spread), u(run.fluid().iterate());
    for (Index a = 0; a < mesh.owned_nodes; ++a)
      for (int i = 0; i < 3; ++i) {
        const std::size_t k = 4 * static_cast<std::size_t>(a) + i;
        on_fluid[i] -= force[k];
        fluid_power += force[k] * u[k];
      }
  }
  comm.sum(on_fluid.data(), 3);
  const Vec3 sum = run.total(on_fibers) + on_fluid;
  raise(worst.force, sum.cwiseAbs().maxCoeff() / on_fluid.cwiseAbs().maxCoeff());

  // What the fluid loses is what the fibers gain and what the penalty dissipates, int eps |slip|^2 by rows.
  fluid_power = comm.sum(fluid_power);
  const double fiber_power = dot(comm, on_fibers, run.beams().velocity());
  const std::vector<double> slip = system.slip();
  const double penalty = system.coupling_parameters().penalty;
  double dissipation = 0.0;
  std::vector<double> law(3 * rows);
  system.interface().apply_law(lambda.data(), law.data());
  for (std::size_t k = 0; k < 3 * rows; ++k) {
    const double kappa = coupling.kappa()[k / 3];
    if (coupling.needs_stabilization())
      dissipation += lambda[k] * law[k];
    else if (kappa > 0.0)
      dissipation += penalty * slip[k] * slip[k] / kappa;
  }
  dissipation = comm.sum(dissipation);
  const double scale = std::max({std::abs(fluid_power), std::abs(fiber_power), dissipation});
  raise(worst.work, (fluid_power - fiber_power - dissipation) / scale);
  worst.dissipation = std::min(worst.dissipation, dissipation);
}

void check_run(const std::string& name, Json json, int steps) {
  set_inflow(json, 20.0, 0.01);
  CoupledCase run(json);
  Identities worst;
  for (int step = 0; step < steps; ++step) {
    EXPECT_TRUE(run.solve().converged);
    check_step(run, 0.5, worst);
    run.accept();
  }
  report(name + " M.1 - kappa", worst.m_one);
  report(name + " D.1 - kappa", worst.d_one);
  report(name + " covered length", worst.length);
  report(name + " sum of forces", worst.force);
  report(name + " work balance", worst.work);
  report(name + " smallest dissipation", worst.dissipation);
  report(name + " tip", run.tip().norm());
  record({.section = "Coupling",
          .check = "M 1 = kappa, D 1 = kappa, covered length, sum of forces along a run, " + name,
          .source = "identities",
          .reference = 0.0,
          .ours = std::max({worst.m_one, worst.d_one, worst.length, worst.force}),
          .bar = "1e-12"});
  record({.section = "Coupling",
          .check = "power: what the fluid loses is what the fibers gain and the penalty dissipates, " + name,
          .source = "balance",
          .reference = 0.0,
          .ours = worst.work,
          .bar = "1e-10"});
  EXPECT_LE(worst.m_one, 1e-12);
  EXPECT_LE(worst.d_one, 1e-12);
  EXPECT_LE(worst.monitor, 1e-12);
  EXPECT_GE(worst.monitor, 0.1 * std::max(worst.m_one, worst.d_one));
  EXPECT_LE(worst.length, 1e-12);
  EXPECT_LE(worst.force, 1e-12);
  EXPECT_LE(worst.work, 1e-10);
  EXPECT_GE(worst.dissipation, 0.0);
}

const char* const long_steps = R"({ "time": { "step": 1e-3, "end": 0.02 } })";

TEST(Identities, monolithic_lagged) { check_run("lagged", small_beam(long_steps), 15); }
TEST(Identities, every_basis) {
  for (const char* basis : {"quadratic", "cubic", "gauss_point"}) {
    Json json = small_beam(long_steps);
    json["coupling"]["multiplier"] = basis;
    check_run(std::string("multiplier ") + basis, json, 6);
  }
}
TEST(Identities, integration_by_element) {
  Json json = small_beam(long_steps);
  json["coupling"]["integration"] = "element";
  check_run("integration element", json, 6);
}
TEST(Identities, ring_with_a_number) {
  Json json = small_beam(long_steps);
  json["coupling"]["operator"] = "ring";
  check_run("ring", json, 6);
}
TEST(Identities, ring_that_keeps_the_radius) {
  for (const char* basis : {"linear", "gauss_point"}) {
    Json json = small_beam(long_steps);
    json["coupling"]["operator"] = "ring";
    json["coupling"]["penalty"] = "auto";
    json["coupling"]["multiplier"] = basis;
    json["coupling"]["geometry_update"] = "iterated";
    tighten(json, 1e-11);
    check_run(std::string("ring, auto, ") + basis, json, 6);
  }
}
TEST(Identities, trapezoidal_rule) {
  Json json = small_beam(long_steps);
  json["time"]["fluid"]["theta"] = 0.5;
  check_run("theta 1/2", json, 15);
}
TEST(Identities, monolithic_iterated) {
  Json json = small_beam(long_steps);
  json["coupling"]["geometry_update"] = "iterated";
  tighten(json, 1e-12);
  check_run("iterated", json, 15);
}
TEST(Identities, aitken) {
  Json json = small_beam(long_steps);
  json["coupling"]["scheme"] = "aitken";
  check_run("aitken", json, 5);
}

}  // namespace
}  // namespace fbi::test
