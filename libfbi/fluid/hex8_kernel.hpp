/// Residual and tangent of the stabilised equations on a batch of eight hexahedra: pure functions on plain arrays.
#pragma once

#include <type_traits>

#include "fluid/hex8_geometry.hpp"
#include "fluid/physics.hpp"

namespace fbi::fluid {

/// Coefficients of a batch at one point, or at all of them, that are fixed within an iteration.
struct BatchTau {
  Batch convection;  ///< tau_M of SUPG
  Batch pressure;    ///< tau_M of PSPG, or the coefficient of the pressure projection
  Batch divergence;  ///< tau_C
};

/// What the kernel needs besides geometry and tau.
struct KernelConstants {
  double density = 1.0;
  double viscosity = 1.0;
  double sigma = 0.0;   ///< dv'/dv = 1/(theta dt)
  double follow = 1.0;  ///< derivative of the convecting velocity in tangents: 1 = it follows v, 0 = frozen
  // read with Equations::extended
  double divergence_share = 0.0;  ///< of rho v div v in the convection
  bool projection = false;        ///< pressure projection in place of PSPG
  int tau_stride = 0;             ///< 1: tau of every point, 0: the same at all points
};

/// Velocity and pressure at the points, from corner values f[c][corner bits].
template <bool ViscousResidual, class B = Batch>
struct FieldAtPoints {
  B value[3][8];
  B first[4][3][4];
  B pressure[8];
  B second[3][3][2];

  /// @param f  corner values, shape=(4,8); overwritten by the modes
  explicit FieldAtPoints(B (*f)[8]) {
    for (int c = 0; c < 4; ++c) {
      to_modes(f[c]);
      values_at_points(f[c], c < 3 ? value[c] : pressure);
      for (int d = 0; d < 3; ++d) derivative_at_points(f[c], d, first[c][d]);
      if constexpr (ViscousResidual)
        if (c < 3)
          for (int d = 0; d < 3; ++d) mixed_at_points(f[c], d, second[c][d]);
    }
  }

  /// State at point q; `acceleration` is left to the caller.
  template <class At>
  void at(const At& geometry, int q, PointState<B>& s) const {
    B along_z[3];
    for (int c = 0; c < 4; ++c) {
      for (int d = 0; d < 3; ++d) along_z[d] = first[c][d][line_of_point(d, q)];
      geometry.gradient(along_z, c < 3 ? s.gradient[c] : s.pressure_gradient);
    }
    for (int i = 0; i < 3; ++i) s.velocity[i] = value[i][q];
    s.pressure = pressure[q];
    if constexpr (ViscousResidual) {
      B mixed[3][3];
      for (int i = 0; i < 3; ++i)
        for (int d = 0; d < 3; ++d) mixed[i][d] = second[i][d][layer_of_point(d, q)];
      geometry.viscous(s.gradient, mixed, s.viscous);
    }
  }
};

/// Integrals of a flux against the shape functions, from its values at the points.
template <class B>
class FluxIntegralOf {
 public:
  template <class At>
  void set(const At& geometry, int q, const PointFlux<B>& flux) {
    B reference[3];
    for (int c = 0; c < 4; ++c) {
      value_[c][q] = geometry.weight() * (c < 3 ? flux.w[c] : flux.q);
      geometry.pull_back(c < 3 ? flux.grad_w[c] : flux.grad_q, reference);
      for (int d = 0; d < 3; ++d) flux_[c][d][q] = reference[d];
    }
  }
  /// @param out  by corner bits, shape=(4,8)
  void integrate(B (*out)[8]) {
    for (int c = 0; c < 4; ++c) {
      moments(value_[c], flux_[c], out[c]);
      from_modes(out[c]);
    }
  }

