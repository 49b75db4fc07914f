/// What the benchmarks share: the machine's bandwidth and peak, measured with the same compiler flags, and how a piece
/// of work is timed on all ranks and set against them.
#pragma once

#include <benchmark/benchmark.h>
#include <mpi.h>

#include <functional>

#include "base/comm.hpp"

namespace fbi::perf {

/// Of all ranks together, measured once, before the first benchmark.
struct Machine {
  double bandwidth = 0.0;        ///< of the memory: a[i] = b[i] + s c[i] on arrays of 64 MiB a rank [byte/s]
  double cache_bandwidth = 0.0;  ///< the same on arrays of 256 KiB [byte/s]
  double peak = 0.0;             ///< of double precision: independent multiply-adds in registers [flop/s]
};
const Machine& machine();

/// What a piece of work costs on this rank, by counting in its loops (multiplications, additions and divisions one
/// each, a multiply-add two; arrays once for each sweep over them, as if nothing were left in caches). 0: not counted.
struct Cost {
  double bytes = 0.0;
  double flops = 0.0;
};

/// Seconds of work() on the slowest rank; collective. Sets the time of the iteration.
template <class Work>
double timed(benchmark::State& state, const Comm& comm, const Work& work) {
  MPI_Barrier(comm.get());
  const double start = MPI_Wtime();
  work();
  const double seconds = comm.max(MPI_Wtime() - start);
  state.SetIterationTime(seconds);
  return seconds;
}

/// Counters: GB/s and Gflop/s of all ranks, and their shares of the machine's. A share of the bandwidth may exceed 1
/// where data stays in caches.
void count(benchmark::State& state, const Comm& comm, const Cost& cost, double seconds_an_iteration);

/// Runs work() as often as the benchmark asks for (a fixed number: the work may be collective), once before.
template <class Work>
void measure(benchmark::State& state, const Comm& comm, const Work& work, const Cost& cost) {
  work();
  double seconds = 0.0;
  for (auto _ : state) seconds += timed(state, comm, work);
  count(state, comm, cost, seconds / static_cast<double>(state.iterations()));
}

/// Calls `action` after the last benchmark, while MPI and PETSc still run.
void at_end(std::function<void()> action);

/// A benchmark with a fixed number of iterations, timed by measure.
inline benchmark::internal::Benchmark* fixed(benchmark::internal::Benchmark* benchmark, int iterations) {
  return benchmark->Iterations(iterations)->UseManualTime()->Unit(benchmark::kMillisecond);
}

}  // namespace fbi::perf
