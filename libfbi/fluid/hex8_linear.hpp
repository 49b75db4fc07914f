/// The tangent on a batch of hexahedra with what it needs of the state at hand: for many products at one linearisation.
#pragma once

#include "fluid/hex8_kernel.hpp"

namespace fbi::fluid {

/// What a tangent keeps of the state at which it is taken.
/// B: number type of a batch.
template <class B>
struct LinearState {
  B velocity[3][8];  ///< modes of v
  B residual[3][8];  ///< r_M at the points
  B tau[3];          ///< tau_M of SUPG, of PSPG, tau_C
};

namespace detail {

template <class B>
inline PointCoefficients<B> linear_coefficients(const KernelConstants& constants, const LinearState<B>& state) {
  PointCoefficients<B> c{};
  c.density = B(static_cast<typename B::Scalar>(constants.density));
  c.viscosity = B(static_cast<typename B::Scalar>(constants.viscosity));
  c.tau_convection = state.tau[0];
  c.tau_pressure = state.tau[1];
  c.tau_divergence = state.tau[2];
  return c;
}

}  // namespace detail

/// Velocity columns of the tangent: the derivative of hex8_residual in the direction (x, 0), all rows.
/// @param x    corner values of the direction, shape=(3,8) by corner bits; overwritten by the modes
/// @param out  shape=(4,8) by corner bits
template <class Geometry, Equations E, class B = typename Geometry::Number>
[[gnu::flatten]] inline void hex8_velocity_columns(const typename Geometry::Cells& cells,
                                                   const KernelConstants& constants, const LinearState<B>& state,
                                                   B (*x)[8], B (*out)[8]) {
  const Geometry geometry(cells);
  B v[3][8], dv[3][8], slope[3][3][4], change[3][3][4], mixed[3][3][2];
  for (int i = 0; i < 3; ++i) {
    to_modes(x[i]);
    values_at_points(x[i], dv[i]);
    if constexpr (E.convection) values_at_points(state.velocity[i], v[i]);
    for (int d = 0; d < 3; ++d) {
      derivative_at_points(x[i], d, change[i][d]);
      if constexpr (E.convection) derivative_at_points(state.velocity[i], d, slope[i][d]);
      if constexpr (E.viscous_residual) mixed_at_points(x[i], d, mixed[i][d]);
    }
  }
  const PointCoefficients<B> c = detail::linear_coefficients(constants, state);
  const B sigma(static_cast<typename B::Scalar>(constants.sigma));
  const B follow(static_cast<typename B::Scalar>(constants.follow));
  FluxIntegralOf<B> integral;
  for (int q = 0; q < 8; ++q) {
    const typename Geometry::At at(geometry, q);
    PointState<B> s, ds;
    B along_z[3], residual[3];
    for (int i = 0; i < 3; ++i) {
      for (int d = 0; d < 3; ++d) along_z[d] = change[i][d][line_of_point(d, q)];
      at.gradient(along_z, ds.gradient[i]);
      ds.velocity[i] = dv[i][q];
      ds.acceleration[i] = sigma * dv[i][q];
      if constexpr (E.convection) {
        for (int d = 0; d < 3; ++d) along_z[d] = slope[i][d][line_of_point(d, q)];
        at.gradient(along_z, s.gradient[i]);
        s.velocity[i] = v[i][q];
        residual[i] = state.residual[i][q];
      }
    }
    if constexpr (E.viscous_residual) {
      B here[3][3];
      for (int i = 0; i < 3; ++i)
        for (int d = 0; d < 3; ++d) here[i][d] = mixed[i][d][layer_of_point(d, q)];
      at.viscous(ds.gradient, here, ds.viscous);
    }
    PointFlux<B> flux;
    tangent_of_velocity<E>(s, residual, ds, follow, c, flux);
    integral.set(at, q, flux);
  }
  integral.integrate(out);
}

/// Pressure columns of the tangent: the derivative in the direction (0, x), all rows.
/// @param x    corner values, shape=(8) by corner bits; overwritten by the modes
/// @param out  shape=(4,8)
template <class Geometry, Equations E, class B = typename Geometry::Number>
[[gnu::flatten]] inline void hex8_pressure_columns(const typename Geometry::Cells& cells,
                                                   const KernelConstants& constants, const LinearState<B>& state, B* x,
                                                   B (*out)[8]) {
  const Geometry geometry(cells);
  B v[3][8], p[8], change[3][4], flux_at[4][3][8];
  to_modes(x);
  values_at_points(x, p);
  for (int d = 0; d < 3; ++d) derivative_at_points(x, d, change[d]);
  if constexpr (E.convection)
    for (int i = 0; i < 3; ++i) values_at_points(state.velocity[i], v[i]);
  const PointCoefficients<B> c = detail::linear_coefficients(constants, state);
  for (int q = 0; q < 8; ++q) {
    const typename Geometry::At at(geometry, q);
    B along_z[3], gradient[3], velocity[3], reference[3];
    for (int d = 0; d < 3; ++d) along_z[d] = change[d][line_of_point(d, q)];
    at.gradient(along_z, gradient);
    if constexpr (E.convection)
      for (int i = 0; i < 3; ++i) velocity[i] = v[i][q];
    PointFlux<B> flux;
    tangent_of_pressure<E>(velocity, p[q], gradient, c, flux);
    for (int k = 0; k < 4; ++k) {
      at.pull_back(k < 3 ? flux.grad_w[k] : flux.grad_q, reference);
      for (int d = 0; d < 3; ++d) flux_at[k][d][q] = reference[d];
    }
  }
  for (int k = 0; k < 4; ++k) {
    flux_moments(flux_at[k], out[k]);
    from_modes(out[k]);
  }
}

}  // namespace fbi::fluid
