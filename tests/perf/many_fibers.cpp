/// What Coupling::update (search, cuts, D, M, kappa) and the search for crossing fibers cost: a table of time against
/// fibers on one rank, and one of memory and messages of a rank against ranks, each with its own share of cells and
/// fibers. Fails where time is not linear in the fibers, or where a rank's share grows with the number of ranks.
///
///   bin/many_fibers                   one rank: 1e3, 1e4, 1e5 elements in 1e6 cells
///   mpirun -n 4 bin/many_fibers       1, 2 and 4 ranks
#include <malloc.h>
#include <mpi.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>

#include "coupling/coupling.hpp"
#include "search/fiber_crossings.hpp"
#include "unit/coupling/scene.hpp"

namespace {
long long messages = 0, message_bytes = 0;

void count(int entries, MPI_Datatype type) {
  int size = 0;
  MPI_Type_size(type, &size);
  ++messages;
  message_bytes += static_cast<long long>(entries) * size;
}
}  // namespace

// Messages from one rank to another pass here on their way to MPI.
extern "C" {
int MPI_Isend(const void* data, int entries, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* request) {
  count(entries, type);
  return PMPI_Isend(data, entries, type, to, tag, comm, request);
}
int MPI_Issend(const void* data, int entries, MPI_Datatype type, int to, int tag, MPI_Comm comm, MPI_Request* request) {
  count(entries, type);
  return PMPI_Issend(data, entries, type, to, tag, comm, request);
}
}

