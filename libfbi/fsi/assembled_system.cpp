#include "fsi/assembled_system.hpp"

#include <algorithm>

#include "base/timer.hpp"
#include "linalg/vector_access.hpp"

namespace fbi::fsi {
namespace {

/// to += from for parts of matrices on this rank; the columns of every row of `from` are among those of `to`. Columns
/// are compared through `from_number` and `to_number` where given (ascending).
void add_part(Mat from, Mat to, const PetscInt* from_number, const PetscInt* to_number) {
  PetscInt rows = 0;
  const PetscInt *from_begin = nullptr, *from_column = nullptr, *to_begin = nullptr, *to_column = nullptr;
  const PetscScalar* from_value = nullptr;
  PetscScalar* to_value = nullptr;
  PetscBool done = PETSC_FALSE;
  FBI_PETSC(MatGetRowIJ(from, 0, PETSC_FALSE, PETSC_FALSE, &rows, &from_begin, &from_column, &done));
  FBI_PETSC(MatGetRowIJ(to, 0, PETSC_FALSE, PETSC_FALSE, &rows, &to_begin, &to_column, &done));
  FBI_PETSC(MatSeqAIJGetArrayRead(from, &from_value));
  FBI_PETSC(MatSeqAIJGetArray(to, &to_value));
  for (PetscInt row = 0; row < rows; ++row) {
    PetscInt k = to_begin[row];
    for (PetscInt i = from_begin[row]; i < from_begin[row + 1]; ++i) {
      const PetscInt column = from_number != nullptr ? from_number[from_column[i]] : from_column[i];
      while ((to_number != nullptr ? to_number[to_column[k]] : to_column[k]) != column) ++k;
      to_value[k] += from_value[i];
    }
  }
  FBI_PETSC(MatSeqAIJRestoreArray(to, &to_value));
  FBI_PETSC(MatSeqAIJRestoreArrayRead(from, &from_value));
  FBI_PETSC(MatRestoreRowIJ(to, 0, PETSC_FALSE, PETSC_FALSE, &rows, &to_begin, &to_column, &done));
  FBI_PETSC(MatRestoreRowIJ(from, 0, PETSC_FALSE, PETSC_FALSE, &rows, &from_begin, &from_column, &done));
}

/// to += from for distributed matrices of the same layout whose patterns are contained in one another; much faster than
/// setting entries one by one.
void add_subset(Mat from, Mat to) {
  PetscBool parallel = PETSC_FALSE;
  FBI_PETSC(PetscObjectTypeCompare(reinterpret_cast<PetscObject>(to), MATMPIAIJ, &parallel));
  if (parallel == PETSC_FALSE) {
    add_part(from, to, nullptr, nullptr);
    return;
  }
  Mat from_own = nullptr, from_other = nullptr, to_own = nullptr, to_other = nullptr;
  const PetscInt *from_number = nullptr, *to_number = nullptr;
  FBI_PETSC(MatMPIAIJGetSeqAIJ(from, &from_own, &from_other, &from_number));
  FBI_PETSC(MatMPIAIJGetSeqAIJ(to, &to_own, &to_other, &to_number));
  add_part(from_own, to_own, nullptr, nullptr);
  add_part(from_other, to_other, from_number, to_number);
}

/// An AIJ matrix of `rows` by `columns` on this rank from entries (i, j, v), global numbers; repeated ones are summed.
void create_matrix(const Comm& comm, PetscInt rows, PetscInt columns, std::vector<PetscInt> i, std::vector<PetscInt> j,
                   const std::vector<double>& v, linalg::MatHandle& matrix) {
  FBI_PETSC(MatCreate(comm.get(), matrix.out()));
  FBI_PETSC(MatSetSizes(matrix, rows, columns, PETSC_DETERMINE, PETSC_DETERMINE));
  FBI_PETSC(MatSetType(matrix, MATAIJ));
  FBI_PETSC(MatSetPreallocationCOO(matrix, static_cast<PetscCount>(i.size()), i.data(), j.data()));
  FBI_PETSC(MatSetValuesCOO(matrix, v.data(), INSERT_VALUES));
}

/// Rows of this rank that S couples, block by block; a row that is coupled to no other is a block of its own.
std::vector<std::vector<Index>> interface_blocks(const coupling::InterfaceOperator& interface) {
  std::vector<std::vector<Index>> blocks;
  for (Index f = 0; f < interface.fibers(); ++f) {
    if (interface.is_joined(f)) continue;
    const Index first = interface.first_row_of(f), end = interface.first_row_of(f + 1);
    if (!interface.is_local(f)) blocks.emplace_back();
    for (Index p = first; p < end; ++p) {
      if (interface.is_local(f)) blocks.emplace_back();
      blocks.back().push_back(p);
    }
  }
  for (Index g = 0; g < interface.groups(); ++g)
    if (interface.joined_block(g).size() > 0) blocks.push_back(interface.joined_rows(g));
  return blocks;
}

}  // namespace

AssembledSystem::AssembledSystem(fluid::FluidField& fluid, const coupling::Coupling* coupling,
                                 const coupling::InterfaceOperator* interface, const SolverParameters& parameters)
    : fluid_(fluid),
      coupling_(coupling),
      interface_(interface),
      comm_(fluid.mesh().comm),
      solver_(comm_, parameters.ilu_level, parameters.gmres_restart, 10 * parameters.krylov_iterations),
      row_scale_(fluid.create_vector()) {}

/// M with the columns of given velocities dropped and those of walls projected: 3 rows a multiplier row.
void AssembledSystem::assemble_m() {
  const mesh::HexMesh& mesh = fluid_.mesh();
  const coupling::LocalM& m = coupling_->local_m();
  const std::vector<char>& dirichlet = fluid_.is_dirichlet();
  const bool normals = fluid_.has_normal_constraints();
  std::vector<PetscInt> i, j;
  std::vector<double> v;
  for (std::size_t p = 0; p < m.row.size(); ++p)
    for (Index k = m.begin[p]; k < m.begin[p + 1]; ++k) {
      const Mat3 free = normals ? fluid_.free_directions(m.node[k]) : Mat3::Identity();
      for (int d = 0; d < 3; ++d) {
        if (dirichlet[4 * static_cast<std::size_t>(m.node[k]) + d] != 0) continue;
        for (int e = 0; e < 3; ++e) {
          if (free(d, e) == 0.0) continue;
          i.push_back(static_cast<PetscInt>(3 * m.row[p] + e));
          j.push_back(static_cast<PetscInt>(4 * mesh.node_number[m.node[k]] + d));
          v.push_back(free(d, e) * m.value[k]);
        }
      }
    }
  create_matrix(comm_, 3 * coupling_->rows(), 4 * mesh.owned_nodes, std::move(i), std::move(j), v, m_);
}

/// S^-1 as a matrix, column by column of all blocks at once. Returns whether its pattern changed on any rank.
bool AssembledSystem::assemble_inverse() {
  const std::vector<std::vector<Index>> blocks = interface_blocks(*interface_);
  const PetscInt rows = 3 * coupling_->rows(), first = static_cast<PetscInt>(3 * coupling_->first_row());
  std::size_t widest = 0;
  for (const std::vector<Index>& block : blocks) widest = std::max(widest, 3 * block.size());
  std::vector<double> column(rows), values;
  std::vector<PetscInt> i, j;
  const auto number = [](const std::vector<Index>& block, std::size_t a) {
    return 3 * static_cast<PetscInt>(block[a / 3]) + static_cast<PetscInt>(a % 3);
  };
  for (std::size_t b = 0; b < widest; ++b) {
    std::fill(column.begin(), column.end(), 0.0);
    for (const std::vector<Index>& block : blocks)
      if (b < 3 * block.size()) column[number(block, b)] = 1.0;
    interface_->solve(column.data());
    for (const std::vector<Index>& block : blocks)
      for (std::size_t a = 0; b < 3 * block.size() && a < 3 * block.size(); ++a) {
        const double value = column[number(block, a)];
        // Blocks of one row are diagonal unless the penalty has directions; zeros there would only widen the matrix.
        if (block.size() == 1 && a != b && value == 0.0) continue;
        i.push_back(first + number(block, a));
        j.push_back(first + number(block, b));
        values.push_back(value);
      }
  }
  const bool changed = comm_.any(!inverse_ || i != inverse_rows_ || j != inverse_columns_);
  if (changed) {
    create_matrix(comm_, rows, rows, i, j, values, inverse_);
    inverse_rows_ = std::move(i);
    inverse_columns_ = std::move(j);
  } else {
    FBI_PETSC(MatSetValuesCOO(inverse_, values.data(), INSERT_VALUES));
  }
  return changed;
}

void AssembledSystem::add_multiplier_term(bool geometry_changed) {
  const Timed timed("multiplier term");
  if (geometry_changed || !m_) assemble_m();
  const bool changed = assemble_inverse() || geometry_changed || !term_;
  if (changed) {
    FBI_PETSC(MatPtAP(inverse_, m_, MAT_INITIAL_MATRIX, PETSC_DEFAULT, term_.out()));
    FBI_PETSC(MatDuplicate(jacobian_, MAT_COPY_VALUES, sum_.out()));
    Mat sum = sum_.get();
    FBI_PETSC(MatAXPY(sum, 1.0, term_, DIFFERENT_NONZERO_PATTERN));
    return;
  }
  Mat term = term_.get();
  FBI_PETSC(MatPtAP(inverse_, m_, MAT_REUSE_MATRIX, PETSC_DEFAULT, &term));
  FBI_PETSC(MatZeroEntries(sum_));
  add_subset(jacobian_, sum_);
  add_subset(term_, sum_);
}

bool AssembledSystem::prepare(bool geometry_changed, double continuity_scale) {
  jacobian_ = fluid_.assemble_jacobian();
  const bool coupled = coupling_ != nullptr && coupling_->global_rows() > 0;
  if (coupled) add_multiplier_term(geometry_changed);
  Mat matrix = coupled ? sum_.get() : jacobian_.get();
  {
    linalg::Write scale(row_scale_);
    const std::size_t owned = 4 * static_cast<std::size_t>(fluid_.mesh().owned_nodes);
    for (std::size_t k = 0; k < owned; ++k) scale.get()[k] = k % 4 == 3 ? continuity_scale : 1.0;
  }
  FBI_PETSC(MatDiagonalScale(matrix, row_scale_, nullptr));
  const Timed timed("incomplete factors");
  return solver_.factorize(matrix);
}

}  // namespace fbi::fsi
