#include "perf/measure.hpp"

#include <algorithm>
#include <cstdio>
#include <vector>

#include "linalg/lanes.hpp"
#include "linalg/petsc.hpp"

namespace fbi::perf {
namespace {

using Vector = linalg::Lanes<double>;

double triad(const Comm& comm, std::size_t numbers, int sweeps) {
  std::vector<double> a(numbers, 0.0), b(numbers, 1.0), c(numbers, 2.0);
  double least = 1e300;
  for (int trial = 0; trial < 6; ++trial) {
    MPI_Barrier(comm.get());
    const double start = MPI_Wtime();
    for (int sweep = 0; sweep < sweeps; ++sweep) {
      const double scale = 0.5 + sweep;
      for (std::size_t i = 0; i < numbers; ++i) a[i] = b[i] + scale * c[i];
      benchmark::DoNotOptimize(a.data());
      benchmark::ClobberMemory();
    }
    least = std::min(least, comm.max(MPI_Wtime() - start));
  }
  return 24.0 * static_cast<double>(numbers) * sweeps * comm.size() / least;
}

double multiply_adds(const Comm& comm) {
  constexpr int chains = 16, repetitions = 4000000;
  double least = 1e300;
  for (int trial = 0; trial < 5; ++trial) {
    Vector sum[chains] = {}, factor = Vector{} + 0.999, term = Vector{} + 1e-3;
    benchmark::DoNotOptimize(factor);
    benchmark::DoNotOptimize(term);
    MPI_Barrier(comm.get());
    const double start = MPI_Wtime();
    for (int i = 0; i < repetitions; ++i)
#pragma GCC unroll 16
      for (int k = 0; k < chains; ++k) sum[k] = sum[k] * factor + term;
    least = std::min(least, comm.max(MPI_Wtime() - start));
    for (Vector& v : sum) benchmark::DoNotOptimize(v);
  }
  return 2.0 * chains * repetitions * linalg::lane_count<double> * comm.size() / least;
}

std::vector<std::function<void()>>& endings() {
  static std::vector<std::function<void()>> all;
  return all;
}

/// Says nothing: for ranks other than 0.
class Silent : public benchmark::BenchmarkReporter {
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>&) override {}
};

}  // namespace

const Machine& machine() {
  static const Machine result = [] {
    const Comm comm;
    Machine m;
    m.bandwidth = triad(comm, std::size_t{8} << 20, 1);
    m.cache_bandwidth = triad(comm, std::size_t{32} << 10, 200);
    m.peak = multiply_adds(comm);
    return m;
  }();
  return result;
}

void count(benchmark::State& state, const Comm& comm, const Cost& cost, double seconds_an_iteration) {
  double sums[2] = {cost.bytes, cost.flops};
  comm.sum(sums, 2);
  if (sums[0] > 0.0) {
    state.counters["GB/s"] = 1e-9 * sums[0] / seconds_an_iteration;
    state.counters["of_bandwidth"] = sums[0] / seconds_an_iteration / machine().bandwidth;
  }
  if (sums[1] > 0.0) {
    state.counters["Gflop/s"] = 1e-9 * sums[1] / seconds_an_iteration;
    state.counters["of_peak"] = sums[1] / seconds_an_iteration / machine().peak;
  }
}

void at_end(std::function<void()> action) { endings().push_back(std::move(action)); }

}  // namespace fbi::perf

int main(int argc, char** argv) {
  using namespace fbi;
  MPI_Init(&argc, &argv);
  linalg::initialize_petsc();
  int rank = 0, ranks = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &ranks);
  benchmark::Initialize(&argc, argv);
  const perf::Machine& machine = perf::machine();
  perf::Silent silent;
  if (rank == 0) {
    std::fprintf(stderr, "%d rank%s together: memory %.1f GB/s, caches %.1f GB/s, peak %.1f Gflop/s\n", ranks,
                 ranks > 1 ? "s" : "", 1e-9 * machine.bandwidth, 1e-9 * machine.cache_bandwidth, 1e-9 * machine.peak);
    benchmark::RunSpecifiedBenchmarks();
  } else {
    benchmark::RunSpecifiedBenchmarks(&silent);
  }
  for (const auto& action : perf::endings()) action();
  linalg::finalize_petsc();
  MPI_Finalize();
  return 0;
}
