// Time of Coupling::update. Google Benchmark; built with the tests, run by hand:
//   bin/coupling_benchmark
#include <benchmark/benchmark.h>
#include <mpi.h>

#include "unit/coupling/scene.hpp"

namespace fbi::test {
namespace {

constexpr double small_bend = 0.003;  // [length], so that the cuts of a step are not those of straight fibers

/// The canopy: 480 x 32 x 32 cells, 225 x 15 fibers of three elements, `general`: without the fast path of boxes.
void canopy(benchmark::State& state) {
  const bool general = state.range(0) != 0;
  mesh::FiberMeshData data;
  for (int i = 0; i < 225; ++i)
    for (int k = 0; k < 15; ++k) {
      const double x = 1.0 + 10.0 / 226 * (i + 1), z = 1.0 / 17 * (k + 1);
      add_line(data, Vec3(x, 0, z), Vec3(x, 0.3, z), 3);
    }
  const Scene scene(mesh::make_box({uniform(0, 13, 480), uniform(0, 1, 32), uniform(0, 1, 32)}, general), data);
  coupling::Coupling coupling(scene.fluid, scene.fibers, coupling::CouplingParameters());
  std::vector<double> dofs = waved(scene.fibers, small_bend);
  for (std::size_t n = 0; n < dofs.size(); n += 6) dofs[n + 1] = std::max(dofs[n + 1], 0.0);
  for (auto _ : state) coupling.update(dofs);
  state.counters["segments"] = static_cast<double>(coupling.coverage().segments);
  state.counters["outside"] = coupling.coverage().outside;
}
BENCHMARK(canopy)->ArgName("general")->Arg(0)->Arg(1)->Unit(benchmark::kMillisecond);

/// Fibers of five elements in 10^6 cells: time must be linear in the fibers.
void many_fibers(benchmark::State& state) {
  const int elements = static_cast<int>(state.range(0));
  const bool general = state.range(1) != 0;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> place(0.1, 0.9), turn(-1.0, 1.0);
  mesh::FiberMeshData data;
  for (int f = 0; f < elements / 5; ++f) {
    const Vec3 from(place(random), place(random), place(random));
    const Vec3 direction = Vec3(turn(random), turn(random), turn(random)).normalized();
    add_line(data, from, from + 0.1 * direction, 5);
  }
  const Scene scene(cube(100, general), data);
  coupling::Coupling coupling(scene.fluid, scene.fibers, coupling::CouplingParameters());
  const std::vector<double> dofs = waved(scene.fibers, small_bend);
  for (auto _ : state) coupling.update(dofs);
  state.counters["segments"] = static_cast<double>(coupling.coverage().segments);
  state.SetComplexityN(elements);
}
BENCHMARK(many_fibers)
    ->ArgNames({"elements", "general"})
    ->ArgsProduct({{12500, 25000, 50000, 100000}, {0}})
    ->Unit(benchmark::kMillisecond)
    ->Complexity(benchmark::oN);
BENCHMARK(many_fibers)
    ->ArgNames({"elements", "general"})
    ->ArgsProduct({{12500, 25000, 50000, 100000}, {1}})
    ->Unit(benchmark::kMillisecond)
    ->Complexity(benchmark::oN);

}  // namespace
}  // namespace fbi::test

int main(int argc, char** argv) {
  MPI_Init(&argc, &argv);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
  MPI_Finalize();
  return 0;
}
