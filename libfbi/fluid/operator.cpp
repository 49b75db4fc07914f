#include "fluid/operator.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "fem/hex8.hpp"
#include "fluid/operator_dispatch.hpp"
#include "fluid/stabilization.hpp"

namespace fbi::fluid {

using fem::batch_size;

Operator::Operator(const mesh::HexMesh& mesh, const FluidParameters& parameters)
    : mesh_(mesh), parameters_(parameters) {
  constants_.density = parameters.density;
  constants_.viscosity = parameters.viscosity;
  if (parameters.convective_form == ConvectiveForm::conservative) constants_.divergence_share = 1.0;
  if (parameters.convective_form == ConvectiveForm::skew) constants_.divergence_share = 0.5;
  constants_.projection = parameters.pressure_stabilization == PressureStabilization::projection;
  constants_.tau_stride = parameters.tau_at == TauAt::quadrature_points ? 1 : 0;
  extended_ = constants_.divergence_share > 0 || constants_.projection || constants_.tau_stride > 0;
  const Index cells = mesh.local_cells();
  const Index count = (cells + batch_size - 1) / batch_size;
  batches_.resize(count);
  tau_.assign(static_cast<std::size_t>(count) * taus_of_batch(), BatchTau{Batch(0.0), Batch(0.0), Batch(0.0)});
  tau_pressure_.assign(cells, 0.0);
  volume_.resize(cells);
  length_.resize(cells);
  inverse_jacobian_.resize(9 * static_cast<std::size_t>(cells));
  const bool box = mesh.box.has_value();
  if (box)
    box_.resize(count);
  else
    general_.resize(count);
  for (Index b = 0; b < count; ++b) {
    CellBatch& batch = batches_[b];
    batch.lanes = std::min<Index>(batch_size, cells - b * batch_size);
    for (int lane = 0; lane < batch_size; ++lane) {
      const Index cell = b * batch_size + std::min(lane, batch.lanes - 1);
      const Index* nodes = &mesh.cells[8 * static_cast<std::size_t>(cell)];
      for (int a = 0; a < 8; ++a) batch.node[a][lane] = nodes[corner_of_bits[a]];
      const double* low = mesh.node(nodes[0]);
      const double* high = mesh.node(nodes[6]);
      if (box) {
        double volume = 1;
        for (int d = 0; d < 3; ++d) {
          box_[b].scale[d].set(lane, 2 / ((high[d] - low[d]) * gauss_scale));
          volume *= high[d] - low[d];
        }
        box_[b].weight.set(lane, volume / 8);
      } else {
        for (int i = 0; i < 3; ++i)
          for (int m = 0; m < 8; ++m) {
            double sum = 0;
            for (int a = 0; a < 8; ++a)
              sum +=
                  (std::popcount(static_cast<unsigned>(m & ~a)) % 2 == 0 ? 1 : -1) * mesh.node(batch.node[a][lane])[i];
            general_[b].modes[i][m].set(lane, mode_scale[m] * sum);
          }
      }
      if (lane >= batch.lanes) continue;
      Mat3 jacobian;  // dx_i/dxi_d at the center
      for (int i = 0; i < 3; ++i)
        for (int d = 0; d < 3; ++d) {
          double sum = 0;
          for (int a = 0; a < 8; ++a) sum += fem::hex8_corners[a][d] * mesh.node(nodes[a])[i];
          jacobian(i, d) = sum / 8;
        }
      const Mat3 inverse = jacobian.inverse();
      for (int d = 0; d < 3; ++d)
        for (int i = 0; i < 3; ++i) inverse_jacobian_[9 * static_cast<std::size_t>(cell) + 3 * d + i] = inverse(d, i);
    }
  }
  dispatch([&]<class Geometry, Equations E>() {
    for (Index b = 0; b < count; ++b) {
      const Geometry geometry(this->geometry<Geometry>()[b]);
      Batch sum(0.0);
      for (int q = 0; q < 8; ++q) sum += typename Geometry::At(geometry, q).weight();
      for (int lane = 0; lane < batches_[b].lanes; ++lane) {
        volume_[b * batch_size + lane] = sum[lane];
        length_[b * batch_size + lane] = std::cbrt(sum[lane]);
      }
    }
  });
}

void Operator::center_velocity(Index cell, const double* u, double* velocity) const {
  const Index* nodes = &mesh_.cells[8 * static_cast<std::size_t>(cell)];
  for (int i = 0; i < 3; ++i) {
    double sum = 0;
    for (int a = 0; a < 8; ++a) sum += u[4 * static_cast<std::size_t>(nodes[a]) + i];
    velocity[i] = sum / 8;
  }
}

CellTau Operator::tau_of(const double* k, const double* v, double max_speed, const double* xi, double length) const {
  const double speed = std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  CellTau tau;
  if (parameters_.tau == Tau::franca_valentin) {
    double direction[3] = {1, 0, 0};
    if (speed > 1e-8 * max_speed && speed > 0)
      for (int i = 0; i < 3; ++i) direction[i] = v[i] / speed;
    const double h = xi == nullptr ? streamline_length(k, direction) : streamline_length(k, direction, xi);
    const double sigma = parameters_.tau_time ? constants_.sigma : 0.0;
    tau = franca_valentin(parameters_.density, parameters_.viscosity, sigma, speed, h, length);
  } else {
    const double rate = parameters_.tau_time && dt_ > 0 ? 2 / dt_ : 0.0;
    const Metric metric = cell_metric(k, v);
    tau = parameters_.tau == Tau::whiting_jansen
              ? whiting_jansen(parameters_.density, parameters_.viscosity, rate, metric)
              : taylor_hughes_zarins(parameters_.density, parameters_.viscosity, rate, metric);
  }
  if (!parameters_.grad_div) tau.divergence = 0;
  return tau;
}

CellTau Operator::tau_at_point(Index cell, int q, const double* u, double max_speed) const {
  const Index* nodes = &mesh_.cells[8 * static_cast<std::size_t>(cell)];
  const Vec3 xi = gauss_scale * Vec3((q & 1) != 0 ? 1 : -1, (q & 2) != 0 ? 1 : -1, (q & 4) != 0 ? 1 : -1);
  const std::array<double, 8> shape = fem::hex8_shape(xi);
  const Eigen::Matrix<double, 8, 3> slope = fem::hex8_gradient(xi);
  Mat3 jacobian = Mat3::Zero();
  double v[3] = {0, 0, 0};
  for (int a = 0; a < 8; ++a) {
    jacobian += Eigen::Map<const Vec3>(mesh_.node(nodes[a])) * slope.row(a);
    if (convection())
      for (int i = 0; i < 3; ++i) v[i] += shape[a] * u[4 * static_cast<std::size_t>(nodes[a]) + i];
  }
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> k = jacobian.inverse();
  return tau_of(k.data(), v, max_speed, xi.data(), length_[cell]);
}

void Operator::update_tau(const double* u, double max_speed) {
  const Index count = static_cast<Index>(batches_.size());
  const bool points = constants_.tau_stride > 0;
  for (Index b = 0; b < count; ++b)
    for (int lane = 0; lane < batch_size; ++lane) {
      const Index cell = b * batch_size + std::min(lane, batches_[b].lanes - 1);
      double v[3] = {0, 0, 0};
      if (convection()) center_velocity(cell, u, v);
      const double length = length_[cell];
      const double projection = constants_.projection
                                    ? projection_coefficient(parameters_.density, parameters_.viscosity,
                                                             std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]), length)
                                    : 0.0;
      const auto store = [&](BatchTau& batch, const CellTau& tau) {
        batch.convection.set(lane, tau.convection);
        batch.pressure.set(lane, constants_.projection ? projection : tau.pressure);
        batch.divergence.set(lane, tau.divergence);
      };
      const CellTau center =
          tau_of(&inverse_jacobian_[9 * static_cast<std::size_t>(cell)], v, max_speed, nullptr, length);
      tau_pressure_[cell] = center.pressure;
      if (!points) store(tau(b)[0], center);
      for (int q = 0; points && q < 8; ++q) store(tau(b)[q], tau_at_point(cell, q, u, max_speed));
    }
}

