#include "fsi/pressure_block.hpp"

#include <cmath>

#include "base/counters.hpp"
#include "base/timer.hpp"
#include "linalg/tensor_poisson.hpp"

namespace fbi::fsi {
namespace {

constexpr double robin = 3.0;           // Robin coefficient of the pressure operator at open faces, times 1/h
constexpr double grad_div_part = 0.85;  // of tau_C beside mu in the pressure: inverse masses are lumped
constexpr double viscous_part = 2.0;    // of mu there: where viscosity rules, more of it than of tau_C

}  // namespace

void PressureBlock::renew() {
  const double sigma = fluid_.sigma(), density = fluid_.parameters().density;
  if (fluid_.parameters().pressure_stabilization == fluid::PressureStabilization::projection) {
    renew_projected();
    return;
  }
  // The Schur complement of the momentum rows. The inertial part of PSPG, tau (grad q, rho v'), takes from the
  // divergence what tau (grad q, grad p) adds: together they leave 1/(rho sigma), whatever tau is.
  scale_ = density * sigma;
  if (solver_ != nullptr) return;
  Timed timed("pressure setup");
  count("pressure setups");
  const mesh::HexMesh& mesh = fluid_.mesh();
  if (linalg::TensorPoisson::supports(mesh)) {
    solver_ = std::make_unique<linalg::TensorPoisson>(mesh, robin_ends(1.0));
    return;
  }
  const std::vector<double> one(mesh.local_cells(), 1.0);
  solver_ = std::make_unique<linalg::MultigridPressure>(fluid_.mesh().comm, fluid_.pressure_laplacian(one, robin),
                                                        fluid_.pressure_is_free());
}

std::array<std::array<double, 2>, 3> PressureBlock::robin_ends(double coefficient) const {
  const std::array<std::array<bool, 2>, 3> open = fluid_.open_sides();
  std::array<std::array<double, 2>, 3> ends{};
  for (int d = 0; d < 3; ++d) {
    const std::vector<double>& x = fluid_.mesh().box->coordinates[d];
    if (open[d][0]) ends[d][0] = coefficient * robin / (x[1] - x[0]);
    if (open[d][1]) ends[d][1] = coefficient * robin / (x[x.size() - 1] - x[x.size() - 2]);
  }
  return ends;
}

void PressureBlock::renew_projected() {
  const double inertia = 1.0 / (fluid_.sigma() * fluid_.parameters().density);
  const mesh::HexMesh& mesh = fluid_.mesh();
  const Index cells = mesh.local_cells();
  // The projection's coefficient varies from cell to cell; a box has one for all, the geometric mean.
  double sum = 0.0;
  for (Index c = 0; c < cells; ++c) sum += std::log(fluid_.pressure_projection(c));
  const double mean = std::exp(fluid_.mesh().comm.sum(sum) /
                               static_cast<double>(fluid_.mesh().comm.sum(static_cast<GlobalIndex>(cells))));
  const bool unchanged =
      solver_ != nullptr && scale_ == 1.0 && inertia == inertia_ && std::abs(mean - projection_) <= 0.1 * projection_;
  if (unchanged) return;
  Timed timed("pressure setup");
  count("pressure setups");
  scale_ = 1.0;
  inertia_ = inertia;
  projection_ = mean;
  // On smooth pressures the projection is a Laplacian with the coefficient c h_d^2/12 along direction d.
  if (linalg::TensorPoisson::supports(mesh)) {
    std::array<std::vector<double>, 3> factor;
    for (int d = 0; d < 3; ++d) {
      const std::vector<double>& x = mesh.box->coordinates[d];
      for (std::size_t i = 0; i + 1 < x.size(); ++i)
        factor[d].push_back(inertia + mean * (x[i + 1] - x[i]) * (x[i + 1] - x[i]) / 12.0);
    }
    solver_ = std::make_unique<linalg::TensorPoisson>(mesh, robin_ends(inertia), factor);
    return;
  }
  std::vector<double> coefficient(cells);
  for (Index c = 0; c < cells; ++c)
    coefficient[c] = inertia + fluid_.pressure_projection(c) * std::pow(fluid_.cell_volume(c), 2.0 / 3.0) / 12.0;
  solver_ = std::make_unique<linalg::MultigridPressure>(
      fluid_.mesh().comm, fluid_.pressure_laplacian(coefficient, robin), fluid_.pressure_is_free());
}

void PressureBlock::renew_mass(VelocityWeight& weight, bool demanding) {
  const double same = projection_ > 0.0 ? 1.0 / projection_ : viscous_part * fluid_.parameters().viscosity;
  mass_.assign(fluid_.mesh().owned_nodes, same);
  if (projection_ > 0.0 || !demanding) return;
  const std::vector<double> grad_div = weight.grad_div();
  for (std::size_t a = 0; a < mass_.size(); ++a) mass_[a] += grad_div_part * grad_div[a];
}

}  // namespace fbi::fsi
