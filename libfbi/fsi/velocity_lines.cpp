#include "fsi/velocity_lines.hpp"

#include "fsi/box_lines.hpp"
#include "fsi/mesh_lines.hpp"

namespace fbi::fsi {

std::unique_ptr<VelocityLines> make_velocity_lines(const fluid::FluidField& fluid) {
  if (BoxLines::supports(fluid.mesh())) return std::make_unique<BoxLines>(fluid);
  return std::make_unique<MeshLines>(fluid);
}

LineTerms::LineTerms(const fluid::FluidField& fluid)
    : density_(static_cast<float>(fluid.parameters().density)),
      viscosity_(static_cast<float>(fluid.parameters().viscosity)),
      sigma_(static_cast<float>(fluid.sigma())) {}

}  // namespace fbi::fsi
