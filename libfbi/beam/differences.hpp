/// Derivatives of formulas in time and along a line, by differences of fourth order.
#pragma once

#include "base/types.hpp"
#include "input/expression.hpp"

namespace fbi::beam {

/// f, df/dt and d2f/dt2 of a vector formula at one place and time.
struct Motion {
  Vec3 value = Vec3::Zero(), rate = Vec3::Zero(), acceleration = Vec3::Zero();
};

inline Vec3 value_of(const input::VectorExpression& f, const Vec3& x, double t) {
  return {f[0](x, t), f[1](x, t), f[2](x, t)};
}

/// Derivatives of the polynomial of degree four through f(x, t_k), t_k = t - 2h ... t + 2h, shifted where they would
/// lie before t = 0: errors O(h^4) of the rate, O(h^4) of the acceleration (O(h^3) where shifted). `h` [time], 0 leaves
/// the derivatives at zero.
Motion motion_in_time(const input::VectorExpression& f, const Vec3& x, double t, double h);

/// Derivative of f along the unit vector `direction` at time t, by central differences with the spacing `h` [length].
Vec3 derivative_along(const input::VectorExpression& f, const Vec3& x, const Vec3& direction, double t, double h);

/// Some component depends on time.
bool depends_on_time(const input::VectorExpression& f);

}  // namespace fbi::beam
