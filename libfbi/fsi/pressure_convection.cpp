#include "fsi/pressure_convection.hpp"

#include <Eigen/LU>

#include "fem/hex8.hpp"
#include "linalg/vector_access.hpp"

namespace fbi::fsi {

PressureConvection::PressureConvection(fluid::FluidField& fluid)
    : fluid_(fluid), flow_(3 * static_cast<std::size_t>(fluid.mesh().local_cells())) {}

void PressureConvection::renew() {
  const mesh::HexMesh& mesh = fluid_.mesh();
  const double density = fluid_.parameters().density;
  const Eigen::Matrix<double, 8, 3> slope = fem::hex8_gradient(Vec3::Zero());
  linalg::GhostedForm form(fluid_.iterate());
  linalg::Read velocity(form.get());
  for (Index c = 0; c < mesh.local_cells(); ++c) {
    const Index* nodes = &mesh.cells[8 * static_cast<std::size_t>(c)];
    Mat3 jacobian = Mat3::Zero();
    Vec3 v = Vec3::Zero();
    for (int a = 0; a < 8; ++a) {
      jacobian += Eigen::Map<const Vec3>(mesh.node(nodes[a])) * slope.row(a);
      v += 0.125 * Eigen::Map<const Vec3>(velocity.get() + 4 * static_cast<std::size_t>(nodes[a]));
    }
    const Vec3 flow = density * fluid_.cell_volume(c) / 64.0 * (jacobian.inverse() * v);
    for (int d = 0; d < 3; ++d) flow_[3 * static_cast<std::size_t>(c) + d] = static_cast<float>(flow[d]);
  }
}

void PressureConvection::add(const float* q, float* y) const {
  const mesh::HexMesh& mesh = fluid_.mesh();
  for (std::size_t c = 0; c < static_cast<std::size_t>(mesh.local_cells()); ++c) {
    const Index* nodes = &mesh.cells[8 * c];
    float sum = 0.0f;
    for (int a = 0; a < 8; ++a) {
      float along = 0.0f;
      for (int d = 0; d < 3; ++d) along += fem::hex8_corners[a][d] > 0.0 ? flow_[3 * c + d] : -flow_[3 * c + d];
      sum += along * q[4 * static_cast<std::size_t>(nodes[a]) + 3];
    }
    for (int a = 0; a < 8; ++a) y[4 * static_cast<std::size_t>(nodes[a]) + 3] += sum;
  }
}

}  // namespace fbi::fsi
