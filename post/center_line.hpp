/// The center line of a fiber: a chain of Hermite elements, in its reference and its current shape.
#pragma once

#include <vector>

#include "base/types.hpp"

namespace fbi::post {

/// r = sum H^d d + l/2 H^t t on each element, with the length l of the reference shape.
class CenterLine {
 public:
  /// @param reference, current  positions and tangents of the nodes, shape=(nodes,6) [length]
  CenterLine(std::vector<double> reference, std::vector<double> current);

  double length() const { return breaks_.back(); }
  std::size_t elements() const { return breaks_.size() - 1; }
  /// Shares of the length at which elements begin and end.
  std::vector<double> shares() const;
  /// The point at a share of the reference length, from 0 to 1.
  Vec3 current(double share) const { return at(current_, share); }
  Vec3 reference(double share) const { return at(reference_, share); }

 private:
  Vec3 at(const std::vector<double>& dofs, double share) const;

  std::vector<double> reference_, current_;  // shape=(nodes,6)
  std::vector<double> breaks_;               // reference arc length of the nodes
};

}  // namespace fbi::post
