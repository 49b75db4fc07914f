// Options of the equations: tangents of every combination, tau against its formulas, pressure projection, energy.
#include <gtest/gtest.h>

#include "fem/hex8.hpp"
#include "fluid/operator.hpp"
#include "fluid_scene.hpp"
#include "record.hpp"

namespace fbi::fluid::test {
namespace {

const ConvectiveForm forms[] = {ConvectiveForm::advective, ConvectiveForm::conservative, ConvectiveForm::skew,
                                ConvectiveForm::none};
const Tau taus[] = {Tau::franca_valentin, Tau::whiting_jansen, Tau::taylor_hughes_zarins};

TEST(FluidOptions, TangentOfEveryCombinationMatchesDifferences) {
  linalg::initialize_petsc();
  static FluidParameters options;  // read by the setter below, which has no captures
  double worst = 0;
  int count = 0;
  for (const double warp : {0.0, 0.2})
    for (const TimeScheme scheme : {TimeScheme::one_step_theta, TimeScheme::steady})
      for (const ConvectiveForm form : forms)
        for (const ViscousResidual viscous : {ViscousResidual::full, ViscousResidual::none})
          for (const Tau tau : taus)
            for (const TauAt at : {TauAt::center, TauAt::quadrature_points})
              for (const PressureStabilization pressure :
                   {PressureStabilization::pspg, PressureStabilization::projection}) {
                options.tau = tau;
                options.tau_at = at;
                options.pressure_stabilization = pressure;
                options.tau_time = count % 2 == 0;
                options.grad_div = count % 3 != 0;
                Option option = {"", warp, form, viscous, scheme, scheme == TimeScheme::steady ? 1.0 : 0.7};
                option.more = [](FluidParameters& p) {
                  p.tau = options.tau;
                  p.tau_at = options.tau_at;
                  p.pressure_stabilization = options.pressure_stabilization;
                  p.tau_time = options.tau_time;
                  p.grad_div = options.grad_div;
                };
                Scene scene(Comm(MPI_COMM_WORLD), option);
                const double error = tangent_error(scene, ++count);
                worst = std::max(worst, error);
                EXPECT_LT(error, 1e-6) << "warp " << warp << " form " << static_cast<int>(form) << " tau "
                                       << static_cast<int>(tau) << " at " << static_cast<int>(at) << " pressure "
                                       << static_cast<int>(pressure) << " viscous " << static_cast<int>(viscous);
              }
  std::printf("tangent against differences, %d combinations: at most %.1e\n", count, worst);
  fbi::test::record({.section = "Fluid",
                     .id = "",
                     .check = "tangent against central differences of the residual, all combinations of convective "
                              "form, viscous residual, tau, place of tau and pressure stabilisation",
                     .source = "identity",
                     .reference = 0.0,
                     .ours = worst,
                     .error = worst,
                     .bar = "< 1e-6"});
}

// tau of every iterate: the equations are those of a field that took its tau from this state in the first place.
TEST(FluidOptions, TauOfTheIterationIsTauOfTheIterate) {
  linalg::initialize_petsc();
  for (const TauAt at : {TauAt::center, TauAt::quadrature_points}) {
    static FluidParameters options;
    options.tau_at = at;
    Option option = {"", 0.1, ConvectiveForm::advective, ViscousResidual::full, TimeScheme::steady, 1.0};
    option.more = [](FluidParameters& p) { p.tau_at = options.tau_at; };
    Option iterated = option;
    iterated.more = [](FluidParameters& p) {
      p.tau_at = options.tau_at;
      p.tau_update = TauUpdate::iteration;
    };
    Scene one(Comm(MPI_COMM_WORLD), option), two(Comm(MPI_COMM_WORLD), iterated);
    linalg::VecHandle r = one.field.create_vector(), s = two.field.create_vector(), x = one.field.create_vector();
    one.field.residual(r);
    two.field.residual(s);
    const double scale = largest(r);
    FBI_PETSC(VecAXPY(s, -1, r));
    EXPECT_GT(largest(s), 1e-4 * scale);  // tau of the step is another one
    one.field.accept_step();
    one.field.begin_step(0.05, 0);  // takes tau from the accepted state
    one.field.linearize();
    one.field.residual(r);
    two.field.residual(s);
    FBI_PETSC(VecAXPY(s, -1, r));
    EXPECT_LT(largest(s), 1e-13 * scale);
    EXPECT_EQ(one.field.tau_m(), two.field.tau_m());
    fill(one.mesh, x, [](GlobalIndex node, int c) { return noise(node, c, 11); });
    one.field.apply_jacobian(x, r);
    two.field.apply_jacobian(x, s);
    const double size = largest(r);
    FBI_PETSC(VecAXPY(s, -1, r));
    EXPECT_LT(largest(s), 1e-13 * size);
  }
}

double steady_tau(Tau tau, TauAt at, double h, double viscosity, double density) {
  const mesh::HexMesh mesh =
      box_mesh(Comm(MPI_COMM_WORLD), {uniform(0, 3 * h, 3), uniform(0, 3 * h, 3), uniform(0, 3 * h, 3)});
  FluidParameters p;
  p.density = density;
  p.viscosity = viscosity;
  p.convective_form = ConvectiveForm::none;
  p.tau = tau;
  p.tau_at = at;
  BoundaryConditions conditions;
  conditions["xmin"] = of_type(BoundaryType::no_slip);
  FluidField field(mesh, p, conditions, {TimeScheme::steady, 1.0});
  field.initialize();
  field.begin_step(0, 0);
  for (const double value : field.tau_m()) EXPECT_NEAR(value, field.tau_m()[0], 1e-14 * value);
  const double expected_c =
      tau == Tau::whiting_jansen ? 1 / (field.tau_m()[0] * 12 / (h * h)) : 0.0;  // no velocity: the others have none
  EXPECT_NEAR(field.tau_c(0), expected_c, 1e-14 * expected_c);
  return field.tau_m()[0];
}

// The columns of the table of hydrodynamic radii: rho tau_M = h^2/(12 nu) and h^2/(sqrt(36 48) nu), tau_C = 3.464 mu.
TEST(FluidOptions, SteadyTauOnACube) {
  linalg::initialize_petsc();
  const double h = 0.3, viscosity = 0.7, density = 2.5;
  for (const TauAt at : {TauAt::center, TauAt::quadrature_points}) {
    EXPECT_NEAR(steady_tau(Tau::franca_valentin, at, h, viscosity, density) * viscosity / (h * h), 1.0 / 12, 1e-15);
    EXPECT_NEAR(steady_tau(Tau::whiting_jansen, at, h, viscosity, density) * viscosity / (h * h), 1 / std::sqrt(1728),
                1e-15);
    EXPECT_NEAR(steady_tau(Tau::taylor_hughes_zarins, at, h, viscosity, density) * viscosity / (h * h),
                1 / std::sqrt(1728), 1e-15);
  }
  const double ours = h * h / (viscosity * steady_tau(Tau::whiting_jansen, TauAt::center, h, viscosity, density));
  fbi::test::record({.section = "Fluid",
                     .id = "",
                     .check = "whiting_jansen, steady Stokes on cubes: h^2/(nu rho tau_M)",
                     .source = "definition, sqrt(36 * 48)",
                     .reference = std::sqrt(1728),
                     .ours = ours,
                     .bar = "< 1e-15"});
}

TEST(FluidOptions, LimitsOfTheMetricTau) {
  const double h = 0.2, rho = 2, mu = 1e-9;
  const double k[9] = {2 / h, 0, 0, 0, 2 / h, 0, 0, 0, 2 / h}, v[3] = {3, 0, 0};
  const Metric metric = cell_metric(k, v);
  EXPECT_NEAR(metric.advection, 4 * 9 / (h * h), 1e-10);
  EXPECT_NEAR(metric.square, 48 / (h * h * h * h), 1e-10);
  EXPECT_NEAR(metric.trace, 12 / (h * h), 1e-10);
  // convection: h/(2 rho |v|), tau_C = 2 rho |v| h/12 (both agree there)
  EXPECT_NEAR(whiting_jansen(rho, mu, 0, metric).convection, h / (2 * rho * 3), 1e-12);
  EXPECT_NEAR(whiting_jansen(rho, mu, 0, metric).divergence, rho * 3 * h / 6, 1e-9);
  EXPECT_NEAR(taylor_hughes_zarins(rho, mu, 0, metric).divergence, rho * 3 * h / 6, 1e-12);
  // small time steps: dt/(2 rho)
  EXPECT_NEAR(whiting_jansen(rho, mu, 2 / 1e-9, metric).pressure, 1e-9 / (2 * rho), 1e-20);
  // the projection: 1/mu, and 6/(rho |v| h) in fast flow
  EXPECT_DOUBLE_EQ(projection_coefficient(2, 0.5, 0.1, h), 2.0);
  EXPECT_DOUBLE_EQ(projection_coefficient(2, 0.01, 3, h), 6 / (2 * 3 * h));
}

// At the points of a box, in flow along an axis, the length of a cell is what it is at the center.
TEST(FluidOptions, TauAtThePointsOfUniformFlowIsTauAtTheCenter) {
  const double k[9] = {2 / 0.1, 0, 0, 0, 2 / 0.2, 0, 0, 0, 2 / 0.4};
  const double x[3] = {1, 0, 0}, d[3] = {0.6, 0, 0.8}, center[3] = {0, 0, 0}, point[3] = {0.57, -0.57, 0.57};
  EXPECT_DOUBLE_EQ(streamline_length(k, x, point), 0.1);
  EXPECT_DOUBLE_EQ(streamline_length(k, d, center), streamline_length(k, d));
}

/// Sum over the mesh of a . R for nodal arrays, on one rank.
struct Cells {
  mesh::HexMesh mesh;
  std::vector<double> u, rest, r;
  Cells(double warp, const std::function<std::array<double, 4>(const Vec3&)>& field)
      : mesh(box_mesh(Comm(MPI_COMM_SELF), {uniform(0, 1, 4), graded(0, 1, 3, 1.3), uniform(0, 2, 5)}, false, warp)) {
    for (Index n = 0; n < mesh.local_nodes(); ++n) {
      const std::array<double, 4> value = field(Eigen::Map<const Vec3>(mesh.node(n)));
      u.insert(u.end(), value.begin(), value.end());
    }
    rest.assign(u.size(), 0.0);
  }
  double power(const Operator& cells) {
    r.assign(u.size(), 0.0);
    cells.add_residual(u.data(), rest.data(), r.data());
    double sum = 0;
    for (std::size_t k = 0; k < u.size(); ++k) sum += u[k] * r[k];
    return sum;
  }
};

// int (p - Pi p)^2 / mu of a linear pressure is V (sum_i (h_i dp/dx_i)^2)/(12 mu); a constant gives nothing.
TEST(FluidOptions, PressureProjectionOfALinearPressure) {
  linalg::initialize_petsc();
  FluidParameters p;
  p.viscosity = 0.25;
  p.convective_form = ConvectiveForm::none;
  p.pressure_stabilization = PressureStabilization::projection;
  Cells scene(0, [](const Vec3& x) { return std::array<double, 4>{0, 0, 0, 7 + 2 * x[0] + 3 * x[1] - x[2]}; });
  Operator cells(scene.mesh, p);
  cells.update_tau(scene.u.data(), 0);
  const double power = scene.power(cells);
  double expected = 0;
  const std::vector<double> y = graded(0, 1, 3, 1.3);
  for (int j = 0; j < 3; ++j) {
    const double h = y[j + 1] - y[j];
    expected += h * 2 * (std::pow(2 * 0.25, 2) + std::pow(3 * h, 2) + std::pow(0.4, 2)) / (12 * p.viscosity);
  }
  EXPECT_NEAR(power, expected, 1e-13 * expected);
  Cells constant(0.1, [](const Vec3&) { return std::array<double, 4>{0, 0, 0, 7}; });
  Operator warped(constant.mesh, p);
  warped.update_tau(constant.u.data(), 0);
  constant.power(warped);
  for (std::size_t k = 3; k < constant.r.size(); k += 4) EXPECT_NEAR(constant.r[k], 0, 1e-14);
}

// Without normal velocity at the boundary, int v . (rho (v.grad) v + 1/2 rho v div v) = 0 for any discrete velocity;
// on boxes the integrals are exact. tau = 0 here, so that the convective term of the weak form is all there is.
TEST(FluidOptions, SkewConvectionMakesNoEnergy) {
  linalg::initialize_petsc();
  const auto rough = [](const Vec3& x) {
    const auto inside = [](double s) { return s < 1e-12 || s > 1 - 1e-12 ? 0.0 : 1.0; };
    const auto random = [&](int c) {
      return noise(static_cast<GlobalIndex>(std::lround(1e3 * x[0] + 1e5 * x[1] + 1e7 * x[2])), c, 1);
    };
    return std::array<double, 4>{inside(x[0]) * random(0), inside(x[1]) * random(1), inside(x[2] / 2) * random(2), 0};
  };
  Cells scene(0, rough);
  FluidParameters p;
  p.viscosity = 1e-300;
  const auto power = [&](ConvectiveForm form) {
    p.convective_form = form;
    return scene.power(Operator(scene.mesh, p));
  };
  const double advective = power(ConvectiveForm::advective), conservative = power(ConvectiveForm::conservative);
  EXPECT_GT(std::abs(advective), 1e-3);
  EXPECT_NEAR(conservative, -advective, 1e-14);
  const double skew = power(ConvectiveForm::skew);
  EXPECT_NEAR(skew, 0, 1e-15);
  std::printf("power of convection in a rough field: advective %.3e, conservative %.3e, skew %.1e\n", advective,
              conservative, skew);
  fbi::test::record({.section = "Fluid",
                     .id = "",
                     .check = "power of skew convection in a rough velocity field, relative to advective",
                     .source = "identity",
                     .reference = 0.0,
                     .ours = skew / std::abs(advective),
                     .error = std::abs(skew / advective),
                     .bar = "< 1e-12"});
}

// Conservative form: the momentum rows sum to what flows through the boundary, here nothing.
TEST(FluidOptions, ConservativeConvectionSumsToTheBoundaryFlux) {
  linalg::initialize_petsc();
  Cells scene(0.1, [](const Vec3& x) {
    const double bubble = x[0] * (1 - x[0]) * x[1] * (1 - x[1]) * x[2] * (2 - x[2]);
    return std::array<double, 4>{bubble * (1 + x[1]), bubble * x[2], bubble * (2 - x[0]), 0};
  });
  FluidParameters p;
  for (const ConvectiveForm form : {ConvectiveForm::conservative, ConvectiveForm::advective}) {
    p.convective_form = form;
    scene.power(Operator(scene.mesh, p));
    Vec3 sum = Vec3::Zero();
    for (std::size_t k = 0; k < scene.r.size(); k += 4)
      for (int i = 0; i < 3; ++i) sum[i] += scene.r[k + i];
    if (form == ConvectiveForm::conservative)
      EXPECT_LT(sum.norm(), 1e-15);
    else
      EXPECT_GT(sum.norm(), 1e-6);
  }
}

}  // namespace
}  // namespace fbi::fluid::test
