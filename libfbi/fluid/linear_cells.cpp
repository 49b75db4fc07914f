#include "fluid/linear_cells.hpp"

namespace fbi::fluid {
namespace {

using Single = LinearCells::Single;

inline void gather(const LinearCells::Nodes& batch, const float* array, Single (*out)[8]) {
  for (int a = 0; a < 8; ++a) {
    Single four[4];
    if (batch.row)
      fem::gather_row(array, batch.node[a][0], four);
    else
      fem::gather_four(array, batch.node[a].data(), four);
    for (int c = 0; c < 4; ++c) out[c][a] = four[c];
  }
}

inline void scatter(const LinearCells::Nodes& batch, const Single (*in)[8], const Single& scale, float* array) {
  for (int a = 0; a < 8; a += 2) {
    const Single low[4] = {in[0][a], in[1][a], in[2][a], scale * in[3][a]};
    const Single high[4] = {in[0][a + 1], in[1][a + 1], in[2][a + 1], scale * in[3][a + 1]};
    if (batch.row) {
      fem::scatter_add_edges(low, high, batch.node[a][0], array);
      continue;
    }
    fem::scatter_add_four(low, batch.node[a].data(), batch.lanes, array);
    fem::scatter_add_four(high, batch.node[a + 1].data(), batch.lanes, array);
  }
}

template <class Geometry, Equations E>
inline void velocity_loop(const LinearCells& cells, const std::vector<typename Geometry::Cells>& geometry,
                          const float* x, float* y) {
  const Single scale(cells.continuity_scale);
  for (std::size_t b = 0; b < cells.nodes.size(); ++b) {
    Single direction[4][8], out[4][8];
    gather(cells.nodes[b], x, direction);
    hex8_velocity_columns<Geometry, E>(geometry[b], cells.constants, cells.state[b], direction, out);
    scatter(cells.nodes[b], out, scale, y);
  }
}

template <class Geometry, Equations E>
inline void pressure_loop(const LinearCells& cells, const std::vector<typename Geometry::Cells>& geometry,
                          const float* x, float* y) {
  const Single scale(cells.continuity_scale);
  for (std::size_t b = 0; b < cells.nodes.size(); ++b) {
    Single direction[4][8], out[4][8];
    gather(cells.nodes[b], x, direction);
    hex8_pressure_columns<Geometry, E>(geometry[b], cells.constants, cells.state[b], direction[3], out);
    scatter(cells.nodes[b], out, scale, y);
  }
}

#define FBI_LINEAR_KERNELS(name, convection, viscous)                                                            \
  FBI_KERNEL void velocity_on_box_##name(const LinearCells& cells, const float* x, float* y) {                   \
    velocity_loop<BoxGeometryOf<Single>, Equations{convection, viscous, false}>(cells, cells.box, x, y);         \
  }                                                                                                              \
  FBI_KERNEL void velocity_##name(const LinearCells& cells, const float* x, float* y) {                          \
    velocity_loop<GeneralGeometryOf<Single>, Equations{convection, viscous, false}>(cells, cells.general, x, y); \
  }                                                                                                              \
  FBI_KERNEL void pressure_on_box_##name(const LinearCells& cells, const float* x, float* y) {                   \
    pressure_loop<BoxGeometryOf<Single>, Equations{convection, viscous, false}>(cells, cells.box, x, y);         \
  }                                                                                                              \
  FBI_KERNEL void pressure_##name(const LinearCells& cells, const float* x, float* y) {                          \
    pressure_loop<GeneralGeometryOf<Single>, Equations{convection, viscous, false}>(cells, cells.general, x, y); \
  }
FBI_LINEAR_KERNELS(full, true, true)
FBI_LINEAR_KERNELS(inviscid, true, false)  // without the viscous part of r_M
FBI_LINEAR_KERNELS(stokes, false, true)
FBI_LINEAR_KERNELS(stokes_inviscid, false, false)

using Kernel = void (*)(const LinearCells&, const float*, float*);

/// kernels[without convection][without viscous residual][on a box]
void run(const Kernel (&kernels)[2][2][2], const LinearCells& cells, const float* x, float* y) {
  kernels[cells.convection ? 0 : 1][cells.viscous ? 0 : 1][cells.box.empty() ? 0 : 1](cells, x, y);
}

}  // namespace

void add_velocity_columns(const LinearCells& cells, const float* x, float* y) {
  static constexpr Kernel kernels[2][2][2] = {
      {{velocity_full, velocity_on_box_full}, {velocity_inviscid, velocity_on_box_inviscid}},
      {{velocity_stokes, velocity_on_box_stokes}, {velocity_stokes_inviscid, velocity_on_box_stokes_inviscid}}};
  run(kernels, cells, x, y);
}

void add_pressure_columns(const LinearCells& cells, const float* x, float* y) {
  static constexpr Kernel kernels[2][2][2] = {
      {{pressure_full, pressure_on_box_full}, {pressure_inviscid, pressure_on_box_inviscid}},
      {{pressure_stokes, pressure_on_box_stokes}, {pressure_stokes_inviscid, pressure_on_box_stokes_inviscid}}};
  run(kernels, cells, x, y);
}

}  // namespace fbi::fluid
