/// Values recorded in every row of the history: fiber ends, forces on fibers, fluid points.
#pragma once

#include <string>
#include <vector>

#include "case/force_outputs.hpp"
#include "case/schema.hpp"
#include "fsi/system.hpp"

namespace fbi::cases {

/// The probes of a case, located once.
///
/// Columns: `NAME:displacement_x` (_y, _z) of a fiber's end; `NAME:drag_x` ... (force of the fluid on the fiber) and
/// `NAME:reaction_x` ... (force of its supports on it) with `forces`; `point/I:velocity_x` ... and `point/I:pressure`
/// for the I-th point of the case file.
class ProbeSet {
 public:
  /// Throws Error(usage) on all ranks for a fiber that does not exist or a point outside the fluid. `fluid` may be
  /// null. Collective.
  ProbeSet(const std::vector<Probe>& probes, const mesh::FiberMesh& fibers, const mesh::HexMesh* fluid);

  /// Appends the columns of forces on faces. Collective.
  void add_forces(const std::vector<ForceOutput>& outputs, const fluid::FluidField* fluid);

  const std::vector<std::string>& columns() const { return columns_; }
  const std::vector<std::string>& units() const { return units_; }
  /// Values of the accepted state, the same on all ranks. Collective.
  std::vector<double> values(const fsi::System& system) const;

 private:
  struct Located {
    Probe probe;
    Index fiber = -1;  // local fiber on the rank that has it
    Index cell = -1;   // local cell on the rank that has it
    std::array<double, 8> shape{};
    int columns = 3;
  };
  Comm comm_;
  std::vector<Located> located_;
  std::vector<std::string> columns_, units_;
  std::unique_ptr<ForceOutputs> forces_;
};

}  // namespace fbi::cases
