#include "linalg/tensor_poisson.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "mesh/exchange.hpp"

namespace fbi::linalg {
namespace {

/// Index range of this rank's owned nodes along each direction; true when they fill that range and nothing else.
bool owned_block(const mesh::HexMesh& mesh, std::array<Index, 3>& begin, std::array<Index, 3>& end) {
  const mesh::Box& box = *mesh.box;
  const std::array<GlobalIndex, 3> n = {static_cast<GlobalIndex>(box.coordinates[0].size()),
                                        static_cast<GlobalIndex>(box.coordinates[1].size()),
                                        static_cast<GlobalIndex>(box.coordinates[2].size())};
  begin = {static_cast<Index>(n[0]), static_cast<Index>(n[1]), static_cast<Index>(n[2])};
  end = {0, 0, 0};
  for (Index a = 0; a < mesh.owned_nodes; ++a) {
    const GlobalIndex id = mesh.node_id[a];
    const GlobalIndex index[3] = {id % n[0], id / n[0] % n[1], id / n[0] / n[1]};
    for (int d = 0; d < 3; ++d) {
      begin[d] = std::min(begin[d], static_cast<Index>(index[d]));
      end[d] = std::max(end[d], static_cast<Index>(index[d]) + 1);
    }
  }
  if (mesh.owned_nodes == 0) return false;
  GlobalIndex size = 1;
  for (int d = 0; d < 3; ++d) size *= end[d] - begin[d];
  return size == mesh.owned_nodes;
}

/// The direction along which ranks are cut: the only one that is not whole, or the longest on a single rank.
int slab_axis(const mesh::HexMesh& mesh) {
  std::array<Index, 3> begin{}, end{};
  const bool block = owned_block(mesh, begin, end);
  int mine = block ? 0 : 8;  // bit d: direction d is cut
  if (block)
    for (int d = 0; d < 3; ++d)
      if (begin[d] != 0 || end[d] != static_cast<Index>(mesh.box->coordinates[d].size())) mine |= 1 << d;
  int all = 0;
  MPI_Allreduce(&mine, &all, 1, MPI_INT, MPI_BOR, mesh.comm.get());
  if (all == 1 || all == 2 || all == 4) return all / 2;
  if (all != 0) return -1;
  int longest = 0;
  for (int d = 1; d < 3; ++d)
    if (mesh.box->coordinates[d].size() > mesh.box->coordinates[longest].size()) longest = d;
  return longest;
}

}  // namespace

bool TensorPoisson::supports(const mesh::HexMesh& mesh) {
  if (!mesh.box || mesh.has_images()) return false;
  const int axis = slab_axis(mesh);
  if (axis < 0) return false;
  // Slabs must follow each other in rank order.
  std::array<Index, 3> begin{}, end{};
  owned_block(mesh, begin, end);
  GlobalIndex planes = end[axis] - begin[axis];
  return !mesh.comm.any(mesh.comm.sum_before(planes) != begin[axis]);
}

std::pair<VecHandle, VecHandle> TensorPoisson::create_vectors() const {
  std::pair<VecHandle, VecHandle> vectors;
  FBI_PETSC(VecCreateMPI(comm_.get(), static_cast<PetscInt>(position_.size()), PETSC_DETERMINE, vectors.first.out()));
  FBI_PETSC(VecDuplicate(vectors.first, vectors.second.out()));
  return vectors;
}

TensorPoisson::Line TensorPoisson::make_line(const std::vector<double>& coordinates, const std::array<double, 2>& robin,
                                             const std::vector<double>& factor) {
  const std::size_t n = coordinates.size();
  Line line;
  line.k_diagonal.assign(n, 0.0);
  line.m_diagonal.assign(n, 0.0);
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double h = coordinates[i + 1] - coordinates[i];
    const double k = (factor.empty() ? 1.0 : factor[i]) / h;
    line.k_diagonal[i] += k;
    line.k_diagonal[i + 1] += k;
    line.k_off.push_back(-k);
    line.m_diagonal[i] += h / 3.0;
    line.m_diagonal[i + 1] += h / 3.0;
    line.m_off.push_back(h / 6.0);
  }
  line.k_diagonal.front() += robin[0];
  line.k_diagonal.back() += robin[1];
  return line;
}

