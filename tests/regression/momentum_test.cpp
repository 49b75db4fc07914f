/// The momentum budget of SPEC section 6: what fluid and fibers gain is what boundaries and supports give.
#include "beam/generalized_alpha.hpp"
#include "case/force_outputs.hpp"
#include "record.hpp"
#include "regression/case_fixture.hpp"

namespace fbi::test {
namespace {

/// Integrals over the fluid of a nodal velocity field.
struct FluidIntegrals {
  Vec3 momentum = Vec3::Zero();    ///< rho int v
  Vec3 convection = Vec3::Zero();  ///< rho int (v.grad) v
};

/// By 3 x 3 x 3 Gauss points in every cell, from the shape functions alone: exact for trilinear fields on boxes.
FluidIntegrals integrate(const mesh::HexMesh& mesh, Vec vector, double density) {
  const double point[3] = {-std::sqrt(0.6), 0.0, std::sqrt(0.6)}, weight[3] = {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};
  const int sign[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                          {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
  FluidIntegrals sum;
  fluid::LocalArray u(vector);
  for (Index c = 0; c < mesh.local_cells(); ++c) {
    Eigen::Matrix<double, 3, 8> x, v;
    for (int a = 0; a < 8; ++a) {
      const Index node = mesh.cells[8 * static_cast<std::size_t>(c) + a];
      for (int i = 0; i < 3; ++i) {
        x(i, a) = mesh.node(node)[i];
        v(i, a) = u[4 * static_cast<std::size_t>(node) + i];
      }
    }
    for (int p = 0; p < 27; ++p) {
      const int at[3] = {p % 3, p / 3 % 3, p / 9};
      Eigen::Matrix<double, 8, 1> shape;
      Eigen::Matrix<double, 8, 3> slope;
      for (int a = 0; a < 8; ++a) {
        double factor[3];
        for (int d = 0; d < 3; ++d) factor[d] = 0.5 * (1 + sign[a][d] * point[at[d]]);
        shape[a] = factor[0] * factor[1] * factor[2];
        for (int d = 0; d < 3; ++d) slope(a, d) = 0.5 * sign[a][d] * factor[(d + 1) % 3] * factor[(d + 2) % 3];
      }
      const Mat3 jacobian = x * slope;
      const double volume = weight[at[0]] * weight[at[1]] * weight[at[2]] * jacobian.determinant();
      const Vec3 velocity = v * shape;
      const Mat3 gradient = v * slope * jacobian.inverse();
      sum.momentum += density * volume * velocity;
      sum.convection += density * volume * (gradient * velocity);
    }
  }
  mesh.comm.sum(sum.momentum.data(), 3);
  mesh.comm.sum(sum.convection.data(), 3);
  return sum;
}

/// -beta rho int min(v.n, 0) v over the face x = max by 2 x 2 Gauss points a face: the force that stays in the fluid's
/// equations where the flow comes in through the outlet.
Vec3 backflow(const mesh::HexMesh& mesh, Vec vector, double density, double beta) {
  Vec3 sum = Vec3::Zero();
  fluid::LocalArray u(vector);
  const int corner[4] = {1, 2, 6, 5};  // y, z = (-,-) (+,-) (+,+) (-,+)
  for (const mesh::HexMesh::LocalFace& face : mesh.faces.at("xmax")) {
    const Index* nodes = &mesh.cells[8 * static_cast<std::size_t>(face.cell)];
    const double area =
        (mesh.node(nodes[2])[1] - mesh.node(nodes[1])[1]) * (mesh.node(nodes[5])[2] - mesh.node(nodes[1])[2]);
    for (int q = 0; q < 4; ++q) {
      const double y = (q % 2 == 0 ? -1 : 1) / std::sqrt(3.0), z = (q / 2 == 0 ? -1 : 1) / std::sqrt(3.0);
      const double shape[4] = {0.25 * (1 - y) * (1 - z), 0.25 * (1 + y) * (1 - z), 0.25 * (1 + y) * (1 + z),
                               0.25 * (1 - y) * (1 + z)};
      Vec3 velocity = Vec3::Zero();
      for (int a = 0; a < 4; ++a)
        for (int i = 0; i < 3; ++i) velocity[i] += shape[a] * u[4 * static_cast<std::size_t>(nodes[corner[a]]) + i];
      sum -= beta * density * std::min(velocity[0], 0.0) * 0.25 * area * velocity;
    }
  }
  mesh.comm.sum(sum.data(), 3);
  return sum;
}

/// Sum over all nodes of a fluid vector's momentum rows, in given (Dirichlet) rows or in the others.
Vec3 sum_rows(CoupledCase& run, Vec vector, bool dirichlet) {
  Vec3 sum = Vec3::Zero();
  fluid::LocalArray r(vector);
  const std::vector<char>& given = run.fluid().is_dirichlet();
  for (Index a = 0; a < run.setup.fluid_mesh->owned_nodes; ++a)
    for (int i = 0; i < 3; ++i) {
      const std::size_t k = 4 * static_cast<std::size_t>(a) + i;
      if ((given[k] != 0) == dirichlet) sum[i] += r[k];
    }
  run.comm().sum(sum.data(), 3);
  return sum;
}

/// Largest errors over the steps, relative to the largest reaction of the step.
struct Budget {
  double fluid = 0.0, fibers = 0.0, total = 0.0;
  double convection = 0.0, backflow = 0.0, clamp = 0.0;  ///< the largest of these, relative as well
};

Budget run_budget(const Json& json, int steps) {
  CoupledCase run(json);
  fluid::FluidField& fluid = run.fluid();
  const mesh::HexMesh& mesh = *run.setup.fluid_mesh;
  const double density = fluid.parameters().density, dt = run.setup.dt;
  const beam::GeneralizedAlpha scheme(run.setup.parameters.beam_time.rho_inf);
  Budget budget;
  Vec3 fluid_rate_old = Vec3::Zero();  // of v'_n
  Vec3 earlier = Vec3::Zero();         // momentum of v_{n-1}
  for (int step = 0; step < steps; ++step) {
    const fsi::StepReport result = run.solve();
    EXPECT_TRUE(result.converged) << "step " << step + 1 << ", residual " << result.residual;
    if (!result.converged) break;
    fsi::System& system = run.system();
    const double theta = fluid.theta(), w = system.weight();

    const FluidIntegrals now = integrate(mesh, fluid.iterate(), density);
    const FluidIntegrals before = integrate(mesh, fluid.accepted(), density);
    // v' = (v_{n+1} - v_n)/(theta dt) - (1/theta - 1) v'_n; BDF2: (3 v_{n+1} - 4 v_n + v_{n-1})/(2 dt) after one step.
    const bool bdf2 = run.setup.parameters.fluid_time.scheme == fluid::TimeScheme::bdf2 && step > 0;
    const Vec3 fluid_rate =
        bdf2 ? Vec3((3 * now.momentum - 4 * before.momentum + earlier) / (2 * dt))
             : Vec3((now.momentum - before.momentum) / (theta * dt) - (1 / theta - 1) * fluid_rate_old);
    earlier = before.momentum;
    const Vec3 inflow = backflow(mesh, fluid.iterate(), density, 0.5);
    // What the boundary carries: rows of given velocities of the fluid's own residual, with the fibers' force.
    linalg::VecHandle reaction = fluid.create_vector();
    fluid.reactions(reaction);
    system.solver().add_spread(system.lambda(), reaction, true);
    const Vec3 boundary = sum_rows(run, reaction, true);

    // Fibers, at the generalised-alpha level.
    std::vector<double> rate = run.beams().acceleration();
    for (std::size_t k = 0; k < rate.size(); ++k)
      rate[k] = (1 - scheme.alpha_m) * rate[k] + scheme.alpha_m * run.beams().accepted_acceleration()[k];
    Vec3 fiber_rate = run.beams().linear_momentum(rate);
    run.comm().sum(fiber_rate.data(), 3);
    const std::vector<double> force = system.fiber_force(system.lambda());
    const Vec3 clamp = run.total(run.beams().reactions(force));
    std::vector<double> end_force(force.size(), 0.0);
    run.coupling().add_d_transposed(system.lambda().data(), end_force, 1.0);
    const Vec3 on_fibers = run.total(force), on_fibers_end = run.total(end_force);

    const double scale = std::max(boundary.cwiseAbs().maxCoeff(), clamp.cwiseAbs().maxCoeff());
    const auto raise = [scale](double& value, const Vec3& by) {
      value = std::max(value, by.cwiseAbs().maxCoeff() / scale);
    };
    raise(budget.fluid, fluid_rate + now.convection + inflow + on_fibers_end - boundary);
    raise(budget.fibers, fiber_rate - on_fibers - clamp);
    // With theta = w = 1 the two forces are one and leave the balance.
    if (theta == 1.0 && w == 1.0)
      raise(budget.total, fluid_rate + fiber_rate + now.convection + inflow - boundary - clamp);
    raise(budget.convection, now.convection);
    raise(budget.backflow, inflow);
    raise(budget.clamp, clamp);
    fluid_rate_old = fluid_rate;
    run.accept();
  }
  return budget;
}

void report_budget(const std::string& name, const Budget& budget) {
  const std::string total = budget.total > 0.0 ? log::format(", %.0e (both)", budget.total) : "";
  record({.section = "Coupling",
          .check = "momentum budget, " + name + ", 20 steps, of the largest reaction",
          .source = "balance of reactions",
          .reference = 0.0,
          .ours_text = log::format("%.0e (fluid), %.0e (fibers)", budget.fluid, budget.fibers) + total,
          .bar = "1e-8"});
  report(name + " budget error, fluid", budget.fluid);
  report(name + " budget error, fibers", budget.fibers);
  report(name + " budget error, total", budget.total);
  report(name + " largest convection", budget.convection);
  report(name + " largest backflow", budget.backflow);
  report(name + " largest clamp reaction", budget.clamp);
}

TEST(Momentum, single_beam_20_steps) {
  Json json = single_beam();
  tighten(json, 1e-10, 1e-5);
  const Budget budget = run_budget(json, 20);
  report_budget("single-beam", budget);
  EXPECT_LE(budget.fluid, 1e-8);
  EXPECT_LE(budget.fibers, 1e-8);
  EXPECT_LE(budget.total, 1e-8);
}

// The inflow reverses within the run, so that the outlet takes in fluid.
TEST(Momentum, reversing_flow) {
  Json json = small_beam(R"({ "time": { "step": 1e-3, "end": 0.02 } })");
  set_inflow(json, 20.0, 0.01);
  tighten(json, 1e-11, 1e-6);
  const Budget budget = run_budget(json, 20);
  report_budget("reversing", budget);
  EXPECT_LE(budget.total, 1e-8);
  EXPECT_GT(budget.convection, 1e-3);
  EXPECT_GT(budget.backflow, 1e-4);
  EXPECT_GT(budget.clamp, 1e-4);
}

// theta = 1/2: fluid and fibers each balance with the force that enters their own equation.
TEST(Momentum, trapezoidal_rule) {
  Json json =
      small_beam(R"({ "time": { "step": 1e-3, "end": 0.02, "fluid": { "theta": 0.5 }, "beam": { "rho_inf": 0.8 } } })");
  set_inflow(json, 20.0, 0.01);
  tighten(json, 1e-11, 1e-6);
  const Budget budget = run_budget(json, 20);
  report_budget("trapezoidal", budget);
  EXPECT_LE(budget.fluid, 1e-8);
  EXPECT_LE(budget.fibers, 1e-8);
}

TEST(Momentum, bdf2) {
  Json json = small_beam(R"({ "time": { "step": 1e-3, "end": 0.02, "fluid": { "scheme": "bdf2" } } })");
  json["time"]["fluid"].erase("theta");
  set_inflow(json, 20.0, 0.01);
  tighten(json, 1e-11, 1e-6);
  const Budget budget = run_budget(json, 20);
  report_budget("bdf2", budget);
  EXPECT_LE(budget.fluid, 1e-8);
  EXPECT_LE(budget.fibers, 1e-8);
  EXPECT_LE(budget.total, 1e-8);
  record({.section = "Coupling",
          .check = "momentum budget of fluid and fiber with bdf2, reversing flow, 20 steps",
          .source = "identity",
          .reference = 0,
          .ours = budget.total,
          .bar = "1e-8"});
}

// A post and an arm with shear and torsion, jointed, and a torsion-free thread on the arm.
TEST(Momentum, jointed_fibers_of_both_formulations) {
  Json json = small_beam(R"({ "time": { "step": 1e-3, "end": 0.02 } })");
  set_inflow(json, 20.0, 0.01);
  tighten(json, 1e-11, 1e-6);
  Json post = json["fibers"][0];
  post["name"] = "post";
  post["formulation"] = "simo_reissner";
  post["section"] = {{"radius", 5.6419e-3}};
  post["material"]["poisson"] = 0.3;
  const auto line = [](double x0, double y0, double x1, double y1) {
    return Json{{"type", "line"}, {"from", {x0, y0, 0.031}}, {"to", {x1, y1, 0.031}}};
  };
  post["curve"] = line(1.41, 0, 1.41, 0.4);
  Json arm = post, thread = json["fibers"][0];
  arm["name"] = "arm";
  arm["curve"] = line(1.41, 0.4, 1.61, 0.45);
  thread["name"] = "thread";
  thread["curve"] = line(1.61, 0.45, 1.61, 0.2);
  arm.erase("clamped");
  thread.erase("clamped");
  json["fibers"] = Json::array({post, arm, thread});
  json["joints"] =
      Json::array({Json{{"a", "post"}, {"b", "arm"}, {"type", "rigid"}}, Json{{"a", "arm"}, {"b", "thread"}}});
  const Budget budget = run_budget(json, 20);
  report_budget("jointed fibers of both formulations", budget);
  EXPECT_LE(budget.fluid, 1e-8);
  EXPECT_LE(budget.fibers, 1e-8);
  EXPECT_LE(budget.total, 1e-8);
  EXPECT_GT(budget.clamp, 1e-4);
}

// A fiber clamped at a floor that holds the fluid: its force enters the balance of floor nodes too. Forces on all faces
// and on the fiber are what the fluid loses.
TEST(Momentum, forces_on_faces_and_fiber) {
  Json json = small_beam(R"({ "time": { "step": 1e-3, "end": 0.02 },
                              "channel": { "boundaries": { "ymin": { "type": "no_slip" } } } })");
  set_inflow(json, 20.0, 0.01);
  tighten(json, 1e-11, 1e-6);
  json["output"]["forces"] = parse_json(R"([
    { "name": "floor", "faces": ["ymin"] },
    { "name": "others", "faces": ["xmin", "xmax", "ymax", "zmin", "zmax"] },
    { "name": "all", "faces": ["xmin", "xmax", "ymin", "ymax", "zmin", "zmax"] } ])");
  CoupledCase run(json);
  const cases::ForceOutputs outputs(run.setup.parameters.output.forces, &run.fluid());
  const double density = run.fluid().parameters().density, dt = run.setup.dt;
  double budget = 0.0, sum = 0.0, fiber_share = 0.0;
  for (int step = 0; step < 20; ++step) {
    ASSERT_TRUE(run.solve().converged);
    const FluidIntegrals now = integrate(*run.setup.fluid_mesh, run.fluid().iterate(), density);
    const FluidIntegrals before = integrate(*run.setup.fluid_mesh, run.fluid().accepted(), density);
    run.accept();
    const std::vector<double> values = outputs.values(run.system());
    ASSERT_EQ(values.size(), 9U);
    const Vec3 floor(values.data()), others(&values[3]), all(&values[6]), drag = run.drag();
    const linalg::VecHandle spread = run.fluid().create_vector();
    run.system().solver().add_spread(run.system().lambda_old(), spread, true);
    const double scale = std::max({floor.norm(), others.norm(), drag.norm()});
    budget = std::max(budget, ((now.momentum - before.momentum) / dt + now.convection + all + drag).norm() / scale);
    sum = std::max(sum, (floor + others - all).norm() / scale);
    fiber_share = std::max(fiber_share, sum_rows(run, spread, true).norm() / scale);
  }
  report("forces: budget error", budget);
  report("forces: largest force of the fiber in rows of given velocity", fiber_share);
  EXPECT_LE(budget, 1e-8);
  EXPECT_LE(sum, 1e-12);
  EXPECT_GT(fiber_share, 1e-4);  // the balance would miss it
  record({.section = "Coupling",
          .id = "",
          .check = "forces on all faces and on a fiber clamped at one of them = loss of momentum of the fluid",
          .source = "identity",
          .error = budget,
          .bar = "1e-8"});
}

}  // namespace
}  // namespace fbi::test
