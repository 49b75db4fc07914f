// Search, coupling operators and the multiplier factor of the canopy: 480 x 32 x 32 cells, 225 x 15 fibers of three
// elements. Run by hand: mpirun -n 2 bin/coupling_benchmark
#include <benchmark/benchmark.h>
#include <mpi.h>

#include <cmath>
#include <memory>

#include "coupling/complete_rows.hpp"
#include "linalg/multiplier_factor.hpp"
#include "perf/measure.hpp"
#include "search/bins.hpp"
#include "search/pair_search.hpp"
#include "unit/coupling/scene.hpp"

namespace fbi::test {
namespace {

constexpr double small_bend = 0.003;  // [length], so that the cuts of a step are not those of straight fibers

struct Canopy {
  Scene scene;
  coupling::Coupling coupling;
  std::vector<double> dofs;
  explicit Canopy(bool general)
      : scene(mesh::make_box({uniform(0, 13, 480), uniform(0, 1, 32), uniform(0, 1, 32)}, general), fibers()),
        coupling(scene.fluid, scene.fibers, coupling::CouplingParameters()),
        dofs(waved(scene.fibers, small_bend)) {
    for (std::size_t n = 0; n < dofs.size(); n += 6) dofs[n + 1] = std::max(dofs[n + 1], 0.0);
  }
  static mesh::FiberMeshData fibers() {
    mesh::FiberMeshData data;
    for (int i = 0; i < 225; ++i)
      for (int k = 0; k < 15; ++k) {
        const double x = 1.0 + 10.0 / 226 * (i + 1), z = 1.0 / 17 * (k + 1);
        add_line(data, Vec3(x, 0, z), Vec3(x, 0.3, z), 3);
      }
    return data;
  }
};

std::unique_ptr<Canopy> canopies[2];  // box, general; made when first needed

Canopy& canopy(bool general) {
  if (!canopies[0] && !canopies[1])
    perf::at_end([] {
      for (auto& one : canopies) one.reset();
    });
  if (!canopies[general]) canopies[general] = std::make_unique<Canopy>(general);
  return *canopies[general];
}

/// Search, cuts, D, M and kappa. Counted: at each of the six points of a segment the place in the cell (on general
/// meshes four Newton steps of some 150 flops), 8 + 4 + 2 shape functions and their products; the entries of M and D.
void operators(benchmark::State& state) {
  const bool general = state.range(0) != 0;
  Canopy& c = canopy(general);
  c.coupling.update(c.dofs);
  const double points = 6.0 * static_cast<double>(c.coupling.coverage().segments) / c.scene.comm.size();
  double entries = static_cast<double>(c.coupling.local_m().value.size());
  for (Index f = 0; f < c.scene.fibers.fibers(); ++f) entries += static_cast<double>(c.coupling.d_block(f).size());
  perf::measure(state, c.scene.comm, [&] { c.coupling.update(c.dofs); },
                {12 * entries, points * (general ? 720 : 120)});
  state.counters["segments"] = static_cast<double>(c.coupling.coverage().segments);
}
BENCHMARK(operators)->Apply([](auto* b) { perf::fixed(b->ArgName("general")->Arg(0)->Arg(1), 20); });

/// The cells near every fiber element of this rank, by the tree. Counted: one path from the root to a leaf, two boxes
/// of 48 bytes and six comparisons at each level.
void search(benchmark::State& state) {
  Canopy& c = canopy(true);
  const search::PairSearch pairs(c.scene.fluid, 1e-8);
  std::vector<search::Aabb> boxes;
  const mesh::FiberMesh& fibers = c.scene.fibers;
  for (Index f = 0; f < fibers.fibers(); ++f)
    for (Index n = fibers.first_node[f]; n + 1 < fibers.first_node[f + 1]; ++n) {
      search::Aabb box;
      box.include(&c.dofs[6 * static_cast<std::size_t>(n)]);
      box.include(&c.dofs[6 * static_cast<std::size_t>(n + 1)]);
      boxes.push_back(box);
    }
  const double levels = std::log2(std::max<double>(2.0, c.scene.fluid.local_cells()));
  std::vector<Index> cells;
  perf::measure(state, c.scene.comm,
                [&] {
                  for (const search::Aabb& box : boxes) {
                    pairs.cells_near(box, cells);
                    benchmark::DoNotOptimize(cells.data());
                  }
                },
                {96 * levels * boxes.size(), 12 * levels * boxes.size()});
}
BENCHMARK(search)->Apply([](auto* b) { perf::fixed(b, 20); });

struct Multipliers {
  linalg::MultiplierRows rows;
  std::vector<double> law;
  std::vector<double> dense;  // one block of S for all fibers: that they move does not change the work
  std::vector<linalg::InterfaceBlock> blocks;
  Multipliers(Canopy& c, bool moving) {
    c.coupling.update(c.dofs);
    const double volume = 13.0 / (480 * 32 * 32), dt = 2e-4;
    rows = coupling::complete_rows(
        c.scene.fluid, c.coupling,
        std::vector<double>(3 * static_cast<std::size_t>(c.scene.fluid.local_nodes()), dt / volume));
    law.assign(9 * static_cast<std::size_t>(c.coupling.rows()), 0.0);
    for (Index p = 0; p < c.coupling.rows(); ++p)
      for (int i = 0; i < 3; ++i) law[9 * static_cast<std::size_t>(p) + 4 * i] = c.coupling.kappa()[p] / 100.0;
    if (!moving) {
      blocks = {{0, c.coupling.rows(), nullptr, law.data()}};
      return;
    }
    Index most = 0;
    for (Index f = 0; f < c.scene.fibers.fibers(); ++f)
      most = std::max(most, c.coupling.first_row_of(f + 1) - c.coupling.first_row_of(f));
    dense.assign(9 * static_cast<std::size_t>(most) * most, 0.0);
    for (Index i = 0; i < 3 * most; ++i) dense[static_cast<std::size_t>(3 * most + 1) * i] = 1e-3;
    for (Index f = 0; f < c.scene.fibers.fibers(); ++f)
      blocks.push_back({c.coupling.first_row_of(f), c.coupling.first_row_of(f + 1) - c.coupling.first_row_of(f),
                        dense.data(), nullptr});
  }
};

/// Counted from the entries l of the factor with n rows. Fixed fibers: as if they were spread evenly, l^2/n flops, the
/// factor once. Moving ones (1): inverses of blocks of l/n rows, the blocks in and out.
void factorize(benchmark::State& state) {
  Canopy& c = canopy(false);
  const bool moving = state.range(0) != 0;
  const Multipliers multipliers(c, moving);
  linalg::MultiplierFactor factor;
  factor.factorize(multipliers.rows, multipliers.blocks);
  const double entries = static_cast<double>(factor.factor_entries()), n = 3.0 * c.coupling.rows();
  perf::measure(state, c.scene.comm, [&] { factor.factorize(multipliers.rows, multipliers.blocks); },
                {(moving ? 2 * 8 : 12) * entries, n > 0 ? entries * entries / n : 0.0});
  state.counters["entries"] = c.scene.comm.sum(entries);
}
BENCHMARK(factorize)->Apply([](auto* b) { perf::fixed(b->ArgName("moving")->Arg(0)->Arg(1), 5); });

/// Fixed fibers: the factor read forward and backward, 12 bytes and 2 flops an entry. Moving ones (1): the inverses
/// three times at 8 bytes and 2 flops, M four times at 8 bytes and 6 flops.
void factor_solve(benchmark::State& state) {
  Canopy& c = canopy(false);
  const bool moving = state.range(0) != 0;
  const Multipliers multipliers(c, moving);
  linalg::MultiplierFactor factor;
  factor.factorize(multipliers.rows, multipliers.blocks);
  const double entries = static_cast<double>(factor.factor_entries());
  const double m = static_cast<double>(multipliers.rows.value.size());
  std::vector<double> b(3 * static_cast<std::size_t>(c.coupling.rows()), 1.0);
  perf::measure(state, c.scene.comm,
                [&] {
                  std::fill(b.begin(), b.end(), 1.0);
                  factor.solve(b.data());
                },
                {moving ? 3 * 8 * entries + 4 * 8 * m : 2 * 12 * entries,
                 moving ? 3 * 2 * entries + 4 * 6 * m : 2 * 2 * entries});
}
BENCHMARK(factor_solve)->Apply([](auto* b) { perf::fixed(b->ArgName("moving")->Arg(0)->Arg(1), 20); });

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
  perf::measure(state, scene.comm, [&] { coupling.update(dofs); }, {});
  state.counters["segments"] = static_cast<double>(coupling.coverage().segments);
  state.SetComplexityN(elements);
}
BENCHMARK(many_fibers)
    ->ArgNames({"elements", "general"})
    ->ArgsProduct({{12500, 25000, 50000, 100000}, {0}})
    ->Apply([](auto* b) { perf::fixed(b, 3); }) -> Complexity(benchmark::oN);
BENCHMARK(many_fibers)
    ->ArgNames({"elements", "general"})
    ->ArgsProduct({{12500, 25000, 50000, 100000}, {1}})
    ->Apply([](auto* b) { perf::fixed(b, 3); }) -> Complexity(benchmark::oN);

}  // namespace
}  // namespace fbi::test
