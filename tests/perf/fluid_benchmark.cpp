// Residual, tangent and tau of the fluid on the mesh of the canopy case (2.1 million unknowns), fluid only.
// Run: mpirun -np 2 bin/fluid_benchmark; the time of an iteration is that of the slowest rank.
#include <benchmark/benchmark.h>
#include <mpi.h>

#include <algorithm>

#include "unit/fluid/fluid_fixture.hpp"

namespace {

using namespace fbi;
using namespace fbi::fluid;
using namespace fbi::fluid::test;

struct Canopy {
  mesh::HexMesh mesh;
  FluidField field;
  linalg::VecHandle x, y;
  explicit Canopy(bool general)
      : mesh(box_mesh(Comm(MPI_COMM_WORLD), {uniform(0, 13, 480), uniform(0, 1, 32), uniform(0, 1, 32)}, general)),
        field(mesh, parameters(), conditions(), {TimeScheme::one_step_theta, 1.0}),
        x(field.create_vector()),
        y(field.create_vector()) {
    field.initialize();
    field.begin_step(2e-4, 2e-4);
    field.linearize();
    fill(mesh, x, [](GlobalIndex node, int c) { return noise(node, c, 1); });
  }
  static FluidParameters parameters() {
    FluidParameters p;
    p.viscosity = 0.004;
    p.initial_velocity = expressions("100*y*(2-y)", "sin(x)", "cos(y)");
    return p;
  }
  static BoundaryConditions conditions() {
    BoundaryConditions all;
    all["xmin"] = velocity(expressions("100*y*(2-y)", "0", "0"));
    all["xmax"] = of_type(BoundaryType::outflow);
    all["xmax"].backflow = true;
    all["ymin"] = of_type(BoundaryType::no_slip);
    for (const char* face : {"ymax", "zmin", "zmax"}) all[face] = of_type(BoundaryType::slip);
    return all;
  }
};

std::unique_ptr<Canopy> scenes[2];  // box, general; made when first needed

Canopy& scene(bool general) {
  if (!scenes[general]) scenes[general] = std::make_unique<Canopy>(general);
  return *scenes[general];
}

// Every rank runs the same, given number of iterations, because the work is collective.
template <class Work>
void measure(benchmark::State& state, const Work& work) {
  Canopy& canopy = scene(state.range(0) != 0);
  work(canopy);
  for (auto _ : state) {
    MPI_Barrier(MPI_COMM_WORLD);
    const double start = MPI_Wtime();
    work(canopy);
    state.SetIterationTime(canopy.mesh.comm.max(MPI_Wtime() - start));
  }
  state.counters["unknowns/s"] = benchmark::Counter(4.0 * static_cast<double>(canopy.mesh.global_nodes),
                                                    benchmark::Counter::kIsIterationInvariantRate);
}

void residual(benchmark::State& state) {
  measure(state, [](Canopy& c) { c.field.residual(c.y); });
}
void tangent(benchmark::State& state) {
  measure(state, [](Canopy& c) { c.field.apply_jacobian(c.x, c.y); });
}
void begin_step(benchmark::State& state) {
  measure(state, [](Canopy& c) { c.field.begin_step(2e-4, 2e-4); });
}

BENCHMARK(residual)->ArgName("general")->Arg(0)->Arg(1)->Iterations(20)->Repetitions(3)->UseManualTime()->Unit(
    benchmark::kMillisecond);
BENCHMARK(tangent)->ArgName("general")->Arg(0)->Arg(1)->Iterations(20)->Repetitions(3)->UseManualTime()->Unit(
    benchmark::kMillisecond);
BENCHMARK(begin_step)
    ->ArgName("general")
    ->Arg(0)
    ->Arg(1)
    ->Iterations(10)
    ->Repetitions(3)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

/// Says nothing: for ranks other than 0.
class Silent : public benchmark::BenchmarkReporter {
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>&) override {}
};

}  // namespace

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  linalg::initialize_petsc();
  int rank = 0;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  benchmark::Initialize(&argc, argv);
  Silent silent;
  if (rank == 0)
    benchmark::RunSpecifiedBenchmarks();
  else
    benchmark::RunSpecifiedBenchmarks(&silent);
  for (auto& one : scenes) one.reset();
  linalg::finalize_petsc();
  MPI_Finalize();
  return 0;
}
