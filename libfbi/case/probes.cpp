#include "case/probes.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "base/log.hpp"
#include "coupling/projection.hpp"
#include "fem/hex8.hpp"

namespace fbi::cases {
namespace {

/// The local cell of lowest file id that holds the point, or -1; `xi` receives the reference point.
Index find_cell(const mesh::HexMesh& mesh, const Vec3& point, Vec3& xi) {
  for (Index c = 0; c < mesh.local_cells(); ++c) {
    const coupling::Cell cell = coupling::make_cell(mesh, c);
    const Vec3 low = cell.corners.rowwise().minCoeff(), high = cell.corners.rowwise().maxCoeff();
    const double slack = 1e-6 * cell.size;
    if (((point.array() < low.array() - slack) || (point.array() > high.array() + slack)).any()) continue;
    xi.setZero();
    if (coupling::project(cell, point, xi) && coupling::is_inside(xi)) return c;
  }
  return -1;
}

void add_columns(const std::string& base, const char* unit, std::vector<std::string>& columns,
                 std::vector<std::string>& units) {
  for (const char* component : {"_x", "_y", "_z"}) {
    columns.push_back(base + component);
    units.push_back(unit);
  }
}

}  // namespace

ProbeSet::ProbeSet(const std::vector<Probe>& probes, const mesh::FiberMesh& fibers, const mesh::HexMesh* fluid)
    : comm_(fibers.comm) {
  int points = 0;
  std::string problem;
  for (const Probe& probe : probes) {
    Located located;
    located.probe = probe;
    if (!probe.fiber.empty()) {
      for (Index f = 0; f < fibers.fibers(); ++f)
        if (fibers.name[f] == probe.fiber) located.fiber = f;
      if (!comm_.any(located.fiber >= 0))
        problem += log::format("output.probes: there is no fiber \"%s\"; fbi-post info lists the names\n",
                               probe.fiber.c_str());
      if (probe.forces) {
        located.columns = 6;
        add_columns(probe.fiber + ":drag", "force", columns_, units_);
        add_columns(probe.fiber + ":reaction", "force", columns_, units_);
      } else {
        add_columns(probe.fiber + (probe.at == beam::End::end ? "" : "@start") + ":displacement", "length", columns_,
                    units_);
      }
    } else {
      Vec3 xi = Vec3::Zero();
      const Index cell = fluid != nullptr ? find_cell(*fluid, probe.point, xi) : -1;
      // A point on faces belongs to the cell of the lowest file id, whatever rank it is on.
      const double mine = cell >= 0 ? static_cast<double>(fluid->cell_id[cell]) : 1e300;
      const double lowest = comm_.min(mine);
      if (lowest == 1e300)
        problem += log::format("output.probes: the point (%g, %g, %g) lies outside the fluid\n", probe.point[0],
                               probe.point[1], probe.point[2]);
      if (cell >= 0 && mine == lowest) {
        located.cell = cell;
        located.shape = fem::hex8_shape(xi);
      }
      located.columns = 4;
      const std::string base = log::format("point/%d", points++);
      add_columns(base + ":velocity", "length/time", columns_, units_);
      columns_.push_back(base + ":pressure");
      units_.push_back("force/area");
    }
    located_.push_back(located);
  }
  if (!problem.empty()) problem.pop_back();
  agree_on_error(comm_, ExitCode::usage, problem);
}

void ProbeSet::add_forces(const std::vector<ForceOutput>& outputs, const fluid::FluidField* fluid) {
  forces_ = std::make_unique<ForceOutputs>(outputs, fluid);
  columns_.insert(columns_.end(), forces_->columns().begin(), forces_->columns().end());
  units_.insert(units_.end(), forces_->units().begin(), forces_->units().end());
}

std::vector<double> ProbeSet::values(const fsi::System& system) const {
  std::vector<double> values(columns_.size(), 0.0);
  bool forces = false;
  for (const Located& located : located_) forces = forces || located.probe.forces;
  std::vector<double> reactions;
  if (forces && system.has_fibers()) {
    // The force in the fibers' last equation, w f_{n+1} + (1-w) f_n, was formed before the step was accepted; at the
    // accepted state the end force f_{n+1} is what the fluid exerts.
    reactions = system.beams().reactions(system.last_force());
  }
  std::size_t column = 0;
  for (const Located& located : located_) {
    double* out = values.data() + column;
    column += located.columns;
    if (located.fiber >= 0) {
      const mesh::FiberMesh& fibers = system.fibers();
      const Index begin = fibers.first_node[located.fiber], end = fibers.first_node[located.fiber + 1];
      if (located.probe.forces) {
        if (system.is_coupled())
          for (Index n = begin; n < end; ++n)
            for (int i = 0; i < 3; ++i) out[i] += system.force_old()[6 * static_cast<std::size_t>(n) + i];
        for (Index n = begin; n < end; ++n)
          for (int i = 0; i < 3; ++i) out[3 + i] += reactions[6 * static_cast<std::size_t>(n) + i];
      } else {
        const std::size_t node = located.probe.at == beam::End::end ? end - 1 : begin;
        for (int i = 0; i < 3; ++i)
          out[i] = system.beams().accepted_dofs()[6 * node + i] - fibers.position[3 * node + i];
      }
    } else if (located.cell >= 0) {
      const mesh::HexMesh& mesh = system.fluid().mesh();
      Vec form = nullptr;
      const double* u = nullptr;
      FBI_PETSC(VecGhostGetLocalForm(system.fluid().accepted(), &form));
      FBI_PETSC(VecGetArrayRead(form, &u));
      for (int a = 0; a < 8; ++a) {
        const std::size_t node = mesh.cells[8 * static_cast<std::size_t>(located.cell) + a];
        for (int i = 0; i < 4; ++i) out[i] += located.shape[a] * u[4 * node + i];
      }
      FBI_PETSC(VecRestoreArrayRead(form, &u));
      FBI_PETSC(VecGhostRestoreLocalForm(system.fluid().accepted(), &form));
    }
  }
  // Each value is on one rank and zero elsewhere.
  comm_.sum(values.data(), static_cast<int>(values.size()));
  if (forces_ != nullptr) {
    const std::vector<double> forces = forces_->values(system);
    std::copy(forces.begin(), forces.end(), values.end() - static_cast<std::ptrdiff_t>(forces.size()));
  }
  return values;
}

}  // namespace fbi::cases
