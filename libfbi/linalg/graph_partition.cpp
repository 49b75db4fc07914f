#include "linalg/graph_partition.hpp"

#include <petscmat.h>
#ifdef FBI_PTSCOTCH
#include <ptscotch.h>
#endif

#include <algorithm>
#include <cstdlib>

#include "base/log.hpp"
#include "linalg/petsc.hpp"
#include "mesh/cell_graph.hpp"

namespace fbi::linalg {

#if defined(FBI_PTSCOTCH) && defined(PETSC_HAVE_PTSCOTCH)

bool has_graph_partition() { return true; }

std::optional<std::vector<int>> partition_by_graph(const Comm& comm, const mesh::HexMeshChunk& chunk) {
  if (chunk.global_cells < 8 * static_cast<GlobalIndex>(comm.size())) return std::nullopt;
  initialize_petsc();
  const mesh::CellGraph graph = mesh::cell_graph(comm, chunk);
  const std::size_t cells = graph.begin.size() - 1;
  PetscInt *begin = nullptr, *other = nullptr;  // taken over by the matrix
  FBI_PETSC(PetscMalloc1(graph.begin.size(), &begin));
  FBI_PETSC(PetscMalloc1(graph.other.size() + 1, &other));
  std::copy(graph.begin.begin(), graph.begin.end(), begin);
  std::copy(graph.other.begin(), graph.other.end(), other);
  MatHandle matrix;
  FBI_PETSC(MatCreateMPIAdj(comm.get(), static_cast<PetscInt>(cells), static_cast<PetscInt>(chunk.global_cells), begin,
                            other, nullptr, matrix.out()));
  Handle<MatPartitioning, MatPartitioningDestroy> partitioning;
  FBI_PETSC(MatPartitioningCreate(comm.get(), partitioning.out()));
  FBI_PETSC(MatPartitioningSetAdjacency(partitioning, matrix));
  FBI_PETSC(MatPartitioningSetType(partitioning, MATPARTITIONINGPTSCOTCH));
  // More threads call MPI from several of them, which MPI_Init does not allow, and finish in any order. The random
  // numbers would go on from the last call.
  setenv("SCOTCH_PTHREAD_NUMBER", "1", 1);
  SCOTCH_randomSeed(1);
  SCOTCH_randomReset();
  IsHandle parts;
  FBI_PETSC(MatPartitioningApply(partitioning, parts.out()));
  const PetscInt* part = nullptr;
  FBI_PETSC(ISGetIndices(parts, &part));
  std::vector<int> rank(part, part + cells);
  FBI_PETSC(ISRestoreIndices(parts, &part));
  std::vector<GlobalIndex> count(comm.size(), 0);
  for (const int r : rank) ++count[r];
  MPI_Allreduce(MPI_IN_PLACE, count.data(), comm.size(), MPI_INT64_T, MPI_SUM, comm.get());
  if (*std::min_element(count.begin(), count.end()) == 0) return std::nullopt;
  return rank;
}

#else

bool has_graph_partition() { return false; }

std::optional<std::vector<int>> partition_by_graph(const Comm&, const mesh::HexMeshChunk&) {
  throw Error(ExitCode::usage,
              "this build has no PT-Scotch to partition the mesh by its graph; use \"partition\": \"coordinates\"");
}

#endif

mesh::HexMesh distribute(const Comm& comm, mesh::HexMeshChunk chunk, mesh::Partition partition) {
  if (partition == mesh::Partition::graph && comm.size() > 1 && !chunk.box) {
    if (const std::optional<std::vector<int>> rank = partition_by_graph(comm, chunk))
      return mesh::distribute(comm, std::move(chunk), *rank);
    log::warning("the mesh has too few cells to partition its graph on %d ranks; its cells are placed by coordinates",
                 comm.size());
  }
  return mesh::distribute(comm, std::move(chunk));
}

}  // namespace fbi::linalg
