/// The fluid mesh of a run and the search for points in it.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "base/types.hpp"
#include "io/hdf5.hpp"
#include "post/reader.hpp"
#include "search/tree.hpp"

namespace fbi::post {

/// Hexahedra of a run: a tensor-product box, of which only the three coordinate arrays are held, or any cells.
class Grid {
 public:
  using Corners = Eigen::Matrix<double, 3, 8>;

  /// From NAME.run/mesh.h5. Throws Error(file) when the run has no fluid.
  static Grid read(const Run& run);

  Index cells() const { return cells_; }
  GlobalIndex nodes() const { return node_count_; }
  bool is_box() const { return box_.has_value(); }
  const std::array<std::vector<double>, 3>& box() const { return *box_; }
  /// Node numbers of a cell, in VTK order.
  std::array<Index, 8> cell_nodes(Index cell) const;
  /// Node positions of a cell, shape=(3,8) [length].
  Corners corners(Index cell) const;
  /// The same cells at the same places, to the last bit.
  bool operator==(const Grid& other) const;
  double volume() const { return volume_; }

 private:
  std::optional<std::array<std::vector<double>, 3>> box_;
  std::vector<double> coordinates_;  // shape=(nodes,3); empty for a box
  std::vector<std::int32_t> cell_nodes_;
  Index cells_ = 0;
  GlobalIndex node_count_ = 0;
  double volume_ = 0.0;
};

/// Finds the cell and the reference point of points in space. A point on a face belongs to one of its cells; points up
/// to 1e-7 of a cell outside the mesh count as inside.
class Locator {
 public:
  explicit Locator(const Grid& grid);

  /// Cell that holds `x`, -1 outside the mesh; `xi` receives the reference point in [-1,1]^3. Starts from the cell that
  /// was found last: points that follow each other in space cost least.
  Index find(const Vec3& x, Vec3& xi);

 private:
  bool inside(Index cell, const Vec3& x, Vec3& xi) const;
  Index find_in_box(const Vec3& x, Vec3& xi);

  const Grid& grid_;
  search::Tree tree_;
  std::vector<Index> found_;
  std::array<Index, 3> place_ = {0, 0, 0};  // in a box
  Index last_ = -1;
};

}  // namespace fbi::post
