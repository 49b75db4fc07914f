/// The stabilised Navier-Stokes equations at one point: the one place where the weak form is written down.
#pragma once

namespace fbi::fluid {

/// A number with its derivative in one direction: forward-mode differentiation.
template <class T>
struct Dual {
  T value;
  T derivative;
  Dual() = default;
  Dual(const T& v) : value(v), derivative(0.0) {}  // NOLINT: a constant has derivative 0
  Dual(const T& v, const T& d) : value(v), derivative(d) {}
};
template <class T>
inline Dual<T> operator+(const Dual<T>& a, const Dual<T>& b) {
  return {a.value + b.value, a.derivative + b.derivative};
}
template <class T>
inline Dual<T> operator-(const Dual<T>& a, const Dual<T>& b) {
  return {a.value - b.value, a.derivative - b.derivative};
}
template <class T>
inline Dual<T> operator*(const Dual<T>& a, const Dual<T>& b) {
  return {a.value * b.value, a.derivative * b.value + a.value * b.derivative};
}
template <class T>
inline Dual<T> operator*(const T& a, const Dual<T>& b) {
  return {a * b.value, a * b.derivative};
}

/// Which terms the compiler leaves out of the equations.
struct Equations {
  bool convection;        ///< with the convective terms and SUPG; without them: Stokes
  bool viscous_residual;  ///< with the viscous part of r_M
  bool extended;          ///< with the terms of div v in the convection, the pressure projection and tau by point
};

/// What the equations need to know at a point. T: number type (values, or values with derivatives).
template <class T>
struct PointState {
  T velocity[3];           ///< v [length/time]
  T gradient[3][3];        ///< dv_i/dx_j [1/time]
  T pressure;              ///< p [force/area]
  T pressure_gradient[3];  ///< [force/volume]
  T acceleration[3];       ///< dv/dt - b [length/time^2]
  T viscous[3];            ///< lap v + grad div v [1/(length time)]
  T pressure_fluctuation;  ///< p minus its cell mean [force/area]; read with `extended`
};

/// Coefficients that are fixed within a step. B: number type without derivatives.
template <class B>
struct PointCoefficients {
  B density;         ///< rho
  B viscosity;       ///< mu
  B tau_convection;  ///< tau_M of SUPG [time/density]
  B tau_pressure;    ///< tau_M of PSPG [time/density]
  B tau_divergence;  ///< tau_C of grad-div [viscosity]
  // read with `extended`
  B divergence_share;  ///< share of rho v div v in the convection: 0 advective, 1/2 skew, 1 conservative
  B projection;        ///< coefficient of the pressure projection [1/viscosity]
};

/// What is integrated against w, grad w, q and grad q.
template <class T>
struct PointFlux {
  T w[3];
  T grad_w[3][3];  ///< against dw_i/dx_j
  T q;
  T grad_q[3];
};

/// Component i of dv/dt - b + (v.grad) v.
template <Equations E, class T>
inline T inertia(const PointState<T>& s, int i) {
  if constexpr (!E.convection) return s.acceleration[i];
  return s.acceleration[i] + s.velocity[0] * s.gradient[i][0] + s.velocity[1] * s.gradient[i][1] +
         s.velocity[2] * s.gradient[i][2];
}

/// Component i of r_M, from rho times the inertia.
template <Equations E, class T, class B>
inline T momentum_residual(const PointState<T>& s, const PointCoefficients<B>& c, const T& scaled_inertia, int i) {
  if constexpr (E.viscous_residual) return scaled_inertia + s.pressure_gradient[i] - c.viscosity * s.viscous[i];
  return scaled_inertia + s.pressure_gradient[i];
}

/// The weak form of SPEC section 1 at one point, left-hand side minus body force:
///   w: rho (dv/dt - b + (v.grad) v + s v div v);  grad w: 2 mu eps(v) - p I + tau_C div v I + tau_M rho r_M (x) v;
///   q: div v + c (p - Pi p);  grad q: tau_M r_M;  r_M = rho (dv/dt - b + (v.grad) v) + grad p - mu (lap v + grad div
///   v),
/// with s the divergence share, Pi the cell mean and c the coefficient of the pressure projection (Dohrmann and Bochev
/// 2004), which takes the place of tau_M in grad q. r_M is that of the advective form always: the other forms differ by
/// a term that is zero for the solution.
template <Equations E, class T, class B>
inline void navier_stokes(const PointState<T>& s, const PointCoefficients<B>& c, PointFlux<T>& flux) {
  const T divergence = s.gradient[0][0] + s.gradient[1][1] + s.gradient[2][2];
  T residual[3];
  for (int i = 0; i < 3; ++i) {
    flux.w[i] = c.density * inertia<E>(s, i);
    residual[i] = momentum_residual<E>(s, c, flux.w[i], i);
    flux.grad_q[i] = c.tau_pressure * residual[i];
    if constexpr (E.extended && E.convection)
      flux.w[i] = flux.w[i] + (c.density * c.divergence_share) * (divergence * s.velocity[i]);
  }
  const T isotropic = c.tau_divergence * divergence - s.pressure;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) flux.grad_w[i][j] = c.viscosity * (s.gradient[i][j] + s.gradient[j][i]);
    flux.grad_w[i][i] = flux.grad_w[i][i] + isotropic;
    if constexpr (E.convection) {
      const T scaled = (c.density * c.tau_convection) * residual[i];
      for (int j = 0; j < 3; ++j) flux.grad_w[i][j] = flux.grad_w[i][j] + scaled * s.velocity[j];
    }
  }
  flux.q = divergence;
  if constexpr (E.extended) flux.q = flux.q + c.projection * s.pressure_fluctuation;
}

