#include "fsi/extended_system.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "base/counters.hpp"
#include "base/timer.hpp"
#include "linalg/vector_access.hpp"

namespace fbi::fsi {

using linalg::Read;
using linalg::Write;

ExtendedSystem::ExtendedSystem(fluid::FluidField& fluid, const coupling::Coupling* coupling,
                               const coupling::InterfaceOperator* interface)
    : fluid_(fluid), coupling_(coupling), interface_(interface), comm_(fluid.mesh().comm), factors_(comm_) {}

bool ExtendedSystem::solve(Vec b, Vec x) {
  const mesh::HexMesh& mesh = fluid_.mesh();
  const std::size_t owned = 4 * static_cast<std::size_t>(mesh.owned_nodes);
  FBI_PETSC(VecSet(right_, 0.0));
  {
    Read from(b);
    Write to(right_);
    std::copy_n(from.get(), owned, to.get());
    if (fluid_.pressure_is_free() && mesh.first_node == 0 && mesh.owned_nodes > 0) to.get()[3] = 0.0;
  }
  factors_.solve(right_, solution_);
  double sum = 0.0;
  Read from(solution_);
  Write to(x);
  for (std::size_t k = 0; k < owned; ++k) {
    to.get()[k] = from.get()[k];
    sum += from.get()[k];
  }
  return !comm_.any(!std::isfinite(sum));
}

bool ExtendedSystem::factorize() {
  Timed timed("direct factorisation");
  count("direct factorizations");
  const mesh::HexMesh& mesh = fluid_.mesh();
  jacobian_ = fluid_.assemble_jacobian();
  const PetscInt owned = 4 * mesh.owned_nodes;
  const PetscInt rows = coupling_ != nullptr ? 3 * coupling_->rows() : 0;
  const GlobalIndex first_row = coupling_ != nullptr ? coupling_->first_row() : 0;
  // Rank r's extended unknowns: its fluid unknowns, then its multipliers.
  const GlobalIndex mine[2] = {4 * mesh.first_node, 3 * first_row};
  std::vector<GlobalIndex> starts(2 * comm_.size());
  MPI_Allgather(mine, 2, MPI_INT64_T, starts.data(), 2, MPI_INT64_T, comm_.get());
  const auto owner = [&](GlobalIndex number, int which) {
    int rank = comm_.size() - 1;
    while (rank > 0 && starts[2 * rank + which] > number) --rank;
    return rank;
  };
  const auto fluid_number = [&](GlobalIndex number) {
    return static_cast<PetscInt>(number + starts[2 * owner(number, 0) + 1]);
  };
  const auto multiplier_number = [&](GlobalIndex number) {  // number = 3 row + direction
    const int rank = owner(number, 1);
    const GlobalIndex fluid_end = rank + 1 < comm_.size() ? starts[2 * (rank + 1)] : 4 * mesh.independent_nodes;
    return static_cast<PetscInt>(number + fluid_end);
  };

  std::vector<PetscInt> i, j;
  std::vector<double> v;
  const auto add = [&](PetscInt row, PetscInt column, double value) {
    i.push_back(row);
    j.push_back(column);
    v.push_back(value);
  };
  const bool pin = fluid_.pressure_is_free();  // the pressure of node 0 is the level; shifted to mean zero afterwards
  for (PetscInt row = 4 * mesh.first_node; row < 4 * mesh.first_node + owned; ++row) {
    if (pin && row == 3) {
      add(fluid_number(3), fluid_number(3), 1.0);
      continue;
    }
    PetscInt count = 0;
    const PetscInt* columns = nullptr;
    const PetscScalar* values = nullptr;
    FBI_PETSC(MatGetRow(jacobian_, row, &count, &columns, &values));
    for (PetscInt k = 0; k < count; ++k)
      if (!(pin && columns[k] == 3)) add(fluid_number(row), fluid_number(columns[k]), values[k]);
    FBI_PETSC(MatRestoreRow(jacobian_, row, &count, &columns, &values));
  }
  if (coupling_ != nullptr) {
    const coupling::LocalM& m = coupling_->local_m();
    const std::vector<char>& dirichlet = fluid_.is_dirichlet();
    const bool normals = fluid_.has_normal_constraints();
    for (std::size_t p = 0; p < m.row.size(); ++p)
      for (Index k = m.begin[p]; k < m.begin[p + 1]; ++k) {
        const Mat3 free = normals ? fluid_.free_directions(m.node[k]) : Mat3::Identity();
        for (int d = 0; d < 3; ++d) {
          const std::size_t local = 4 * static_cast<std::size_t>(m.node[k]) + d;
          if (dirichlet[local] != 0) continue;
          const PetscInt node = fluid_number(4 * mesh.node_number[m.node[k]] + d);
          for (int e = 0; e < 3; ++e) {
            if (free(d, e) == 0.0) continue;
            const PetscInt multiplier = multiplier_number(3 * m.row[p] + e);
            add(node, multiplier, free(d, e) * m.value[k]);
            add(multiplier, node, free(d, e) * m.value[k]);
          }
        }
      }
    for (Index g = 0; g < interface_->groups(); ++g) {
      const coupling::InterfaceOperator::Block& block = interface_->joined_block(g);
      const std::vector<Index>& joined = interface_->joined_rows(g);
      for (Index a = 0; a < block.rows(); ++a)
        for (Index b = 0; b < block.cols(); ++b)
          add(multiplier_number(3 * (first_row + joined[a / 3]) + a % 3),
              multiplier_number(3 * (first_row + joined[b / 3]) + b % 3), -block(a, b));
    }
    for (Index f = 0; f < interface_->fibers(); ++f) {
      if (interface_->is_joined(f)) continue;
      const Index first = interface_->first_row_of(f), count = interface_->first_row_of(f + 1) - first;
      for (Index a = 0; a < 3 * count; ++a)
        for (Index b = 0; b < 3 * count; ++b) {
          if (interface_->is_local(f) && a / 3 != b / 3) continue;
          const double value =
              interface_->is_local(f)
                  ? interface_->law()[9 * static_cast<std::size_t>(first + a / 3) + 3 * (a % 3) + b % 3]
                  : interface_->block(f)(a, b);
          if (interface_->is_local(f) && a != b && value == 0.0) continue;
          add(multiplier_number(3 * (first_row + first) + a), multiplier_number(3 * (first_row + first) + b), -value);
        }
    }
  }
  FBI_PETSC(MatCreate(comm_.get(), extended_.out()));
  FBI_PETSC(MatSetSizes(extended_, owned + rows, owned + rows, PETSC_DETERMINE, PETSC_DETERMINE));
  FBI_PETSC(MatSetType(extended_, MATAIJ));
  FBI_PETSC(MatSetPreallocationCOO(extended_, static_cast<PetscCount>(i.size()), i.data(), j.data()));
  FBI_PETSC(MatSetValuesCOO(extended_, v.data(), INSERT_VALUES));
  FBI_PETSC(MatCreateVecs(extended_, right_.out(), solution_.out()));
  return factors_.factorize(extended_);
}

}  // namespace fbi::fsi