void Operator::add_residual(const double* u, const double* rest, double* r) const {
  dispatch([&]<class Geometry, Equations E>() {
    const auto& cells = this->geometry<Geometry>();
    for (std::size_t b = 0; b < batches_.size(); ++b) {
      Batch state[4][8], acceleration[4][8], out[4][8];
      gather(batches_[b], u, state);
      gather(batches_[b], rest, acceleration);
      hex8_residual<Geometry, E>(cells[b], constants_, tau(b), state, acceleration, out);
      scatter(batches_[b], out, r);
    }
  });
}

void Operator::add_tangent(const double* u, const double* rest, const double* x, double* y) const {
  dispatch([&]<class Geometry, Equations E>() {
    const auto& cells = this->geometry<Geometry>();
    for (std::size_t b = 0; b < batches_.size(); ++b) {
      Batch values[4][8], acceleration[4][8], direction[4][8], out[4][8];
      gather(batches_[b], u, values);
      gather(batches_[b], rest, acceleration);
      gather(batches_[b], x, direction);
      const TangentState<Geometry, E> state(values, acceleration);
      hex8_tangent<Geometry, E>(cells[b], constants_, tau(b), state, direction, out);
      scatter(batches_[b], out, y);
    }
  });
}

void Operator::visit_tangents(const double* u, const double* rest,
                              const std::function<void(Index, const ElementMatrix&)>& visit) const {
  dispatch([&]<class Geometry, Equations E>() {
    const auto& cells = this->geometry<Geometry>();
    std::vector<ElementMatrix> matrices(batch_size);
    for (std::size_t b = 0; b < batches_.size(); ++b) {
      Batch values[4][8], acceleration[4][8], direction[4][8], out[4][8];
      gather(batches_[b], u, values);
      gather(batches_[b], rest, acceleration);
      const TangentState<Geometry, E> state(values, acceleration);
      for (int column = 0; column < 32; ++column) {
        for (int c = 0; c < 4; ++c)
          for (int a = 0; a < 8; ++a)
            direction[c][a] = Batch(c == column % 4 && corner_of_bits[a] == column / 4 ? 1.0 : 0.0);
        hex8_tangent<Geometry, E>(cells[b], constants_, tau(b), state, direction, out);
        for (int c = 0; c < 4; ++c)
          for (int a = 0; a < 8; ++a)
            for (int lane = 0; lane < batches_[b].lanes; ++lane)
              matrices[lane][4 * corner_of_bits[a] + c][column] = out[c][a][lane];
      }
      for (int lane = 0; lane < batches_[b].lanes; ++lane)
        visit(static_cast<Index>(b) * batch_size + lane, matrices[lane]);
    }
  });
}

