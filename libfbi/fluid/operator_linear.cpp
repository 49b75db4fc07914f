#include "fluid/operator.hpp"
#include "fluid/operator_dispatch.hpp"

namespace fbi::fluid {

using fem::batch_size;

LinearCells Operator::linear_cells() const {
  LinearCells linear;
  linear.convection = convection();
  linear.viscous = parameters_.viscous_residual == ViscousResidual::full;
  const Index cells = mesh_.local_cells(), count = (cells + LinearCells::batch_lanes - 1) / LinearCells::batch_lanes;
  linear.nodes.resize(count);
  linear.state.resize(count);
  if (is_box())
    linear.box.resize(count);
  else
    linear.general.resize(count);
  for (Index b = 0; b < count; ++b) {
    linear.nodes[b].lanes = std::min<Index>(LinearCells::batch_lanes, cells - b * LinearCells::batch_lanes);
    linear.nodes[b].row = linear.nodes[b].lanes == LinearCells::batch_lanes;
    for (int i = 0; i < LinearCells::batch_lanes; ++i) {
      const int lane = fem::lane_of_sixteen(i);
      const Index cell = b * LinearCells::batch_lanes + std::min(i, linear.nodes[b].lanes - 1);
      const Index from = cell / batch_size;
      const int at = cell % batch_size;
      for (int a = 0; a < 8; ++a) {
        linear.nodes[b].node[a][lane] = batches_[from].node[a][at];
        if (batches_[from].node[a][at] != linear.nodes[b].node[a][0] + i) linear.nodes[b].row = false;
      }
      if (is_box()) {
        for (int d = 0; d < 3; ++d) linear.box[b].scale[d].set(lane, static_cast<float>(box_[from].scale[d][at]));
        linear.box[b].weight.set(lane, static_cast<float>(box_[from].weight[at]));
      } else {
        for (int i = 0; i < 3; ++i)
          for (int m = 0; m < 8; ++m)
            linear.general[b].modes[i][m].set(lane, static_cast<float>(general_[from].modes[i][m][at]));
      }
    }
  }
  return linear;
}

namespace {

/// The order of lane_of_sixteen, from cells one after the other.
void reorder(fem::BatchOf<float>& batch) {
  batch.v = __builtin_shufflevector(batch.v, batch.v, 0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15);
}

/// The lanes of a batch of eight as one half of a batch of sixteen.
void put(const Batch& from, int half, fem::BatchOf<float>& to) {
  using HalfVector = float __attribute__((vector_size(32)));
  const HalfVector narrow = __builtin_convertvector(from.v, HalfVector);
  std::memcpy(reinterpret_cast<char*>(&to) + half * sizeof(HalfVector), &narrow, sizeof(HalfVector));
}

}  // namespace

void Operator::keep_state(std::size_t b, const Batch (*modes)[8], const Batch (*momentum)[8],
                          LinearCells& linear) const {
  LinearState<fem::BatchOf<float>>& to = linear.state[b / 2];
  // A half without a batch of its own takes the last one: numbers that nobody reads, but numbers.
  const bool alone = b % 2 == 0 && b + 1 == batches_.size();
  const bool full = b % 2 == 1 || alone;
  const auto keep = [&](const Batch& from, fem::BatchOf<float>& target) {
    put(from, static_cast<int>(b % 2), target);
    if (alone) put(from, 1, target);
    if (full) reorder(target);
  };
  keep(tau(b)->convection, to.tau[0]);
  keep(tau(b)->pressure, to.tau[1]);
  keep(tau(b)->divergence, to.tau[2]);
  for (int i = 0; i < 3; ++i)
    for (int m = 0; m < 8; ++m) {
      keep(modes[i][m], to.velocity[i][m]);
      keep(momentum[i][m], to.residual[i][m]);
    }
}

void Operator::linearize(const double* u, const double* rest, LinearCells& linear) const {
  linear.constants = constants_;
  dispatch([&]<class Geometry, Equations E>() {
    const auto& cells = this->geometry<Geometry>();
    for (std::size_t b = 0; b < batches_.size(); ++b) {
      Batch values[4][8], acceleration[4][8], momentum[3][8];
      gather(batches_[b], u, values);
      gather(batches_[b], rest, acceleration);
      const Geometry geometry(cells[b]);
      const TangentState<Geometry, E> state(values, acceleration);  // values: modes from here on
      const PointCoefficients<Batch> c = coefficients<E>(constants_, *tau(b));
      const Batch sigma(constants_.sigma);
      for (int q = 0; q < 8; ++q) {
        PointState<Batch> s;
        state.field.at(typename Geometry::At(geometry, q), q, s);
        for (int i = 0; i < 3; ++i) s.acceleration[i] = state.rest[i][q] + sigma * s.velocity[i];
        for (int i = 0; i < 3; ++i) {
          const Batch scaled = c.density * inertia<E>(s, i);
          momentum[i][q] = momentum_residual<E>(s, c, scaled, i);
        }
      }
      keep_state(b, values, momentum, linear);
    }
  });
}

}  // namespace fbi::fluid
