/// Where a fiber element crosses the faces of a general hexahedron.
#pragma once

#include <vector>

#include "coupling/curve.hpp"
#include "coupling/projection.hpp"

namespace fbi::coupling {

/// Planes with the average normal of a bilinear face, which lies in the hull of its corners.
struct FacePlanes {
  Vec3 normal;       ///< outward unit normal of the plane through the middles of the edges
  double low, high;  ///< smallest and largest n.x over the corners of the face [length]
  double outermost;  ///< largest n.x over all corners of the cell [length]
  double margin;     ///< beyond `outermost` by this is surely outside [length]
  bool warped;       ///< the face is not planar
};

/// Planes of face 0..5 (mesh::Face numbering).
FacePlanes face_planes(const Cell& cell, int face);

/// Appends all x in (begin, end) where the curve crosses the bilinear face, xi_k(r(x)) = +-1: intervals are halved
/// until the Hermite interpolant of xi_k shows no root, one bracketed root, or stays on the face to a tenth of
/// inside_tolerance. A pair of crossings nearer than 1e-6 of the parameter may be missed: the curve then leaves the
/// face by less than inside_tolerance.
void warped_face_crossings(const Curve& curve, const Cell& cell, int face, double begin, double end,
                           std::vector<double>& roots);

}  // namespace fbi::coupling
