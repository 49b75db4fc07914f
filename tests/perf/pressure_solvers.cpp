/// The two pressure solvers on a box: time, messages and bytes of one exact solve by TensorPoisson and of one cycle by
/// MultigridPressure, on any number of ranks.
///
///   mpirun -n 2 bin/pressure_solvers 480 32 32 [REPETITIONS]
#include <mpi.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "linalg/pressure_solver.hpp"
#include "linalg/tensor_poisson.hpp"
#include "mesh/partition.hpp"

extern "C" void fbi_messages(long long* counts);  // message_counter.cpp

namespace fbi {
namespace {

/// The rank's own part of a box, made without the whole: every rank passes its chunk of nodes and cells.
mesh::HexMesh make_mesh(const Comm& comm, const std::array<int, 3>& cells) {
  mesh::HexMeshChunk chunk;
  chunk.box.emplace();
  for (int d = 0; d < 3; ++d)
    for (int i = 0; i <= cells[d]; ++i) chunk.box->coordinates[d].push_back(static_cast<double>(i));
  const GlobalIndex nx = cells[0] + 1, ny = cells[1] + 1, nz = cells[2] + 1;
  chunk.global_nodes = nx * ny * nz;
  chunk.global_cells = GlobalIndex{cells[0]} * cells[1] * cells[2];
  const auto begin = [&](GlobalIndex total, int rank) {
    return total / comm.size() * rank + total % comm.size() * rank / comm.size();
  };
  chunk.first_node = begin(chunk.global_nodes, comm.rank());
  chunk.first_cell = begin(chunk.global_cells, comm.rank());
  for (GlobalIndex id = chunk.first_node; id < begin(chunk.global_nodes, comm.rank() + 1); ++id)
    for (const GlobalIndex index : {id % nx, id / nx % ny, id / nx / ny})
      chunk.nodes.push_back(static_cast<double>(index));
  for (GlobalIndex id = chunk.first_cell; id < begin(chunk.global_cells, comm.rank() + 1); ++id) {
    const GlobalIndex corner = id % cells[0] + nx * (id / cells[0] % cells[1] + ny * (id / cells[0] / cells[1]));
    for (const GlobalIndex level : {GlobalIndex{0}, nx * ny})
      for (const GlobalIndex offset : {GlobalIndex{0}, GlobalIndex{1}, nx + 1, nx})
        chunk.cells.push_back(corner + offset + level);
  }
  return mesh::distribute(comm, std::move(chunk));
}

/// The Laplacian of unit cubes, with a Robin term on the first node plane that makes it regular.
linalg::MatHandle assemble(const mesh::HexMesh& mesh) {
  linalg::MatHandle matrix;
  const PetscInt n = mesh.owned_nodes, all = static_cast<PetscInt>(mesh.global_nodes);
  FBI_PETSC(MatCreateAIJ(mesh.comm.get(), n, n, all, all, 27, nullptr, 27, nullptr, matrix.out()));
  constexpr int bits[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
  double element[8][8];
  for (int a = 0; a < 8; ++a)
    for (int b = 0; b < 8; ++b) {
      element[a][b] = 0.0;
      for (int d = 0; d < 3; ++d) {
        double term = bits[a][d] == bits[b][d] ? 1.0 : -1.0;
        for (int e = 0; e < 3; ++e)
          if (e != d) term *= bits[a][e] == bits[b][e] ? 1.0 / 3 : 1.0 / 6;
        element[a][b] += term;
      }
    }
  for (Index c = 0; c < mesh.local_cells(); ++c) {
    PetscInt number[8];
    for (int a = 0; a < 8; ++a)
      number[a] = static_cast<PetscInt>(mesh.node_number[mesh.cells[8 * static_cast<std::size_t>(c) + a]]);
    FBI_PETSC(MatSetValues(matrix, 8, number, 8, number, element[0], ADD_VALUES));
    if (mesh.node(mesh.cells[8 * static_cast<std::size_t>(c)])[0] == 0.0)
      for (const int a : {0, 3, 4, 7}) FBI_PETSC(MatSetValue(matrix, number[a], number[a], 0.75, ADD_VALUES));
  }
  FBI_PETSC(MatAssemblyBegin(matrix, MAT_FINAL_ASSEMBLY));
  FBI_PETSC(MatAssemblyEnd(matrix, MAT_FINAL_ASSEMBLY));
  return matrix;
}

template <class Work>
void report(const char* name, const Comm& comm, const mesh::HexMesh& mesh, int repetitions, const Work& work) {
  work();
  std::vector<double> seconds;
  long long before[4], after[4];
  fbi_messages(before);
  work();
  fbi_messages(after);
  for (int i = 0; i < repetitions; ++i) {
    MPI_Barrier(comm.get());
    const double start = MPI_Wtime();
    work();
    seconds.push_back(comm.max(MPI_Wtime() - start));
  }
  std::sort(seconds.begin(), seconds.end());
  GlobalIndex most[4];
  for (int k = 0; k < 4; ++k) most[k] = comm.max(static_cast<GlobalIndex>(after[k] - before[k]));
  const double median = seconds[seconds.size() / 2];
  if (comm.rank() == 0)
    std::printf(
        "%-18s %3d ranks %9.3f ms %8.1f ns a node and rank %6lld messages %9.1f KiB %4lld reductions %4lld other\n",
        name, comm.size(), 1e3 * median, 1e9 * median * comm.size() / static_cast<double>(mesh.global_nodes),
        static_cast<long long>(most[0]), static_cast<double>(most[1]) / 1024, static_cast<long long>(most[2]),
        static_cast<long long>(most[3]));
}

void run(const std::array<int, 3>& cells, int repetitions) {
  const Comm comm;
  const mesh::HexMesh mesh = make_mesh(comm, cells);
  if (comm.rank() == 0) std::printf("%d x %d x %d cells\n", cells[0], cells[1], cells[2]);
  {
    linalg::TensorPoisson solver(mesh, {{{1.0, 0.0}, {0.0, 0.0}, {0.0, 0.0}}});
    std::vector<double> b(mesh.owned_nodes, 1.0), x(mesh.owned_nodes);
    std::vector<float> b_single(mesh.owned_nodes, 1.0F), x_single(mesh.owned_nodes);
    report("tensor, double", comm, mesh, repetitions, [&] { solver.apply(b.data(), x.data()); });
    report("tensor, single", comm, mesh, repetitions, [&] { solver.apply(b_single.data(), x_single.data()); });
  }
  linalg::MatHandle matrix = assemble(mesh);
  linalg::VecHandle b, x;
  FBI_PETSC(MatCreateVecs(matrix, x.out(), b.out()));
  FBI_PETSC(VecSetRandom(b, nullptr));
  linalg::MultigridPressure solver(comm, std::move(matrix), false);
  report("multigrid, a cycle", comm, mesh, std::max(1, repetitions / 5), [&] { solver.apply(b, x); });
}

}  // namespace
}  // namespace fbi

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  fbi::linalg::initialize_petsc();
  std::array<int, 3> cells = {480, 32, 32};
  for (int d = 0; d < 3 && d + 1 < argc; ++d) cells[d] = std::max(1, std::atoi(argv[d + 1]));
  fbi::run(cells, argc > 4 ? std::max(1, std::atoi(argv[4])) : 20);
  fbi::linalg::finalize_petsc();
  MPI_Finalize();
  return EXIT_SUCCESS;
}