 private:
  B value_[4][8];
  B flux_[4][3][8];
};
using FluxIntegral = FluxIntegralOf<Batch>;

template <Equations E>
inline PointCoefficients<Batch> coefficients(const KernelConstants& constants, const BatchTau& tau) {
  PointCoefficients<Batch> c;
  c.density = Batch(constants.density);
  c.viscosity = Batch(constants.viscosity);
  c.tau_convection = tau.convection;
  c.tau_pressure = tau.pressure;
  c.tau_divergence = tau.divergence;
  if constexpr (E.extended) {
    c.divergence_share = Batch(constants.divergence_share);
    c.projection = constants.projection ? tau.pressure : Batch(0.0);
    if (constants.projection) c.tau_pressure = Batch(0.0);
  }
  return c;
}

/// Mean over the cell of a field given at the points.
template <class Geometry>
inline Batch cell_mean(const Geometry& geometry, const Batch* value) {
  Batch sum(0.0), volume(0.0);
  for (int q = 0; q < 8; ++q) {
    const Batch weight = typename Geometry::At(geometry, q).weight();
    sum += weight * value[q];
    volume += weight;
  }
  return sum / volume;
}

/// Residual of SPEC section 1 on eight cells.
/// @param tau           of all points, or of each of them, shape=(1) or (8)
/// @param u             corner values (v, p), shape=(4,8) by corner bits; overwritten by the modes
/// @param acceleration  dv/dt - b - sigma v at the corners, shape=(3,8); overwritten
/// @param out           shape=(4,8)
/// @param look          called with every point's number, state and coefficients
template <class Geometry, Equations E, class Look>
[[gnu::flatten]] inline void hex8_residual(const typename Geometry::Cells& cells, const KernelConstants& constants,
                                           const BatchTau* tau, Batch (*u)[8], Batch (*acceleration)[8],
                                           Batch (*out)[8], const Look& look) {
  const Geometry geometry(cells);
  const FieldAtPoints<E.viscous_residual> field(u);
  Batch rest[3][8];
  for (int i = 0; i < 3; ++i) {
    to_modes(acceleration[i]);
    values_at_points(acceleration[i], rest[i]);
  }
  PointCoefficients<Batch> c = coefficients<E>(constants, tau[0]);
  const Batch sigma(constants.sigma);
  Batch mean(0.0);
  if (E.extended && constants.projection) mean = cell_mean(geometry, field.pressure);
  FluxIntegral integral;
  for (int q = 0; q < 8; ++q) {
    const typename Geometry::At at(geometry, q);
    PointState<Batch> s;
    PointFlux<Batch> flux;
    field.at(at, q, s);
    for (int i = 0; i < 3; ++i) s.acceleration[i] = rest[i][q] + sigma * s.velocity[i];
    if constexpr (E.extended) {
      s.pressure_fluctuation = s.pressure - mean;
      if (constants.tau_stride > 0) c = coefficients<E>(constants, tau[q]);
    }
    navier_stokes<E>(s, c, flux);
    integral.set(at, q, flux);
    look(q, s, c);
  }
  integral.integrate(out);
}
template <class Geometry, Equations E>
inline void hex8_residual(const typename Geometry::Cells& cells, const KernelConstants& constants, const BatchTau* tau,
                          Batch (*u)[8], Batch (*acceleration)[8], Batch (*out)[8]) {
  hex8_residual<Geometry, E>(cells, constants, tau, u, acceleration, out, [](int, const auto&, const auto&) {});
}

/// The state at which a tangent is taken, on eight cells.
template <class Geometry, Equations E>
struct TangentState {
  FieldAtPoints<E.viscous_residual> field;
  Batch rest[3][8];

  /// As in hex8_residual. Without convection the equations are linear and the state is not read.
  TangentState(Batch (*u)[8], Batch (*acceleration)[8]) : field(u) {
    for (int i = 0; i < 3; ++i) {
      to_modes(acceleration[i]);
      values_at_points(acceleration[i], rest[i]);
    }
  }
};

/// Derivative of hex8_residual in direction x at fixed tau: the same point function on numbers with derivatives.
/// @param x    direction, corner values (v, p), shape=(4,8); overwritten
/// @param out  shape=(4,8)
template <class Geometry, Equations E>
[[gnu::flatten]] inline void hex8_tangent(const typename Geometry::Cells& cells, const KernelConstants& constants,
                                          const BatchTau* tau, const TangentState<Geometry, E>& state, Batch (*x)[8],
                                          Batch (*out)[8]) {
  const Geometry geometry(cells);
  const FieldAtPoints<E.viscous_residual> direction(x);
  PointCoefficients<Batch> c = coefficients<E>(constants, tau[0]);
  const Batch sigma(constants.sigma), follow(constants.follow);
  Batch mean(0.0);
  if (E.extended && constants.projection) mean = cell_mean(geometry, direction.pressure);
  FluxIntegral integral;
  for (int q = 0; q < 8; ++q) {
    const typename Geometry::At at(geometry, q);
    PointState<Batch> s, ds;
    state.field.at(at, q, s);
    direction.at(at, q, ds);
    for (int i = 0; i < 3; ++i) {
      s.acceleration[i] = state.rest[i][q] + sigma * s.velocity[i];
      ds.acceleration[i] = sigma * ds.velocity[i];
    }
    PointState<Dual<Batch>> dual;
    for (int i = 0; i < 3; ++i) {
      dual.velocity[i] = {s.velocity[i], follow * ds.velocity[i]};
      for (int j = 0; j < 3; ++j) dual.gradient[i][j] = {s.gradient[i][j], ds.gradient[i][j]};
      dual.pressure_gradient[i] = {s.pressure_gradient[i], ds.pressure_gradient[i]};
      dual.acceleration[i] = {s.acceleration[i], ds.acceleration[i]};
      if constexpr (E.viscous_residual) dual.viscous[i] = {s.viscous[i], ds.viscous[i]};
    }
    dual.pressure = {s.pressure, ds.pressure};
    if constexpr (E.extended) {
      dual.pressure_fluctuation = {s.pressure, ds.pressure - mean};  // linear: the value is not needed
      if (constants.tau_stride > 0) c = coefficients<E>(constants, tau[q]);
    }
    PointFlux<Dual<Batch>> dual_flux;
    navier_stokes<E>(dual, c, dual_flux);
    PointFlux<Batch> flux;
    for (int i = 0; i < 3; ++i) {
      flux.w[i] = dual_flux.w[i].derivative;
      for (int j = 0; j < 3; ++j) flux.grad_w[i][j] = dual_flux.grad_w[i][j].derivative;
      flux.grad_q[i] = dual_flux.grad_q[i].derivative;
    }
    flux.q = dual_flux.q.derivative;
    integral.set(at, q, flux);
  }
  integral.integrate(out);
}

}  // namespace fbi::fluid
