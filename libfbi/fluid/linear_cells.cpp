#include "fluid/linear_cells.hpp"

namespace fbi::fluid {
namespace {

using Single = LinearCells::Single;

void gather(const LinearCells::Nodes& batch, const float* array, Single (*out)[8]) {
  for (int a = 0; a < 8; ++a) {
    Single four[4];
    if (batch.row)
      fem::gather_row(array, batch.node[a][0], four);
    else
      fem::gather_four(array, batch.node[a].data(), four);
    for (int c = 0; c < 4; ++c) out[c][a] = four[c];
  }
}

void scatter(const LinearCells::Nodes& batch, const Single (*in)[8], const Single& scale, float* array) {
  for (int a = 0; a < 8; ++a) {
    const Single four[4] = {in[0][a], in[1][a], in[2][a], scale * in[3][a]};
    if (batch.row)
      fem::scatter_add_row(four, batch.node[a][0], array);
    else
      fem::scatter_add_four(four, batch.node[a].data(), batch.lanes, array);
  }
}

template <class Action>
void dispatch(const LinearCells& cells, const Action& action) {
  const auto with_geometry = [&]<class Geometry>(const std::vector<typename Geometry::Cells>& geometry) {
    if (cells.convection && cells.viscous)
      action.template operator()<Geometry, Equations{true, true, false}>(geometry);
    else if (cells.convection)
      action.template operator()<Geometry, Equations{true, false, false}>(geometry);
    else if (cells.viscous)
      action.template operator()<Geometry, Equations{false, true, false}>(geometry);
    else
      action.template operator()<Geometry, Equations{false, false, false}>(geometry);
  };
  if (!cells.box.empty())
    with_geometry.template operator()<BoxGeometryOf<Single>>(cells.box);
  else
    with_geometry.template operator()<GeneralGeometryOf<Single>>(cells.general);
}

}  // namespace

void add_velocity_columns(const LinearCells& cells, const float* x, float* y) {
  dispatch(cells, [&]<class Geometry, Equations E>(const std::vector<typename Geometry::Cells>& geometry) {
    for (std::size_t b = 0; b < cells.nodes.size(); ++b) {
      Single direction[4][8], out[4][8];
      gather(cells.nodes[b], x, direction);
      hex8_velocity_columns<Geometry, E>(geometry[b], cells.constants, cells.state[b], direction, out);
      scatter(cells.nodes[b], out, Single(cells.continuity_scale), y);
    }
  });
}

void add_pressure_columns(const LinearCells& cells, const float* x, float* y) {
  dispatch(cells, [&]<class Geometry, Equations E>(const std::vector<typename Geometry::Cells>& geometry) {
    for (std::size_t b = 0; b < cells.nodes.size(); ++b) {
      Single direction[4][8], out[4][8];
      gather(cells.nodes[b], x, direction);
      hex8_pressure_columns<Geometry, E>(geometry[b], cells.constants, cells.state[b], direction[3], out);
      scatter(cells.nodes[b], out, Single(cells.continuity_scale), y);
    }
  });
}

}  // namespace fbi::fluid