/// Derivative of navier_stokes at fixed tau in the direction (d, 0) of a velocity, for equations without `extended`. The
/// convecting velocity has the derivative follow d.
/// @param s         velocity and its gradient where the derivative is taken; the rest is not read
/// @param residual  r_M there, shape=(3)
/// @param d         direction; its pressure is not read
template <Equations E, class B>
inline void tangent_of_velocity(const PointState<B>& s, const B* residual, const PointState<B>& d, const B& follow,
                                const PointCoefficients<B>& c, PointFlux<B>& flux) {
  static_assert(!E.extended);
  flux.q = d.gradient[0][0] + d.gradient[1][1] + d.gradient[2][2];
  const B convecting[3] = {follow * d.velocity[0], follow * d.velocity[1], follow * d.velocity[2]};
  const B isotropic = c.tau_divergence * flux.q;
  const B streamline = c.density * c.tau_convection;
  for (int i = 0; i < 3; ++i) {
    B rate = d.acceleration[i];
    if constexpr (E.convection)
      for (int j = 0; j < 3; ++j) rate = rate + s.velocity[j] * d.gradient[i][j] + convecting[j] * s.gradient[i][j];
    flux.w[i] = c.density * rate;
    B change = flux.w[i];
    if constexpr (E.viscous_residual) change = change - c.viscosity * d.viscous[i];
    flux.grad_q[i] = c.tau_pressure * change;
    for (int j = 0; j < 3; ++j) flux.grad_w[i][j] = c.viscosity * (d.gradient[i][j] + d.gradient[j][i]);
    flux.grad_w[i][i] = flux.grad_w[i][i] + isotropic;
    if constexpr (E.convection) {
      const B scaled = streamline * change, kept = streamline * residual[i];
      for (int j = 0; j < 3; ++j)
        flux.grad_w[i][j] = flux.grad_w[i][j] + scaled * s.velocity[j] + kept * convecting[j];
    }
  }
}

/// The same in the direction (0, d) of a pressure: flux.w and flux.q are zero and not set.
/// @param velocity  v, shape=(3)
template <Equations E, class B>
inline void tangent_of_pressure(const B* velocity, const B& d, const B* gradient, const PointCoefficients<B>& c,
                                PointFlux<B>& flux) {
  static_assert(!E.extended);
  const B streamline = c.density * c.tau_convection;
  for (int i = 0; i < 3; ++i) {
    flux.grad_q[i] = c.tau_pressure * gradient[i];
    const B scaled = streamline * gradient[i];
    for (int j = 0; j < 3; ++j) flux.grad_w[i][j] = E.convection ? scaled * velocity[j] : B(0.0);
    flux.grad_w[i][i] = flux.grad_w[i][i] - d;
  }
}

inline double negative_part(double x) { return x < 0 ? x : 0.0; }
inline Dual<double> negative_part(const Dual<double>& x) { return x.value < 0 ? x : Dual<double>(0.0, 0.0); }
inline double frozen(double x) { return x; }
inline Dual<double> frozen(const Dual<double>& x) { return x.value; }

/// Backflow stabilisation at a point of an open face, tested with w: -beta rho min(v.n, 0) v (Bertoglio et al. 2018).
/// @param beta_density  beta rho
/// @param normal        outward unit normal, shape=(3)
/// @param freeze        leave the derivative of min(v.n, 0) out
template <class T>
inline void backflow(const T* velocity, const double* normal, double beta_density, bool freeze, T* flux) {
  T inward = negative_part(normal[0] * velocity[0] + normal[1] * velocity[1] + normal[2] * velocity[2]);
  if (freeze) inward = frozen(inward);
  for (int i = 0; i < 3; ++i) flux[i] = (-beta_density) * (inward * velocity[i]);
}

}  // namespace fbi::fluid