namespace fbi::test {
namespace {

double seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Memory in use on this rank [MiB].
double heap() {
  const struct mallinfo2 info = mallinfo2();
  return static_cast<double>(info.uordblks + info.hblkhd) / (1024.0 * 1024.0);
}

struct Cost {
  double seconds = 0.0;                   ///< of an update, the least of three
  double crossing_seconds = 0.0;          ///< of a search for crossing fibers
  double memory = 0.0;                    ///< of the operators, largest rank [MiB]
  long long messages = 0, kibibytes = 0;  ///< of an update, largest rank
  GlobalIndex segments = 0, crossing = 0;
};

/// Fibers of five bent elements, a tenth long, with centers anywhere in [0, width] x [0, 1]^2; `elements` in all.
Cost measure(const mesh::HexMeshData& mesh, int elements, double width, MPI_Comm mpi) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(0.1, 0.9), along(0.1, width - 0.1), turn(-1.0, 1.0);
  mesh::FiberMeshData data;
  for (int f = 0; f < elements / 5; ++f) {
    const Vec3 center(along(random), place(random), place(random));
    const Vec3 half = 0.05 * Vec3(turn(random), turn(random), turn(random)).normalized();
    add_line(data, center - half, center + half, 5);
  }
  const Scene scene(mesh, data, mpi);
  data = {};
  const std::vector<double> dofs = waved(scene.fibers, 0.003);
  Cost cost;
  const double before = heap();
  coupling::CouplingParameters parameters;
  parameters.outside = coupling::Outside::allow;
  coupling::Coupling coupling(scene.fluid, scene.fibers, parameters);
  for (int trial = 0; trial < 3; ++trial) {
    messages = message_bytes = 0;
    MPI_Barrier(mpi);
    const double start = seconds();
    coupling.update(dofs);
    const double taken = scene.comm.max(seconds() - start);
    cost.seconds = trial == 0 ? taken : std::min(cost.seconds, taken);
  }
  cost.messages = scene.comm.max(static_cast<GlobalIndex>(messages));
  cost.kibibytes = scene.comm.max(static_cast<GlobalIndex>(message_bytes)) / 1024;
  cost.memory = scene.comm.max(heap() - before);
  cost.segments = coupling.coverage().segments;
  search::FiberCrossings crossings(scene.fibers, std::vector<double>(scene.fibers.fibers(), 1e-3));
  MPI_Barrier(mpi);
  const double start = seconds();
  cost.crossing = crossings.find(dofs).count;
  cost.crossing_seconds = scene.comm.max(seconds() - start);
  return cost;
}

mesh::HexMeshData block(int length, int n, bool general) {
  mesh::HexMeshData mesh =
      mesh::make_box({uniform(0, length, length * n), uniform(0, 1, n), uniform(0, 1, n)}, general);
  if (!general) return mesh;
  std::mt19937 random(5);  // inner nodes moved: warped faces
  std::uniform_real_distribution<double> shift(-0.15 / n, 0.15 / n);
  for (std::size_t k = 0; k < mesh.nodes.size(); k += 3) {
    double* x = &mesh.nodes[k];
    const bool inner = x[0] > 0 && x[0] < length && x[1] > 0 && x[1] < 1 && x[2] > 0 && x[2] < 1;
    for (int i = 0; i < 3; ++i) x[i] += inner ? shift(random) : 0.0;
  }
  return mesh;
}

bool is_linear() {
  const int cells = 100;
  bool linear = true;
  std::printf("one rank, %d cells\n%8s %9s %9s %10s %12s %11s %10s %11s\n", cells * cells * cells, "mesh", "elements",
              "segments", "update [s]", "us an element", "memory [MiB]", "crossing", "search [s]");
  for (const bool general : {false, true}) {
    const mesh::HexMeshData mesh = block(1, cells, general);
    double last = 0.0;
    for (const int elements : {1000, 10000, 100000}) {
      const Cost cost = measure(mesh, elements, 1.0, MPI_COMM_SELF);
      std::printf("%8s %9d %9lld %10.4f %12.2f %11.1f %10lld %11.4f\n", general ? "warped" : "box", elements,
                  static_cast<long long>(cost.segments), cost.seconds, 1e6 * cost.seconds / elements, cost.memory,
                  static_cast<long long>(cost.crossing), cost.crossing_seconds);
      std::fflush(stdout);
      if (elements == 100000) linear = linear && cost.seconds < 15 * last;
      last = cost.seconds;
    }
  }
  return linear;
}

bool is_independent_of_ranks() {
  const Comm world;
  const int n = 30, elements = 10000;
  bool independent = true;
  if (world.rank() == 0)
    std::printf("%d cells and %d elements a rank\n%8s %6s %10s %9s %9s %12s %11s\n", n * n * n, elements, "mesh",
                "ranks", "update [s]", "messages", "sent [KiB]", "memory [MiB]", "search [s]");
  for (const bool general : {false, true}) {
    Cost two;
    for (int ranks = 1; ranks <= world.size(); ranks *= 2) {
      MPI_Comm part = MPI_COMM_NULL;
      MPI_Comm_split(world.get(), world.rank() < ranks ? 0 : MPI_UNDEFINED, world.rank(), &part);
      if (part != MPI_COMM_NULL) {
        const Cost cost = measure(block(ranks, n, general), ranks * elements, ranks, part);
        if (world.rank() == 0)
          std::printf("%8s %6d %10.4f %9lld %9lld %12.1f %11.4f\n", general ? "warped" : "box", ranks, cost.seconds,
                      cost.messages, cost.kibibytes, cost.memory, cost.crossing_seconds);
        if (ranks == 2) two = cost;
        // two neighbors instead of one; the shares differ a little
        if (ranks > 2 && world.rank() == 0)
          independent = independent && cost.messages <= 2 * two.messages && cost.kibibytes <= 2.4 * two.kibibytes + 1 &&
                        cost.memory <= 1.25 * two.memory;
        MPI_Comm_free(&part);
      }
      MPI_Barrier(world.get());
    }
  }
  return !world.any(!independent);
}

}  // namespace
}  // namespace fbi::test

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  int ranks = 0, rank = 0;
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  const bool good = ranks == 1 ? fbi::test::is_linear() : fbi::test::is_independent_of_ranks();
  if (!good && rank == 0) std::printf("FAILED: not linear in the fibers, or a rank's share grows with the ranks\n");
  MPI_Finalize();
  return good ? EXIT_SUCCESS : EXIT_FAILURE;
}
