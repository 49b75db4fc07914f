#include "fluid/divergence_free.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "fluid/ghosted.hpp"
#include "linalg/vector_access.hpp"

namespace fbi::fluid {
namespace {

constexpr double tolerance = 1e-3;  // of the linear system of a pass
constexpr int most_iterations = 200, most_passes = 20;
constexpr double enough = 1e-8;           // of the divergence at the start
constexpr double laplacian_share = 0.05;  // of L in the operator

/// D, M^-1 and D^T on the nodes of a rank; scalar fields hold one number per owned node.
class Divergence {
 public:
  Divergence(const mesh::HexMesh& mesh, const Operator& cells, const std::vector<char>& is_dirichlet,
             const std::vector<double>& lumped_volume)
      : mesh_(mesh),
        cells_(cells),
        is_dirichlet_(is_dirichlet),
        volume_(lumped_volume),
        velocity_(create_ghosted(mesh)),
        sum_(create_ghosted(mesh)),
        rest_(4 * static_cast<std::size_t>(mesh.local_nodes()), 0.0) {}

  /// d = D v of a ghosted vector.
  void divergence(Vec v, std::vector<double>& d) {
    {
      LocalArray u(v), s(sum_);
      std::fill_n(s.data(), rest_.size(), 0.0);
      cells_.add_divergence(u.data(), s.data());
    }
    add_ghosts(sum_);
    LocalArray s(sum_);
    d.resize(static_cast<std::size_t>(mesh_.owned_nodes));
    for (std::size_t n = 0; n < d.size(); ++n) d[n] = s[4 * n + 3];
  }

  /// M^-1 D^T phi, zero in given components; ghosts up to date.
  Vec velocity_of(const std::vector<double>& phi) {
    {
      LocalArray w(velocity_);
      for (std::size_t n = 0; n < phi.size(); ++n) {
        for (int i = 0; i < 3; ++i) w[4 * n + i] = 0.0;
        w[4 * n + 3] = phi[n];
      }
    }
    update_ghosts(velocity_);
    {
      LocalArray w(velocity_), s(sum_);
      std::fill_n(s.data(), rest_.size(), 0.0);
      cells_.add_residual(w.data(), rest_.data(), s.data());  // of a pressure alone: -(div w, phi) in momentum rows
    }
    add_ghosts(sum_);
    {
      LocalArray w(velocity_), s(sum_);
      for (std::size_t n = 0; n < phi.size(); ++n) {
        for (int i = 0; i < 3; ++i) w[4 * n + i] = is_dirichlet_[4 * n + i] != 0 ? 0.0 : -s[4 * n + i] / volume_[n];
        w[4 * n + 3] = 0.0;
      }
    }
    update_ghosts(velocity_);
    return velocity_;
  }

  double dot(const std::vector<double>& a, const std::vector<double>& b) const {
    double sum = 0;
    for (std::size_t n = 0; n < a.size(); ++n) sum += a[n] * b[n];
    return mesh_.comm.sum(sum);
  }
  /// Norm of a D v, weighted to be one of the function div v.
  double size(const std::vector<double>& d) const {
    double sum = 0;
    for (std::size_t n = 0; n < d.size(); ++n) sum += d[n] * d[n] / volume_[n];
    return std::sqrt(mesh_.comm.sum(sum));
  }

 private:
  const mesh::HexMesh& mesh_;
  const Operator& cells_;
  const std::vector<char>& is_dirichlet_;
  const std::vector<double>& volume_;
  linalg::VecHandle velocity_, sum_;
  std::vector<double> rest_;
};

/// Subtracts the mean of all nodes: a net flux through the boundary cannot be balanced.
void remove_mean(const mesh::HexMesh& mesh, std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  const double mean = mesh.comm.sum(sum) / static_cast<double>(mesh.global_nodes);
  for (double& value : values) value -= mean;
}

}  // namespace

Projection remove_divergence(const mesh::HexMesh& mesh, const Operator& cells, const std::vector<char>& is_dirichlet,
                             const std::vector<double>& lumped_volume, linalg::MatHandle laplacian, bool singular,
                             Vec u) {
  Divergence operators(mesh, cells, is_dirichlet, lumped_volume);
  const Mat matrix = laplacian.get();
  linalg::MultigridPressure preconditioner(mesh.comm, std::move(laplacian), singular);  // keeps the matrix
  linalg::VecHandle in, out;
  FBI_PETSC(VecCreateMPI(mesh.comm.get(), mesh.owned_nodes, mesh.global_nodes, in.out()));
  FBI_PETSC(VecDuplicate(in, out.out()));
  const auto apply = [&](const std::vector<double>& x, const auto& action, std::vector<double>& y) {
    {
      linalg::Write to(in);
      std::copy(x.begin(), x.end(), to.get());
    }
    action();
    linalg::Read from(out);
    y.assign(from.get(), from.get() + x.size());
  };
  const auto precondition = [&]() { preconditioner.apply(in, out); };
  const auto multiply = [&]() { FBI_PETSC(MatMult(matrix, in, out)); };

  Projection report;
  std::vector<double> d, residual, z, direction, product, smooth, phi;
  operators.divergence(u, d);
  report.before = report.after = operators.size(d);
  for (int pass = 0; pass < most_passes && report.after > enough * report.before; ++pass) {
    residual = d;
    if (singular) remove_mean(mesh, residual);
    const double start = operators.size(residual);
    phi.assign(d.size(), 0.0);
    direction.assign(d.size(), 0.0);
    double rho = 0;
    for (int k = 0; k < most_iterations && operators.size(residual) > tolerance * start; ++k) {
      apply(residual, precondition, z);
      const double rho_new = operators.dot(residual, z);
      const double beta = rho > 0 ? rho_new / rho : 0.0;
      for (std::size_t n = 0; n < z.size(); ++n) direction[n] = z[n] + beta * direction[n];
      rho = rho_new;
      operators.divergence(operators.velocity_of(direction), product);
      apply(direction, multiply, smooth);
      for (std::size_t n = 0; n < product.size(); ++n)
        product[n] = (1 - laplacian_share) * product[n] + laplacian_share * smooth[n];
      const double curvature = operators.dot(direction, product);
      if (!(curvature > 0)) break;
      for (std::size_t n = 0; n < phi.size(); ++n) {
        phi[n] += rho / curvature * direction[n];
        residual[n] -= rho / curvature * product[n];
      }
      ++report.iterations;
    }
    {
      LocalArray correction(operators.velocity_of(phi)), v(u);
      for (std::size_t k = 0; k < 4 * static_cast<std::size_t>(mesh.local_nodes()); ++k) v[k] -= correction[k];
    }
    operators.divergence(u, d);
    const double last = report.after;
    report.after = operators.size(d);
    if (!(report.after < 0.5 * last)) break;
  }
  return report;
}

}  // namespace fbi::fluid
