/// Multiplier bases Phi_p along a fiber (SPEC section 3).
///
/// Linear Lagrange, continuous over the fiber: one row per fiber node, rows e and e+1 of a fiber live on its element e.
#pragma once

#include <array>

#include "fem/line_shapes.hpp"

namespace fbi::coupling {

/// Rows that live on one element.
inline constexpr int rows_per_element = 2;

/// Phi_p(x) of the rows of one element, x in [-1, 1].
inline std::array<double, rows_per_element> multiplier_shape(double x) { return fem::linear(x); }

}  // namespace fbi::coupling
