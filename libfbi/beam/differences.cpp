#include "beam/differences.hpp"

#include <array>
#include <cmath>

namespace fbi::beam {
namespace {

// First and second derivatives at 0, 1 and 2 of the polynomial through the values at 0, 1, 2, 3, 4, times 12.
constexpr double first[3][5] = {{-25, 48, -36, 16, -3}, {-3, -10, 18, -6, 1}, {1, -8, 0, 8, -1}};
constexpr double second[3][5] = {{35, -104, 114, -56, 11}, {11, -20, 6, 4, -1}, {-1, 16, -30, 16, -1}};

}  // namespace

bool depends_on_time(const input::VectorExpression& f) {
  return f[0].depends_on_time() || f[1].depends_on_time() || f[2].depends_on_time();
}

Motion motion_in_time(const input::VectorExpression& f, const Vec3& x, double t, double h) {
  Motion motion;
  motion.value = value_of(f, x, t);
  if (!(h > 0.0) || !depends_on_time(f)) return motion;
  // points before t lie at t - place h >= 0
  const int place = t >= 2 * h * (1 - 1e-9) ? 2 : t >= h * (1 - 1e-9) ? 1 : 0;
  for (int k = 0; k < 5; ++k) {
    const Vec3 value = k == place ? motion.value : value_of(f, x, std::fmax(0.0, t + (k - place) * h));
    motion.rate += first[place][k] / (12 * h) * value;
    motion.acceleration += second[place][k] / (12 * h * h) * value;
  }
  return motion;
}

Vec3 derivative_along(const input::VectorExpression& f, const Vec3& x, const Vec3& direction, double t, double h) {
  if (!f[0].depends_on_space() && !f[1].depends_on_space() && !f[2].depends_on_space()) return Vec3::Zero();
  Vec3 sum = Vec3::Zero();
  for (int k = 0; k < 5; ++k)
    if (k != 2) sum += first[2][k] / (12 * h) * value_of(f, x + (k - 2) * h * direction, t);
  return sum;
}

}  // namespace fbi::beam
