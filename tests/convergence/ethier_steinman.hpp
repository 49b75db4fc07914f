/// Ethier and Steinman (1994), exact unsteady 3D solution on (-1,1)^3, a = pi/4, d = pi/2, nu = 1.
#pragma once

#include <gtest/gtest.h>

#include "base/log.hpp"
#include "convergence/fluid_solver.hpp"
#include "record.hpp"

namespace fbi::fluid::test {

inline constexpr double a = M_PI / 4, d = M_PI / 2;

/// Exact velocity and pressure, shape=(4).
inline void exact(const Vec3& p, double t, double* value) {
  const double x = p[0], y = p[1], z = p[2], decay = std::exp(-d * d * t);
  const auto velocity = [&](double r, double s, double q) {
    return -a * (std::exp(a * r) * std::sin(a * s + d * q) + std::exp(a * q) * std::cos(a * r + d * s)) * decay;
  };
  value[0] = velocity(x, y, z);
  value[1] = velocity(y, z, x);
  value[2] = velocity(z, x, y);
  const auto mixed = [&](double r, double s, double q) {
    return 2 * std::sin(a * r + d * s) * std::cos(a * q + d * r) * std::exp(a * (s + q));
  };
  value[3] = -0.5 * a * a * decay * decay *
             (std::exp(2 * a * x) + std::exp(2 * a * y) + std::exp(2 * a * z) + mixed(x, y, z) + mixed(y, z, x) +
              mixed(z, x, y));
}

/// The exact velocity as expressions.
inline input::VectorExpression formulas() {
  const auto component = [](const std::string& r, const std::string& s, const std::string& q) {
    return "-(pi/4)*(exp(pi/4*" + r + ")*sin(pi/4*" + s + "+pi/2*" + q + ")+exp(pi/4*" + q + ")*cos(pi/4*" + r +
           "+pi/2*" + s + "))*exp(-pi^2/4*t)";
  };
  return expressions(component("x", "y", "z"), component("y", "z", "x"), component("z", "x", "y"));
}

/// The flow computed from t = 0 to `end` in `steps` equal steps, exact velocities on all faces.
struct Flow {
  mesh::HexMesh mesh;
  FluidField field;
  Flow(const std::vector<double>& x, double warp, double theta, bool tau_time, double end, int steps)
      : Flow(x, warp, theta, fluid(tau_time), end, steps) {}
  Flow(const std::vector<double>& x, double warp, double theta, const FluidParameters& parameters, double end,
       int steps)
      : mesh(box_mesh(Comm(MPI_COMM_SELF), {x, x, x}, false, warp)),
        field(mesh, parameters, boundaries(), {TimeScheme::one_step_theta, theta}) {
    field.initialize();
    StepSolver solver(field);
    for (int n = 1; n <= steps; ++n) {
      field.begin_step(end * n / steps, end / steps);
      newton += solver.solve();
      field.accept_step();
    }
  }
  int newton = 0;
  static FluidParameters fluid(bool tau_time) {
    FluidParameters p;
    p.tau_time = tau_time;
    p.initial_velocity = formulas();
    return p;
  }
  static BoundaryConditions boundaries() {
    BoundaryConditions all;
    for (const std::string& face : box_faces) all[face] = velocity(formulas());
    return all;
  }
};

/// Errors at t = 0.1 after `steps` steps with theta = 1/2.
inline Errors space_errors(const std::vector<double>& x, double warp, bool tau_time, int steps = 20) {
  Flow run(x, warp, 0.5, tau_time, 0.1, steps);
  const Errors e = errors(run.field, [](const Vec3& p, double* value) { exact(p, 0.1, value); });
  std::printf("%zu cells a side, tau_time %s: velocity %.4e pressure %.4e, Newton iterations %d\n", x.size() - 1,
              tau_time ? "on" : "off", e.velocity, e.pressure, run.newton);
  return e;
}

/// Observed orders between two meshes whose cell sizes have the given ratio.
inline Errors orders(const Errors& coarse, const Errors& fine, double ratio) {
  const Errors order = {std::log(coarse.velocity / fine.velocity) / std::log(ratio),
                        std::log(coarse.pressure / fine.pressure) / std::log(ratio)};
  std::printf("order: velocity %.3f pressure %.3f\n", order.velocity, order.pressure);
  return order;
}

/// Rows of the tables: orders and the errors on the finer mesh.
inline void record_orders(const char* what, const Errors& fine, const Errors& order, const char* bar_velocity,
                          const char* bar_pressure) {
  for (int i = 0; i < 2; ++i)
    fbi::test::record({.section = "Fluid",
                       .id = "S-F1",
                       .check = log::format("Ethier-Steinman flow, nu = 1, t = 0.1, %s: L2 error of the %s", what,
                                            i == 0 ? "velocity" : "pressure, mean removed"),
                       .source = "exact solution (Ethier, Steinman 1994)",
                       .reference = 0.0,
                       .ours = i == 0 ? fine.velocity : fine.pressure,
                       .order = i == 0 ? order.velocity : order.pressure,
                       .bar = i == 0 ? bar_velocity : bar_pressure});
}

}  // namespace fbi::fluid::test
