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

std::vector<double> diagonal_of(const fluid::FluidField& fluid, const std::vector<float>& nodal) {
  const std::vector<char>& dirichlet = fluid.is_dirichlet();
  std::vector<double> diagonal(3 * static_cast<std::size_t>(fluid.mesh().local_nodes()));
  for (std::size_t a = 0; a < diagonal.size() / 3; ++a)
    for (int i = 0; i < 3; ++i) diagonal[3 * a + i] = dirichlet[4 * a + i] != 0 ? 0.0 : nodal[4 * a];
  return diagonal;
}

}  // namespace fbi::fsi
