/// Multiplier bases Phi_p along a fiber (SPEC section 3).
///
/// Lagrange of order 1, 2, 3, continuous over the fiber: order + 1 rows live on an element, of which neighbors share
/// one; rows are numbered along the fiber. Gauss-point: Phi_p is 1 at integration point p and 0 at all others, so that
/// every integration point has a row of its own.
#pragma once

#include "base/types.hpp"
#include "coupling/parameters.hpp"

namespace fbi::coupling {

/// Most rows that are not zero at one point.
inline constexpr int most_rows = 4;

/// The functions that are not zero at a point: rows first ... first + count - 1 of the element.
struct BasisValues {
  Index first = 0;
  int count = 0;
  double value[most_rows] = {};
};

class Basis {
 public:
  explicit Basis(Multiplier type)
      : order_(type == Multiplier::linear      ? 1
               : type == Multiplier::quadratic ? 2
               : type == Multiplier::cubic     ? 3
                                               : 0) {}

  /// Polynomial order; 0 for gauss_point.
  int order() const { return order_; }
  bool is_lagrange() const { return order_ > 0; }

  /// Phi at x in [-1, 1]; `point` is the number of the integration point within its element.
  BasisValues at(double x, Index point) const {
    BasisValues result;
    if (order_ == 0) {
      result.first = point;
      result.count = 1;
      result.value[0] = 1.0;
      return result;
    }
    result.count = order_ + 1;
    if (order_ == 1) {
      result.value[0] = 0.5 * (1.0 - x);
      result.value[1] = 0.5 * (1.0 + x);
      return result;
    }
    for (int p = 0; p <= order_; ++p) {
      result.value[p] = 1.0;
      for (int q = 0; q <= order_; ++q)
        if (q != p) result.value[p] *= (x - place(q)) / (place(p) - place(q));
    }
    return result;
  }

 private:
  double place(int p) const { return 2.0 * p / order_ - 1.0; }

  int order_;
};

}  // namespace fbi::coupling
