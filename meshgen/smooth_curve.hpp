/// A curve given by a function of a parameter, by its arc length.
#pragma once

#include <array>
#include <functional>
#include <vector>

#include "meshgen/curves.hpp"

namespace fbi::meshgen {

/// Pieces of a curve r(t) on which r and the speed |dr/dt| are Chebyshev sums of degree 16 to round-off; tangents and
/// arc lengths are those of the sums. The function is evaluated between the first and the last of the given breaks
/// only.
class SmoothCurve final : public CenterLine {
 public:
  /// `breaks` ascend or descend: the ends of the curve, and between them the places where it is not smooth to all
  /// orders. Throws Error(geometry) for values that are not finite, for kinks and jumps and where the speed is zero.
  SmoothCurve(const std::function<Vec3(double)>& position, const std::vector<double>& breaks);

  double length() const override { return arc_.back(); }
  CurvePoint at(double u) const override;

 private:
  static constexpr int degree = 16;
  using Sum = std::array<double, degree + 1>;  // coefficients of T_0 ... T_16
  struct Piece {
    double begin = 0.0, end = 0.0;           // of t
    double slowest = 0.0;                    // smallest |dr/dx|
    std::array<Sum, 3> position{}, slope{};  // r and dr/dx, x in [-1, 1]
    std::array<double, degree + 2> arc{};    // arc length from x = -1, of T_0 ... T_17
  };

  void add(const std::function<Vec3(double)>& position, double begin, double end, int depth);

  double scale_ = 0.0;  // largest coordinate met
  std::vector<Piece> pieces_;
  std::vector<double> arc_;  // at the begin of each piece, and the length; shape=(pieces+1)
};

}  // namespace fbi::meshgen
