#include "fsi/velocity_weight.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/counters.hpp"
#include "base/node_vector.hpp"
#include "base/timer.hpp"
#include "fem/hex8.hpp"
#include "linalg/vector_access.hpp"

namespace fbi::fsi {

using linalg::GhostedForm;
using linalg::Read;
using linalg::Write;

Mat3 middle_edges(const mesh::HexMesh& mesh, Index cell) {
  Eigen::Matrix<double, 3, 8> corners;
  for (int a = 0; a < 8; ++a)
    corners.col(a) = Eigen::Map<const Vec3>(mesh.node(mesh.cells[8 * static_cast<std::size_t>(cell) + a]));
  return 2.0 * corners * fem::hex8_gradient(Vec3::Zero());
}

VelocityWeight::VelocityWeight(fluid::FluidField& fluid) : fluid_(fluid), work_(fluid.create_vector()) {
  const mesh::HexMesh& mesh = fluid_.mesh();
  for (Index c = 0; c < mesh.local_cells(); ++c) {
    const Mat3 edges = middle_edges(mesh, c);
    const double volume = std::abs(edges.determinant());
    double inverse_squares = 0.0;
    for (int i = 0; i < 3; ++i) inverse_squares += 1.0 / edges.col(i).squaredNorm();
    cell_size_.push_back(std::cbrt(volume));
    cell_diffusion_.push_back(volume / 9.0 * inverse_squares);  // int |grad N_a|^2, exact on boxes
  }
}

bool VelocityWeight::renew() {
  // Without convection W depends on the time step alone.
  if (fluid_.parameters().convective_form == fluid::ConvectiveForm::none && sigma_ == fluid_.sigma()) return false;
  sigma_ = fluid_.sigma();
  Timed timed("velocity weight");
  count("velocity weights");
  const mesh::HexMesh& mesh = fluid_.mesh();
  const fluid::FluidParameters& parameters = fluid_.parameters();
  const double sigma = fluid_.sigma(), density = parameters.density, viscosity = parameters.viscosity;
  const bool convective = parameters.convective_form != fluid::ConvectiveForm::none;
  const std::vector<double>& tau = fluid_.tau_m();
  share_.resize(cell_size_.size());
  values_.clear();
  strength_ = 0.0;
  flow_.resize(cell_size_.size());
  {
    GhostedForm form(fluid_.iterate());
    Read velocity(form.get());
    for (Index c = 0; c < mesh.local_cells(); ++c) {
      const Index* nodes = &mesh.cells[8 * static_cast<std::size_t>(c)];
      const double h = cell_size_[c];
      double speed = 0.0, reaction = 0.0;
      CellFlow& flow = flow_[c];
      if (convective) {
        // Mean velocity and, from the spread around it, the size of its differences across the cell.
        NodeVector<double> sum = {}, square_sum = {};
        for (int a = 0; a < 8; ++a) {
          const NodeVector<double> at = load_node(velocity.get() + 4 * static_cast<std::size_t>(nodes[a]));
          sum += at;
          square_sum += at * at;
        }
        const Vec3 v = 0.125 * Vec3(sum[0], sum[1], sum[2]);
        const double squares = 0.125 * (square_sum[0] + square_sum[1] + square_sum[2]);
        speed = v.norm();
        flow.velocity = v;
        flow.difference = 2.0 * std::sqrt(std::max(0.0, squares - v.squaredNorm()));
        // rho (v.grad) dv and rho (dv.grad) v
        reaction = density * (speed + flow.difference) / h;
      }
      // One direction in three is streamline, and grad-div acts on one mode in three.
      const double streamline = density * density * tau[c] * speed * speed;
      flow.grad_div = parameters.tau != fluid::Tau::franca_valentin ? fluid_.tau_c(c)
                      : parameters.grad_div                         ? 0.5 * density * speed * h
                                                                    : 0.0;
      const double diffusion = (viscosity + (streamline + flow.grad_div) / 3.0) * cell_diffusion_[c];
      share_[c] = diffusion + 0.125 * reaction * h * h * h;
      strength_ = std::max(strength_, share_[c] / (0.125 * density * sigma * h * h * h));
    }
  }
  strength_ = mesh.comm.max(strength_);
  return true;
}

const std::vector<double>& VelocityWeight::values() {
  if (!values_.empty()) return values_;
  const double inertia = fluid_.parameters().density * sigma_;
  const std::vector<double>& volume = fluid_.lumped_volume();
  const std::vector<char>& dirichlet = fluid_.is_dirichlet();
  const mesh::HexMesh& mesh = fluid_.mesh();
  std::vector<double> diagonal(mesh.local_nodes(), 0.0);
  for (std::size_t c = 0; c < share_.size(); ++c)
    for (std::size_t k = 8 * c; k < 8 * c + 8; ++k) diagonal[mesh.cells[k]] += share_[c];
  complete_ghosts(diagonal);
  values_.resize(3 * diagonal.size());
  for (std::size_t a = 0; a < diagonal.size(); ++a) {
    const double inverse = 1.0 / (inertia * volume[a] + diagonal[a]);
    for (int i = 0; i < 3; ++i) values_[3 * a + i] = dirichlet[4 * a + i] != 0 ? 0.0 : inverse;
  }
  return values_;
}

std::vector<double> VelocityWeight::grad_div() {
  const mesh::HexMesh& mesh = fluid_.mesh();
  std::vector<double> nodal(mesh.local_nodes(), 0.0);
  for (Index c = 0; c < mesh.local_cells(); ++c) {
    const double share = 0.125 * flow_[c].grad_div * fluid_.cell_volume(c);
    for (std::size_t k = 8 * static_cast<std::size_t>(c); k < 8 * static_cast<std::size_t>(c) + 8; ++k)
      nodal[mesh.cells[k]] += share;
  }
  complete_ghosts(nodal);
  for (std::size_t a = 0; a < nodal.size(); ++a) nodal[a] /= fluid_.lumped_volume()[a];
  return nodal;
}

void VelocityWeight::complete_ghosts(std::vector<double>& nodal) {
  const Index nodes = fluid_.mesh().local_nodes();
  {
    GhostedForm form(work_);
    Write to(form.get());
    for (Index a = 0; a < nodes; ++a)
      for (int i = 0; i < 4; ++i) to.get()[4 * static_cast<std::size_t>(a) + i] = i == 0 ? nodal[a] : 0.0;
  }
  FBI_PETSC(VecGhostUpdateBegin(work_, ADD_VALUES, SCATTER_REVERSE));
  FBI_PETSC(VecGhostUpdateEnd(work_, ADD_VALUES, SCATTER_REVERSE));
  FBI_PETSC(VecGhostUpdateBegin(work_, INSERT_VALUES, SCATTER_FORWARD));
  FBI_PETSC(VecGhostUpdateEnd(work_, INSERT_VALUES, SCATTER_FORWARD));
  GhostedForm form(work_);
  Read from(form.get());
  for (Index a = 0; a < nodes; ++a) nodal[a] = from.get()[4 * static_cast<std::size_t>(a)];
}

}  // namespace fbi::fsi