TensorPoisson::TensorPoisson(const mesh::HexMesh& mesh, const std::array<std::array<double, 2>, 3>& robin,
                             const std::array<std::vector<double>, 3>& factor)
    : comm_(mesh.comm), axis_(slab_axis(mesh)), nodes_(mesh.global_nodes) {
  singular_ =
      std::all_of(robin.begin(), robin.end(), [](const auto& ends) { return ends[0] == 0.0 && ends[1] == 0.0; });
  std::array<Index, 3> begin{}, end{};
  owned_block(mesh, begin, end);
  const int d1 = axis_ == 0 ? 1 : 0, d2 = axis_ == 2 ? 1 : 2;
  const mesh::Box& box = *mesh.box;
  planes_ = end[axis_] - begin[axis_];
  n1_ = static_cast<Index>(box.coordinates[d1].size());
  n2_ = static_cast<Index>(box.coordinates[d2].size());
  position_.resize(mesh.owned_nodes);
  const std::array<GlobalIndex, 3> n = {static_cast<GlobalIndex>(box.coordinates[0].size()),
                                        static_cast<GlobalIndex>(box.coordinates[1].size()), 0};
  for (Index a = 0; a < mesh.owned_nodes; ++a) {
    const GlobalIndex id = mesh.node_id[a];
    const std::array<GlobalIndex, 3> index = {id % n[0], id / n[0] % n[1], id / n[0] / n[1]};
    position_[a] = static_cast<Index>(((index[axis_] - begin[axis_]) * n1_ + index[d1]) * n2_ + index[d2]);
  }

  const auto diagonalise = [&](int d, Matrix& q) {
    const Line line = make_line(box.coordinates[d], robin[d], factor[d]);
    const Index size = static_cast<Index>(line.k_diagonal.size());
    Eigen::MatrixXd k = Eigen::MatrixXd::Zero(size, size), m = k;
    for (Index i = 0; i < size; ++i) {
      k(i, i) = line.k_diagonal[i];
      m(i, i) = line.m_diagonal[i];
      if (i + 1 == size) continue;
      k(i, i + 1) = k(i + 1, i) = line.k_off[i];
      m(i, i + 1) = m(i + 1, i) = line.m_off[i];
    }
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(k, m);
    q = solver.eigenvectors();
    return Eigen::VectorXd(solver.eigenvalues());
  };
  const Eigen::VectorXd lambda1 = diagonalise(d1, q1_), lambda2 = diagonalise(d2, q2_);
  line_ = make_line(box.coordinates[axis_], robin[axis_], factor[axis_]);

  const Index all_modes = n1_ * n2_;
  const int ranks = comm_.size();
  std::vector<int> planes(ranks);
  const int mine = planes_;
  MPI_Allgather(&mine, 1, MPI_INT, planes.data(), 1, MPI_INT, comm_.get());
  first_mode_ = static_cast<Index>(mesh::even_begin(all_modes, comm_.rank(), ranks));
  modes_ = static_cast<Index>(mesh::even_begin(all_modes, comm_.rank() + 1, ranks)) - first_mode_;
  send_begin_.assign(1, 0);
  receive_begin_.assign(1, 0);
  for (int r = 0; r < ranks; ++r) {
    const GlobalIndex count = mesh::even_begin(all_modes, r + 1, ranks) - mesh::even_begin(all_modes, r, ranks);
    send_count_.push_back(static_cast<int>(count) * planes_);
    receive_count_.push_back(modes_ * planes[r]);
    send_begin_.push_back(send_begin_.back() + send_count_.back());
    receive_begin_.push_back(receive_begin_.back() + receive_count_.back());
  }

  for (Index mode = first_mode_; mode < first_mode_ + modes_; ++mode)
    eigenvalue_.push_back(lambda1[mode / n2_] + lambda2[mode % n2_]);
  if (singular_ && first_mode_ == 0 && modes_ > 0)
    eigenvalue_[0] = 0.0;  // exactly: round-off must not decide the level
  const std::size_t length = line_.k_diagonal.size();
  inverse_pivot_.resize(length * modes_);
  for (Index m = 0; m < modes_; ++m) {
    double previous = 0.0;  // 1/pivot of the line before
    for (std::size_t i = 0; i < length; ++i) {
      const double below = i > 0 ? line_.k_off[i - 1] + eigenvalue_[m] * line_.m_off[i - 1] : 0.0;
      double pivot = line_.k_diagonal[i] + eigenvalue_[m] * line_.m_diagonal[i] - below * below * previous;
      // The constant mode of the singular problem: fix the level at the first node; compatible right-hand sides notice
      // nothing.
      if (singular_ && first_mode_ + m == 0 && i == 0) pivot *= 2.0;
      previous = 1.0 / pivot;
      inverse_pivot_[i * modes_ + m] = previous;
    }
  }
  field_.resize(static_cast<std::size_t>(planes_) * all_modes);
  sent_.resize(field_.size());
  lines_.resize(length * modes_);
}

