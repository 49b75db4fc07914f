/// Cells in batches of sixteen with all that products with the tangent need, and these products.
#pragma once

#include <array>
#include <vector>

#include "fluid/hex8_linear.hpp"

namespace fbi::fluid {

/// The cells of a rank for the products of one linear solve, in single precision.
struct LinearCells {
  using Single = fem::BatchOf<float>;
  static constexpr int batch_lanes = Single::lanes;
  struct Nodes {
    /// [corner bits][lane]; the i-th cell is in lane_of_sixteen(i), spare lanes repeat the last cell.
    std::array<std::array<Index, batch_lanes>, 8> node;
    int lanes;
    /// A row of cells: nodes at each corner follow each other, from those of every second corner the next ones on.
    bool row;
  };
  KernelConstants constants;
  float continuity_scale = 1.0f;  ///< of the continuity rows
  bool convection = true, viscous = true;
  std::vector<Nodes> nodes;
  std::vector<BoxCellsOf<Single>> box;  ///< one of the two is empty
  std::vector<GeneralCellsOf<Single>> general;
  std::vector<LinearState<Single>> state;
};

/// y += velocity columns, or pressure columns, of the tangent times x; arrays of local nodes, shape=(nodes,4).
void add_velocity_columns(const LinearCells& cells, const float* x, float* y);
void add_pressure_columns(const LinearCells& cells, const float* x, float* y);

}  // namespace fbi::fluid
