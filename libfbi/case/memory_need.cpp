#include "case/memory_need.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "base/log.hpp"
#include "base/memory.hpp"
#include "base/progress.hpp"

namespace fbi::cases {
namespace {

// Bytes, from measured peaks.
constexpr double per_rank = 6.0e7;
// Single precision: with some 20 Krylov iterations a solve; twofold: with 60 vectors of four doubles.
constexpr double per_box_node = 2000.0, per_general_node = 4000.0;
constexpr double twofold_per_box_node = 3500.0, twofold_per_general_node = 5000.0;
constexpr double per_fiber_node = 25000.0;
constexpr double reference_per_node = 40000.0;  // the matrix, its sum with the multiplier term, ILU factors
constexpr double entries_per_unknown = 6000.0;  // lists of entries and two matrices of a direct solution
// Factors of n unknowns by nested dissection, of which s lie in the smallest cut through the mesh.
constexpr double factor_per_unknown = 620.0;       // times sqrt(s)
constexpr double factors_of_several_ranks = 1.25;  // work space of MUMPS
constexpr double whole_below = 20000.0;            // unknowns: every rank has all factors

/// Nodes in the smallest plane cut through a mesh, from its extents and its mean cell size. Collective.
double smallest_cut(const mesh::HexMesh& mesh) {
  std::array<double, 6> ends;
  ends.fill(-std::numeric_limits<double>::max());
  for (Index a = 0; a < mesh.local_nodes(); ++a)
    for (int d = 0; d < 3; ++d) {
      ends[d] = std::max(ends[d], -mesh.node(a)[d]);
      ends[d + 3] = std::max(ends[d + 3], mesh.node(a)[d]);
    }
  MPI_Allreduce(MPI_IN_PLACE, ends.data(), 6, MPI_DOUBLE, MPI_MAX, mesh.comm.get());
  std::array<double, 3> extent = {ends[0] + ends[3], ends[1] + ends[4], ends[2] + ends[5]};
  std::sort(extent.begin(), extent.end());
  const double h = std::cbrt(extent[0] * extent[1] * extent[2] / static_cast<double>(mesh.global_nodes));
  return (extent[0] / h + 1.0) * (extent[1] / h + 1.0);
}

}  // namespace

bool is_solved_directly(const Setup& setup) {
  if (setup.fluid == nullptr) return false;
  return fsi::solves_directly(setup.parameters.solver, *setup.fluid);
}

MemoryNeed memory_need(const Setup& setup, bool direct) {
  MemoryNeed need;
  const double ranks = setup.fiber_mesh->comm.size();
  need.programs = per_rank * ranks;
  need.fibers = per_fiber_node * static_cast<double>(setup.fiber_mesh->global_nodes);
  if (setup.fluid_mesh == nullptr) return need;
  const mesh::HexMesh& mesh = *setup.fluid_mesh;
  const double nodes = static_cast<double>(mesh.global_nodes), unknowns = 4.0 * nodes;
  const bool single = setup.parameters.solver.precision == fsi::Precision::mixed && setup.fluid->has_single_precision();
  need.fluid = single ? (mesh.box ? per_box_node : per_general_node) * nodes
                      : (mesh.box ? twofold_per_box_node : twofold_per_general_node) * nodes;
  if (setup.parameters.solver.linear == fsi::LinearSolver::reference) need.factors = reference_per_node * nodes;
  if (!direct) return need;
  const double factors = factor_per_unknown * std::sqrt(4.0 * smallest_cut(mesh)) * unknowns;
  const double copies = ranks == 1.0 ? 1.0 : unknowns < whole_below ? ranks : factors_of_several_ranks;
  need.factors = entries_per_unknown * unknowns + copies * factors;
  return need;
}

std::string memory_warning(const Setup& setup, const MemoryNeed& need, double available) {
  const Comm& comm = setup.fiber_mesh->comm;
  const MemoryShare share = memory_share(comm, need.total() / comm.size(), available);
  if (share.fits()) return "";
  const bool factors = need.factors > 0.5 * need.total();
  const char* remedy = factors ? "set solver.linear to \"iterative\", which needs no factors, or use fewer elements"
                       : comm.size() > 1 ? "use fewer elements, or spread the ranks over more machines"
                                         : "use fewer elements, or several machines (mpirun --host ... fbi-run)";
  return log::format(
      "not enough memory: the run needs about %s on a machine that has %s left for it, and will be ended by the system "
      "when that is used up; %s",
      memory_text(share.need).c_str(), memory_text(share.available).c_str(), remedy);
}

}  // namespace fbi::cases
