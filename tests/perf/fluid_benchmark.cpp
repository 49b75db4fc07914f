// Residual, tangent, tau and pressure solves of the fluid on the mesh of the canopy case (2.1 million unknowns), fluid
// only. Run: mpirun -n 2 bin/fluid_benchmark; the time of an iteration is that of the slowest rank. How bytes and flops
// are counted is said in fluid_cost.hpp.
#include <benchmark/benchmark.h>
#include <mpi.h>

#include <algorithm>

#include "linalg/pressure_solver.hpp"
#include "linalg/tensor_poisson.hpp"
#include "perf/fluid_cost.hpp"
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
  if (!scenes[0] && !scenes[1])
    perf::at_end([] {
      for (auto& one : scenes) one.reset();
    });
  if (!scenes[general]) scenes[general] = std::make_unique<Canopy>(general);
  return *scenes[general];
}

template <class Work>
void measure_field(benchmark::State& state, const Work& work, const perf::Cost& cost) {
  Canopy& canopy = scene(state.range(0) != 0);
  perf::measure(
      state, canopy.mesh.comm, [&] { work(canopy); }, cost);
  state.counters["unknowns/s"] = benchmark::Counter(4.0 * static_cast<double>(canopy.mesh.global_nodes),
                                                    benchmark::Counter::kIsIterationInvariantRate);
}

void residual(benchmark::State& state) {
  const bool general = state.range(0) != 0;
  measure_field(
      state, [](Canopy& c) { c.field.residual(c.y); }, perf::fluid_cost(scene(general).mesh, general, false));
}
void tangent(benchmark::State& state) {
  const bool general = state.range(0) != 0;
  measure_field(
      state, [](Canopy& c) { c.field.apply_jacobian(c.x, c.y); }, perf::fluid_cost(scene(general).mesh, general, true));
}
void begin_step(benchmark::State& state) {
  measure_field(state, [](Canopy& c) { c.field.begin_step(2e-4, 2e-4); }, {});
}
BENCHMARK(residual)->Apply([](auto* b) { perf::fixed(b->ArgName("general")->Arg(0)->Arg(1), 20); });
BENCHMARK(tangent)->Apply([](auto* b) { perf::fixed(b->ArgName("general")->Arg(0)->Arg(1), 20); });
BENCHMARK(begin_step)->Apply([](auto* b) { perf::fixed(b->ArgName("general")->Arg(0)->Arg(1), 10); });

constexpr double robin = 3.0 * 480 / 13;  // 3/h at the outflow

template <class Real>
void tensor_poisson(benchmark::State& state) {
  const mesh::HexMesh& mesh = scene(false).mesh;
  linalg::TensorPoisson solver(mesh, {{{0.0, robin}, {0.0, 0.0}, {0.0, 0.0}}});
  std::vector<Real> b(mesh.owned_nodes), x(mesh.owned_nodes);
  for (Index a = 0; a < mesh.owned_nodes; ++a) b[a] = static_cast<Real>(noise(mesh.node_id[a], 0, 1));
  perf::measure(
      state, mesh.comm, [&] { solver.apply(b.data(), x.data()); }, perf::tensor_cost<Real>(mesh, 33, 33));
}
BENCHMARK(tensor_poisson<double>)->Apply([](auto* b) { perf::fixed(b, 50); });
BENCHMARK(tensor_poisson<float>)->Apply([](auto* b) { perf::fixed(b, 50); });

/// One V-cycle on the same operator. Counted is the finest level alone: its matrix in two symmetric smoothing sweeps
/// (two passes each) and a residual, 12 bytes and 2 flops an entry and pass.
void multigrid(benchmark::State& state) {
  Canopy& canopy = scene(true);
  const std::vector<double> one(canopy.mesh.local_cells(), 1.0);
  linalg::MatHandle matrix = canopy.field.pressure_laplacian(one, 3.0);
  linalg::VecHandle b, x;
  FBI_PETSC(MatCreateVecs(matrix, x.out(), b.out()));
  FBI_PETSC(VecSetRandom(b, nullptr));
  MatInfo info;
  FBI_PETSC(MatGetInfo(matrix, MAT_LOCAL, &info));
  linalg::MultigridPressure solver(canopy.mesh.comm, std::move(matrix), false);
  perf::measure(state, canopy.mesh.comm, [&] { solver.apply(b, x); },
                {5 * 12.0 * info.nz_used, 5 * 2.0 * info.nz_used});
}
BENCHMARK(multigrid)->Apply([](auto* b) { perf::fixed(b, 10); });

}  // namespace
