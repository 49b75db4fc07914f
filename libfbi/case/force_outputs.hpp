/// Forces of the fluid on named faces, recorded in every row of the history.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "case/schema.hpp"
#include "fluid/boundary_forces.hpp"
#include "fsi/system.hpp"

namespace fbi::cases {

/// The forces of a case. Columns: `NAME:force_x` (_y, _z); `NAME:moment_x` ... with a point; `NAME:coefficient_x` ...
/// = force / (rho speed^2 area/2) with a reference.
class ForceOutputs {
 public:
  /// Nothing is computed when the list is empty; `fluid` may be null then. Throws Error(usage) on all ranks for a face
  /// set that the mesh does not have. Collective.
  ForceOutputs(const std::vector<ForceOutput>& outputs, const fluid::FluidField* fluid);

  const std::vector<std::string>& columns() const { return columns_; }
  const std::vector<std::string>& units() const { return units_; }
  /// Values of the step accepted last, with the forces of fibers at boundary nodes, the same on all ranks. Collective.
  std::vector<double> values(const fsi::System& system) const;

 private:
  std::vector<ForceOutput> outputs_;
  std::vector<std::string> columns_, units_;
  std::unique_ptr<fluid::BoundaryForces> forces_;
};

}  // namespace fbi::cases