void Operator::visit_laplacians(const std::function<void(Index, const ScalarMatrix&)>& visit) const {
  dispatch([&]<class Geometry, Equations E>() {
    const auto& cells = this->geometry<Geometry>();
    for (std::size_t b = 0; b < batches_.size(); ++b) {
      const Geometry geometry(cells[b]);
      Batch sum[8][8];
      for (auto& row : sum)
        for (Batch& entry : row) entry = Batch(0.0);
      for (int q = 0; q < 8; ++q) {
        const typename Geometry::At at(geometry, q);
        Batch gradient[8][3];
        for (int a = 0; a < 8; ++a) {
          Batch along_z[3];
          for (int d = 0; d < 3; ++d) {
            double derivative = 0.125 * gauss_scale * fem::hex8_corners[a][d];
            for (int o : other_directions[d])
              derivative *= 1 + fem::hex8_corners[a][o] * gauss_scale * (((q >> o) & 1) == 1 ? 1 : -1);
            along_z[d] = Batch(derivative);
          }
          at.gradient(along_z, gradient[a]);
        }
        for (int i = 0; i < 8; ++i)
          for (int j = 0; j < 8; ++j)
            sum[i][j] += at.weight() * (gradient[i][0] * gradient[j][0] + gradient[i][1] * gradient[j][1] +
                                        gradient[i][2] * gradient[j][2]);
      }
      for (int lane = 0; lane < batches_[b].lanes; ++lane) {
        ScalarMatrix matrix;
        for (int i = 0; i < 8; ++i)
          for (int j = 0; j < 8; ++j) matrix[i][j] = sum[i][j][lane];
        visit(static_cast<Index>(b) * batch_size + lane, matrix);
      }
    }
  });
}

