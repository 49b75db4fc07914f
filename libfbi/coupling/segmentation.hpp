/// Cutting fiber elements where they cross cell faces (SPEC section 3).
///
/// A piece between neighboring cuts belongs to the cell with the lowest file id among those that hold its midpoint to
/// inside_tolerance. Cuts and midpoints follow from the curve and the corners of the cells alone, so the answer does
/// not depend on how cells and fibers are spread over ranks.
#pragma once

#include <vector>

#include "coupling/curve.hpp"
#include "coupling/projection.hpp"

namespace fbi::coupling {

/// The part [begin, end] of an element's parameter that one cell holds. `reach` is how far beyond these ends the curve
/// stays within inside_tolerance of the cell: it closes gaps that round-off leaves between two cells. Trivially
/// copyable.
struct Claim {
  GlobalIndex cell;
  double begin, end;
  double reach_begin, reach_end;
};

/// One piece of an element in the end; cell < 0: outside the fluid. Trivially copyable.
struct Segment {
  GlobalIndex cell = -1;
  double begin = 0.0, end = 0.0;
  Index first_point = 0;  ///< number of its first integration point within the element
  Index rule_point = -1;  ///< >= 0: not a piece, but this point of the rule on the whole element, at begin = end
};

/// Cuts closer to each other than this (of the parameter, element = [-1, 1]) are one.
inline constexpr double cut_tolerance = 1e-12;

/// Appends to `claims` the parts of a curve in one cell: the roots of the crossings with its six (planar or bilinear)
/// faces, then a test of every midpoint. A curve may leave and re-enter the cell.
void claim_parts(const Curve& curve, const Cell& cell, GlobalIndex id, std::vector<Claim>& claims);

/// Turns the claims of all cells on an element into segments that follow each other from -1 to 1 (overwritten):
/// overlaps go to the lowest cell, what nobody claims is outside.
void resolve(const std::vector<Claim>& claims, std::vector<Segment>& segments);

/// Segments of a curve in a tensor-product box (overwritten): cuts at the planes of the grid, cells found in the
/// three coordinate arrays. The same rule as claim_parts and resolve, without a search.
void cut_in_box(const Curve& curve, const mesh::Box& box, std::vector<Segment>& segments);

/// The cell of a tensor-product box that holds a point, the one with the lowest id of several, or -1: the rule of
/// cut_in_box.
GlobalIndex cell_in_box(const mesh::Box& box, const Vec3& point);

}  // namespace fbi::coupling
