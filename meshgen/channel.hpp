/// Node coordinates of a box channel.
#pragma once

#include <vector>

#include "mesh/mesh_data.hpp"
#include "mesh/parameters.hpp"

namespace fbi::meshgen {

/// Node coordinates of one direction, ascending, the first being `origin` and the last `origin + size` exactly.
///
/// uniform: equal cells; geometric: each cell `ratio` times the one before it; tanh: x = 1/2 (1 + tanh(d (2 i/n -
/// 1))/tanh d) with d such that the largest cell is `ratio` times the smallest one.
/// @param origin first coordinate [length]
/// @param size extent, > 0 [length]
/// @param cells number of cells, >= 1
std::vector<double> graded_line(double origin, double size, Index cells, const mesh::GradingParameters& grading);

/// The box mesh of a channel, with faces xmin ... zmax.
mesh::HexMeshData make_channel(const mesh::BoxParameters& box);

}  // namespace fbi::meshgen
