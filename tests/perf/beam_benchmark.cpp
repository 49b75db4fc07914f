/// Cost of the fibers of a large canopy: 3375 fibers of 3 elements, residual, tangents, factors and compliances.
#include <benchmark/benchmark.h>
#include <mpi.h>

#include "perf/measure.hpp"
#include "unit/beam/straight_fiber.hpp"

namespace fbi {
namespace {

constexpr Index fibers_x = 225, fibers_z = 15, elements = 3;

struct Canopy {
  mesh::FiberMesh mesh;
  std::vector<beam::FiberParameters> groups;
  Canopy() {
    for (Index i = 0; i < fibers_x; ++i)
      for (Index k = 0; k < fibers_z; ++k)
        test::add_straight_fiber(mesh, {1 + 10.0 / 226 * (i + 1), 0, (k + 1) / 17.0}, {0, 1, 0}, 0.3, elements);
    beam::FiberParameters group;
    group.section.radius = 0.01;
    group.material.young = 1e7;
    group.material.density = 10;
    group.start = beam::EndCondition::clamped;
    groups = {group};
  }
};

void linearize(benchmark::State& state) {
  const Canopy canopy;
  beam::BeamField field(canopy.mesh, canopy.groups, {}, {0.5, 0, 0});
  field.initialize({});
  field.begin_step(2e-4, 2e-4);
  perf::measure(state, Comm(MPI_COMM_WORLD), [&] { field.linearize(); }, {});
}
BENCHMARK(linearize)->Apply([](auto* b) { perf::fixed(b, 50); });

void evaluate(benchmark::State& state) {
  const Canopy canopy;
  beam::BeamField field(canopy.mesh, canopy.groups, {}, {0.5, 0, 0});
  field.initialize({});
  field.begin_step(2e-4, 2e-4);
  const std::vector<double> nothing(6 * static_cast<std::size_t>(canopy.mesh.nodes()), 0.0);
  perf::measure(state, Comm(MPI_COMM_WORLD),
                [&] {
                  field.increment(nothing);
                  field.evaluate();
                },
                {});
}
BENCHMARK(evaluate)->Apply([](auto* b) { perf::fixed(b, 50); });

void compliance(benchmark::State& state) {
  const Canopy canopy;
  beam::BeamField field(canopy.mesh, canopy.groups, {}, {0.5, 0, 0});
  field.initialize({});
  field.begin_step(2e-4, 2e-4);
  field.linearize();
  // one row for each node, coupled to the nodes of its two elements
  const Index rows = elements + 1, columns = 2 * (elements + 1);
  std::vector<double> d(static_cast<std::size_t>(rows) * columns, 0.0);
  for (Index r = 0; r < rows; ++r)
    for (Index c = 0; c < columns; ++c)
      if (std::abs(r - c / 2) <= 1) d[r * columns + c] = c % 2 == 0 ? 0.03 : 0.001;
  const std::vector<const double*> all_d(canopy.mesh.fibers(), d.data());
  const std::vector<Index> all_rows(canopy.mesh.fibers(), rows);
  // D K^-1 D^T, counted as of each row and direction one solve with band factors (11 below, 22 above with room for
  // pivoting) and a product with D, which couples equal directions only; symmetric factors need less.
  const double unknowns = 3.0 * columns, right_sides = 3.0 * rows;
  const double flops = right_sides * (2 * unknowns * (11 + 22) + right_sides * 2 * columns);
  const double bytes = 8.0 * (unknowns * (11 + 22 + 1) + right_sides * (2 * unknowns + right_sides));
  perf::measure(state, Comm(MPI_COMM_WORLD),
                [&] {
                  field.compliances(all_d, all_rows, [](Index /*fiber*/, const beam::RowMatrix& block) {
                    benchmark::DoNotOptimize(block.data());
                  });
                },
                {bytes * canopy.mesh.fibers(), flops * canopy.mesh.fibers()});
}
BENCHMARK(compliance)->Apply([](auto* b) { perf::fixed(b, 50); });

void step(benchmark::State& state) {
  const Canopy canopy;
  beam::BeamField field(canopy.mesh, canopy.groups, {}, {0.5, 0, 0});
  field.initialize({});
  perf::measure(state, Comm(MPI_COMM_WORLD),
                [&] {
                  field.begin_step(2e-4, 2e-4);
                  benchmark::DoNotOptimize(field.solve_step({}));
                },
                {});
}
BENCHMARK(step)->Apply([](auto* b) { perf::fixed(b, 50); });

}  // namespace
}  // namespace fbi