void Operator::add_lumped_volume(double* volume) const {
  dispatch([&]<class Geometry, Equations E>() {
    const auto& cells = this->geometry<Geometry>();
    for (std::size_t b = 0; b < batches_.size(); ++b) {
      const Geometry geometry(cells[b]);
      Batch value[8], flux[3][8], out[8];
      for (int q = 0; q < 8; ++q) {
        value[q] = typename Geometry::At(geometry, q).weight();
        for (int d = 0; d < 3; ++d) flux[d][q] = Batch(0.0);
      }
      moments(value, flux, out);
      from_modes(out);
      for (int a = 0; a < 8; ++a)
        for (int lane = 0; lane < batches_[b].lanes; ++lane) volume[batches_[b].node[a][lane]] += out[a][lane];
    }
  });
}

double Operator::velocity_squared(const double* u) const {
  double total = 0;
  dispatch([&]<class Geometry, Equations E>() {
    const auto& cells = this->geometry<Geometry>();
    for (std::size_t b = 0; b < batches_.size(); ++b) {
      const Geometry geometry(cells[b]);
      Batch values[4][8];
      gather(batches_[b], u, values);
      const FieldAtPoints<false> field(values);
      Batch sum(0.0);
      for (int q = 0; q < 8; ++q) {
        const typename Geometry::At at(geometry, q);
        for (int i = 0; i < 3; ++i) sum += at.weight() * (field.value[i][q] * field.value[i][q]);
      }
      for (int lane = 0; lane < batches_[b].lanes; ++lane) total += sum[lane];
    }
  });
  return total;
}

double Operator::add_divergence(const double* u, double* divergence) const {
  double total = 0;
  dispatch([&]<class Geometry, Equations E>() {
    const auto& cells = this->geometry<Geometry>();
    for (std::size_t b = 0; b < batches_.size(); ++b) {
      const Geometry geometry(cells[b]);
      Batch values[4][8], out[4][8];
      gather(batches_[b], u, values);
      const FieldAtPoints<false> field(values);
      FluxIntegral integral;
      Batch sum(0.0);
      for (int q = 0; q < 8; ++q) {
        const typename Geometry::At at(geometry, q);
        PointState<Batch> s;
        field.at(at, q, s);
        PointFlux<Batch> flux;
        for (int i = 0; i < 3; ++i) {
          flux.w[i] = flux.grad_q[i] = Batch(0.0);
          for (int j = 0; j < 3; ++j) {
            flux.grad_w[i][j] = Batch(0.0);
            sum += at.weight() * (s.gradient[i][j] * s.gradient[i][j]);
          }
        }
        flux.q = s.gradient[0][0] + s.gradient[1][1] + s.gradient[2][2];
        integral.set(at, q, flux);
      }
      integral.integrate(out);
      scatter(batches_[b], out, divergence);
      for (int lane = 0; lane < batches_[b].lanes; ++lane) total += sum[lane];
    }
  });
  return total;
}

double Operator::largest_rate(const double* u) const {
  double largest = 0;
  for (Index cell = 0; cell < mesh_.local_cells(); ++cell) {
    double v[3];
    center_velocity(cell, u, v);
    const double* k = &inverse_jacobian_[9 * static_cast<std::size_t>(cell)];
    double rate = 0;
    for (int d = 0; d < 3; ++d) rate += 0.5 * std::abs(k[3 * d] * v[0] + k[3 * d + 1] * v[1] + k[3 * d + 2] * v[2]);
    largest = std::max(largest, rate);
  }
  return largest;
}

}  // namespace fbi::fluid
