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
        const Index first = linear.nodes[b].node[a & ~1][0] + (a & 1);
        if (batches_[from].node[a][at] != first + i) linear.nodes[b].row = false;
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

/// Two batches of eight as one of sixteen, in the order of lane_of_sixteen.
void join(const Batch& low, const Batch& high, fem::BatchOf<float>& to) {
  using HalfVector = float __attribute__((vector_size(32)));
  const HalfVector a = __builtin_convertvector(low.v, HalfVector), b = __builtin_convertvector(high.v, HalfVector);
  to.v = __builtin_shufflevector(a, b, 0, 4, 8, 12, 1, 5, 9, 13, 2, 6, 10, 14, 3, 7, 11, 15);
}

/// r_M at a point.
template <Equations E>
inline void keep_momentum(const PointState<Batch>& s, const PointCoefficients<Batch>& c, int q, Batch (*momentum)[8]) {
  for (int i = 0; i < 3; ++i) {
    const Batch scaled = c.density * inertia<E>(s, i);
    momentum[i][q] = momentum_residual<E>(s, c, scaled, i);
  }
}

}  // namespace

void Operator::keep_state(std::size_t b, const HalfState* halves, LinearCells& linear) const {
  // An even batch waits for the next one. The last one may be alone: it takes the place of the other half, too, whose
  // numbers nobody reads, but they are numbers.
  const bool alone = b % 2 == 0;
  if (alone && b + 1 < batches_.size()) return;
  LinearState<fem::BatchOf<float>>& to = linear.state[b / 2];
  const BatchTau &low_tau = *tau(b - b % 2), &high_tau = *tau(b);
  join(low_tau.convection, high_tau.convection, to.tau[0]);
  join(low_tau.pressure, high_tau.pressure, to.tau[1]);
  join(low_tau.divergence, high_tau.divergence, to.tau[2]);
  const HalfState &low = halves[0], &high = halves[alone ? 0 : 1];
  for (int i = 0; i < 3; ++i)
    for (int m = 0; m < 8; ++m) {
      join(low.modes[i][m], high.modes[i][m], to.velocity[i][m]);
      join(low.momentum[i][m], high.momentum[i][m], to.residual[i][m]);
    }
}

void Operator::linearize(const double* u, const double* rest, LinearCells& linear) const {
  linear.constants = constants_;
  dispatch([&]<class Geometry, Equations E>() {
    const auto& cells = this->geometry<Geometry>();
    HalfState halves[2];
    for (std::size_t b = 0; b < batches_.size(); ++b) {
      Batch acceleration[4][8];
      Batch(*values)[8] = halves[b % 2].modes, (*momentum)[8] = halves[b % 2].momentum;
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
        keep_momentum<E>(s, c, q, momentum);
      }
      keep_state(b, halves, linear);
    }
  });
}

void Operator::add_residual_and_linearize(const double* u, const double* rest, double* r, LinearCells& linear) const {
  linear.constants = constants_;
  dispatch([&]<class Geometry, Equations E>() {
    const auto& cells = this->geometry<Geometry>();
    HalfState halves[2];
    for (std::size_t b = 0; b < batches_.size(); ++b) {
      Batch acceleration[4][8], out[4][8];
      Batch(*values)[8] = halves[b % 2].modes, (*momentum)[8] = halves[b % 2].momentum;
      gather(batches_[b], u, values);
      gather(batches_[b], rest, acceleration);
      hex8_residual<Geometry, E>(cells[b], constants_, tau(b), values, acceleration, out,
                                 [&](int q, const PointState<Batch>& s, const PointCoefficients<Batch>& c) {
                                   keep_momentum<E>(s, c, q, momentum);
                                 });
      scatter(batches_[b], out, r);
      keep_state(b, halves, linear);
    }
  });
}

}  // namespace fbi::fluid