void TensorPoisson::apply(Vec b, Vec x) {
  const Index all_modes = n1_ * n2_;
  const int ranks = comm_.size();
  {
    const double* values = nullptr;
    FBI_PETSC(VecGetArrayRead(b, &values));
    double mean = 0.0;
    if (singular_) {
      for (std::size_t a = 0; a < position_.size(); ++a) mean += values[a];
      mean = comm_.sum(mean) / static_cast<double>(nodes_);
    }
    for (std::size_t a = 0; a < position_.size(); ++a) field_[position_[a]] = values[a] - mean;
    FBI_PETSC(VecRestoreArrayRead(b, &values));
  }
  Matrix half(n1_, n2_);
  for (Index plane = 0; plane < planes_; ++plane) {
    Eigen::Map<Matrix> values(&field_[static_cast<std::size_t>(plane) * all_modes], n1_, n2_);
    half.noalias() = values * q2_;
    values.noalias() = q1_.transpose() * half;
  }
  // Planes of all modes -> lines of this rank's modes.
  double* lines = field_.data();
  if (ranks > 1) {
    for (int r = 0; r < ranks; ++r) {
      const Index count = planes_ > 0 ? send_count_[r] / planes_ : 0;
      const Index first = static_cast<Index>(mesh::even_begin(all_modes, r, ranks));
      for (Index plane = 0; plane < planes_; ++plane)
        std::copy_n(&field_[static_cast<std::size_t>(plane) * all_modes + first], count,
                    &sent_[send_begin_[r] + static_cast<std::size_t>(plane) * count]);
    }
    MPI_Alltoallv(sent_.data(), send_count_.data(), send_begin_.data(), MPI_DOUBLE, lines_.data(),
                  receive_count_.data(), receive_begin_.data(), MPI_DOUBLE, comm_.get());
    lines = lines_.data();
  }
  const std::size_t length = line_.k_diagonal.size();
  for (std::size_t i = 0; i < length; ++i) {
    double* row = lines + i * modes_;
    const double* inverse = &inverse_pivot_[i * modes_];
    if (i == 0) {
      for (Index m = 0; m < modes_; ++m) row[m] *= inverse[m];
      continue;
    }
    const double* before = row - modes_;
    const double k = line_.k_off[i - 1], mass = line_.m_off[i - 1];
    for (Index m = 0; m < modes_; ++m) row[m] = (row[m] - (k + eigenvalue_[m] * mass) * before[m]) * inverse[m];
  }
  for (std::size_t i = length - 1; i-- > 0;) {
    double* row = lines + i * modes_;
    const double* after = row + modes_;
    const double* inverse = &inverse_pivot_[i * modes_];
    const double k = line_.k_off[i], mass = line_.m_off[i];
    for (Index m = 0; m < modes_; ++m) row[m] -= (k + eigenvalue_[m] * mass) * inverse[m] * after[m];
  }
  if (ranks > 1) {
    MPI_Alltoallv(lines_.data(), receive_count_.data(), receive_begin_.data(), MPI_DOUBLE, sent_.data(),
                  send_count_.data(), send_begin_.data(), MPI_DOUBLE, comm_.get());
    for (int r = 0; r < ranks; ++r) {
      const Index count = planes_ > 0 ? send_count_[r] / planes_ : 0;
      const Index first = static_cast<Index>(mesh::even_begin(all_modes, r, ranks));
      for (Index plane = 0; plane < planes_; ++plane)
        std::copy_n(&sent_[send_begin_[r] + static_cast<std::size_t>(plane) * count], count,
                    &field_[static_cast<std::size_t>(plane) * all_modes + first]);
    }
  }
  for (Index plane = 0; plane < planes_; ++plane) {
    Eigen::Map<Matrix> values(&field_[static_cast<std::size_t>(plane) * all_modes], n1_, n2_);
    half.noalias() = q1_ * values;
    values.noalias() = half * q2_.transpose();
  }
  double* out = nullptr;
  FBI_PETSC(VecGetArray(x, &out));
  for (std::size_t a = 0; a < position_.size(); ++a) out[a] = field_[position_[a]];
  FBI_PETSC(VecRestoreArray(x, &out));
}

}  // namespace fbi::linalg
