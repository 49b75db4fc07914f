/// Numbers that carry their derivatives by N variables: exact tangents of small functions.
#pragma once

#include <Eigen/Core>
#include <array>

namespace fbi::beam {

/// value + sum_i slope_i epsilon_i with epsilon_i epsilon_j = 0.
template <int N>
struct Dual {
  double value = 0.0;
  Eigen::Array<double, N, 1> slope = Eigen::Array<double, N, 1>::Zero();

  Dual() = default;
  Dual(double number) : value(number) {}  // NOLINT: numbers are constants
  /// Variable `index`.
  static Dual variable(double number, int index) {
    Dual result(number);
    result.slope[index] = 1.0;
    return result;
  }
  friend Dual operator+(const Dual& a, const Dual& b) { return {a.value + b.value, a.slope + b.slope}; }
  friend Dual operator-(const Dual& a, const Dual& b) { return {a.value - b.value, a.slope - b.slope}; }
  friend Dual operator*(const Dual& a, const Dual& b) {
    return {a.value * b.value, a.value * b.slope + b.value * a.slope};
  }
  friend Dual operator*(double a, const Dual& b) { return {a * b.value, a * b.slope}; }

 private:
  Dual(double number, const Eigen::Array<double, N, 1>& slopes) : value(number), slope(slopes) {}
  template <int M>
  friend Dual<M> apply(double value, double derivative, const Dual<M>& argument);
};

/// f(argument) from f and f' there.
template <int N>
Dual<N> apply(double value, double derivative, const Dual<N>& argument) {
  return {value, derivative * argument.slope};
}
inline double apply(double value, double /*derivative*/, double /*argument*/) { return value; }

template <int N>
double value_of(const Dual<N>& x) {
  return x.value;
}
inline double value_of(double x) { return x; }

}  // namespace fbi::beam
