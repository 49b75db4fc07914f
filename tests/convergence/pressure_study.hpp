/// Ethier and Steinman's flow with any viscosity on a fixed mesh, started from the nodal values of the exact velocity,
/// which is not divergence-free for the discrete equations: what small time steps do to the pressure.
#pragma once

#include <gtest/gtest.h>

#include "convergence/ethier_steinman.hpp"

namespace fbi::fluid::test {

/// One way to stabilise the pressure.
struct Method {
  const char* name;
  void (*set)(FluidParameters&);
};

inline const Method methods[] = {
    {"pspg", [](FluidParameters&) {}},
    {"pspg-tau-time-off", [](FluidParameters& p) { p.tau_time = false; }},
    {"projection", [](FluidParameters& p) { p.pressure_stabilization = PressureStabilization::projection; }},
    {"whiting-jansen", [](FluidParameters& p) { p.tau = Tau::whiting_jansen; }},
};

struct PressureErrors {
  double velocity;   ///< L2 error of the velocity, relative
  double pressure;   ///< L2 error of the pressure, relative to its deviation from the mean
  double roughness;  ///< |p - Pi p| over the same of the exact pressure's nodal values, Pi the mean of each cell
};

/// The exact solution with kinematic viscosity nu is that of nu = 1 at time nu t, as its decay is exp(-nu d^2 t).
class PressureStudy {
 public:
  PressureStudy(int cells, double viscosity, const Method& method)
      : viscosity_(viscosity),
        mesh_(box_mesh(Comm(MPI_COMM_SELF), {uniform(-1, 1, cells), uniform(-1, 1, cells), uniform(-1, 1, cells)})),
        parameters_(parameters(viscosity, method)) {}

  /// mu dt/(rho h^2) of a step.
  double number(double dt) const {
    return viscosity_ * dt * std::pow(static_cast<double>(mesh_.global_cells), 2.0 / 3) / 4;
  }

  /// Errors after each of the given numbers of steps (ascending), implicit Euler; before them `lead` steps of size
  /// `lead_step`.
  std::vector<PressureErrors> run(double dt, const std::vector<int>& steps, int lead = 0, double lead_step = 0) const {
    FluidField field(mesh_, parameters_, boundaries(viscosity_), {TimeScheme::one_step_theta, 1.0});
    field.initialize();
    StepSolver solver(field);
    const auto step = [&](double time, double size) {
      field.begin_step(time, size);
      solver.solve(1e-7);
    };
    for (int n = 1; n <= lead; ++n) {
      step(n * lead_step, lead_step);
      field.accept_step();
    }
    std::vector<PressureErrors> result;
    for (int n = 1; n <= steps.back(); ++n) {
      const double time = lead * lead_step + n * dt;
      step(time, dt);
      if (n == steps[result.size()]) result.push_back(measure(field, time));
      field.accept_step();
    }
    return result;
  }

 private:
  static input::VectorExpression slowed(double viscosity) {
    const auto component = [&](const std::string& r, const std::string& s, const std::string& q) {
      return "-(pi/4)*(exp(pi/4*" + r + ")*sin(pi/4*" + s + "+pi/2*" + q + ")+exp(pi/4*" + q + ")*cos(pi/4*" + r +
             "+pi/2*" + s + "))*exp(-pi^2/4*" + std::to_string(viscosity) + "*t)";
    };
    return expressions(component("x", "y", "z"), component("y", "z", "x"), component("z", "x", "y"));
  }
  static FluidParameters parameters(double viscosity, const Method& method) {
    FluidParameters p;
    p.density = 1;
    p.viscosity = viscosity;
    p.initial_velocity = slowed(viscosity);
    method.set(p);
    return p;
  }
  static BoundaryConditions boundaries(double viscosity) {
    BoundaryConditions all;
    for (const std::string& face : box_faces) all[face] = velocity(slowed(viscosity));
    return all;
  }
  PressureErrors measure(FluidField& field, double t) const {
    const double time = viscosity_ * t;
    const Errors e = errors(field, [&](const Vec3& x, double* value) { exact(x, time, value); });
    LocalArray u(field.iterate());
    double rough = 0, expected = 0, speed = 0, mean = 0, square = 0;
    for (Index cell = 0; cell < mesh_.local_cells(); ++cell) {
      double ours = 0, ours_square = 0, theirs = 0, theirs_square = 0;
      for (int a = 0; a < 8; ++a) {
        const Index n = mesh_.cells[8 * static_cast<std::size_t>(cell) + a];
        double value[4];
        exact(Eigen::Map<const Vec3>(mesh_.node(n)), time, value);
        const double p = u[4 * static_cast<std::size_t>(n) + 3];
        ours += p / 8;
        ours_square += p * p / 8;
        theirs += value[3] / 8;
        theirs_square += value[3] * value[3] / 8;
        speed += value[0] * value[0] + value[1] * value[1] + value[2] * value[2];
        mean += value[3];
        square += value[3] * value[3];
      }
      rough += std::max(0.0, ours_square - ours * ours);
      expected += theirs_square - theirs * theirs;
    }
    const double corners = 8.0 * mesh_.local_cells(), volume = 8.0;
    return {e.velocity / std::sqrt(volume * speed / corners),
            e.pressure / std::sqrt(volume * (square / corners - mean * mean / (corners * corners))),
            std::sqrt(rough / expected)};
  }

  double viscosity_;
  mesh::HexMesh mesh_;
  FluidParameters parameters_;
};

}  // namespace fbi::fluid::test
