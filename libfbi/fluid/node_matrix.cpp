#include "fluid/node_matrix.hpp"

#include <algorithm>

namespace fbi::fluid {

NodeMatrix::NodeMatrix(const mesh::HexMesh& mesh, int block) : mesh_(mesh), block_(block) {
  const std::size_t nodes = mesh.local_nodes(), cells = mesh.local_cells();
  std::vector<std::size_t> first_cell(nodes + 1, 0);
  for (Index node : mesh.cells) ++first_cell[node + 1];
  for (std::size_t n = 0; n < nodes; ++n) first_cell[n + 1] += first_cell[n];
  std::vector<Index> cell_of(mesh.cells.size());
  std::vector<std::size_t> fill(first_cell.begin(), first_cell.end() - 1);
  for (std::size_t k = 0; k < mesh.cells.size(); ++k) cell_of[fill[mesh.cells[k]]++] = static_cast<Index>(k / 8);

  row_start_.assign(1, 0);
  std::vector<Index> row;
  for (std::size_t n = 0; n < nodes; ++n) {
    row.clear();
    for (std::size_t k = first_cell[n]; k < first_cell[n + 1]; ++k)
      for (int a = 0; a < 8; ++a) row.push_back(mesh.cells[8 * static_cast<std::size_t>(cell_of[k]) + a]);
    std::sort(row.begin(), row.end());
    row.erase(std::unique(row.begin(), row.end()), row.end());
    column_.insert(column_.end(), row.begin(), row.end());
    row_start_.push_back(column_.size());
  }
  position_.resize(64 * cells);
  for (std::size_t cell = 0; cell < cells; ++cell)
    for (int a = 0; a < 8; ++a) {
      const Index n = mesh.cells[8 * cell + a];
      const auto begin = column_.begin() + static_cast<std::ptrdiff_t>(row_start_[n]);
      const auto end = column_.begin() + static_cast<std::ptrdiff_t>(row_start_[n + 1]);
      for (int b = 0; b < 8; ++b)
        position_[64 * cell + 8 * a + b] =
            static_cast<std::size_t>(std::lower_bound(begin, end, mesh.cells[8 * cell + b]) - column_.begin());
    }
  values_.assign(block_ * block_ * column_.size(), 0.0);
}

void NodeMatrix::clear() { std::fill(values_.begin(), values_.end(), 0.0); }

void NodeMatrix::set_dirichlet(const std::vector<char>& is_dirichlet) {
  for (std::size_t n = 0; n + 1 < row_start_.size(); ++n)
    for (std::size_t k = row_start_[n]; k < row_start_[n + 1]; ++k)
      for (std::size_t i = 0; i < block_; ++i)
        for (std::size_t j = 0; j < block_; ++j) {
          const std::size_t row = block_ * n + i, column = block_ * static_cast<std::size_t>(column_[k]) + j;
          double& value = values_[block_ * block_ * k + block_ * i + j];
          if (is_dirichlet[row] || is_dirichlet[column])
            value = row == column && static_cast<Index>(n) < mesh_.owned_nodes ? 1.0 : 0.0;
        }
}

void NodeMatrix::set_normals(const std::vector<NormalConstraint>& constraints) {
  if (constraints.empty()) return;
  std::vector<const NormalConstraint*> at(row_start_.size() - 1, nullptr);
  for (const NormalConstraint& c : constraints) at[c.node] = &c;
  const auto remove = [](const NormalConstraint& c, double* values, std::size_t stride) {
    const Vec3 v = c.without(Vec3(values[0], values[stride], values[2 * stride]));
    for (int i = 0; i < 3; ++i) values[i * stride] = v[i];
  };
  for (std::size_t n = 0; n + 1 < row_start_.size(); ++n)
    for (std::size_t k = row_start_[n]; k < row_start_[n + 1]; ++k) {
      double* block = &values_[block_ * block_ * k];
      const NormalConstraint* column = at[column_[k]];
      for (std::size_t j = 0; at[n] != nullptr && j < block_; ++j) remove(*at[n], block + j, block_);
      for (std::size_t i = 0; column != nullptr && i < block_; ++i) remove(*column, block + block_ * i, 1);
      if (at[n] == nullptr || static_cast<Index>(n) != column_[k] || static_cast<Index>(n) >= mesh_.owned_nodes)
        continue;
      for (const Vec3& d : at[n]->direction)
        for (int i = 0; i < 3; ++i)
          for (int j = 0; j < 3; ++j) block[block_ * i + j] += d[i] * d[j];
    }
}

linalg::MatHandle NodeMatrix::finish() {
  if (!matrix_) {
    const PetscInt b = static_cast<PetscInt>(block_), owned = b * mesh_.owned_nodes;
    FBI_PETSC(MatCreate(mesh_.comm.get(), matrix_.out()));
    FBI_PETSC(MatSetSizes(matrix_, owned, owned, PETSC_DETERMINE, PETSC_DETERMINE));
    FBI_PETSC(MatSetType(matrix_, MATAIJ));
    FBI_PETSC(MatSetBlockSize(matrix_, b));
    std::vector<PetscInt> rows(values_.size()), columns(values_.size());
    std::size_t k = 0;
    for (std::size_t n = 0; n + 1 < row_start_.size(); ++n)
      for (std::size_t pair = row_start_[n]; pair < row_start_[n + 1]; ++pair)
        for (PetscInt i = 0; i < b; ++i)
          for (PetscInt j = 0; j < b; ++j, ++k) {
            rows[k] = b * static_cast<PetscInt>(mesh_.node_number[n]) + i;
            columns[k] = b * static_cast<PetscInt>(mesh_.node_number[column_[pair]]) + j;
          }
    FBI_PETSC(MatSetPreallocationCOO(matrix_, static_cast<PetscCount>(k), rows.data(), columns.data()));
  }
  FBI_PETSC(MatSetValuesCOO(matrix_, values_.data(), INSERT_VALUES));
  FBI_PETSC(PetscObjectReference(reinterpret_cast<PetscObject>(matrix_.get())));
  return linalg::MatHandle(matrix_.get());
}

}  // namespace fbi::fluid
