// Parts of the preconditioner against what they approximate, on any number of ranks.
#include <gtest/gtest.h>

#include "fsi/pressure_convection.hpp"
#include "fsi/velocity_weight.hpp"
#include "unit/fluid/fluid_scene.hpp"

namespace fbi::fluid::test {
namespace {

constexpr Option scenes[] = {
    {"box", 0, ConvectiveForm::advective, ViscousResidual::full, TimeScheme::one_step_theta, 0.5},
    {"general", 0.2, ConvectiveForm::advective, ViscousResidual::full, TimeScheme::one_step_theta, 0.5},
};
const Vec3 slope(0.3, -1.1, 0.7);

/// Mean velocity of the corners of a cell; `velocity` has four numbers a node.
Vec3 mean_velocity(const mesh::HexMesh& mesh, const double* velocity, Index cell) {
  Vec3 v = Vec3::Zero();
  for (int a = 0; a < 8; ++a)
    v += 0.125 * Eigen::Map<const Vec3>(velocity + 4 * mesh.cells[8 * static_cast<std::size_t>(cell) + a]);
  return v;
}

/// Volume integral of rho v . slope by one point a cell, and its first moments: shares of a cell are its corners'.
Eigen::Vector4d convected(Scene& scene) {
  LocalArray velocity(scene.field.iterate());
  Eigen::Vector4d sums = Eigen::Vector4d::Zero();
  for (Index c = 0; c < scene.mesh.local_cells(); ++c) {
    const double amount = scene.field.parameters().density * scene.field.cell_volume(c) *
                          mean_velocity(scene.mesh, velocity.data(), c).dot(slope);
    sums[0] += amount;
    for (int a = 0; a < 8; ++a)
      sums.tail<3>() += 0.125 * amount *
                        Eigen::Map<const Vec3>(scene.mesh.node(scene.mesh.cells[8 * static_cast<std::size_t>(c) + a]));
  }
  scene.mesh.comm.sum(sums.data(), 4);
  return sums;
}

/// The same of what was added to the fourth entries of nodes.
Eigen::Vector4d added(const Scene& scene, const std::vector<float>& y) {
  Eigen::Vector4d sums = Eigen::Vector4d::Zero();
  for (Index n = 0; n < scene.mesh.local_nodes(); ++n) {
    const double amount = y[4 * static_cast<std::size_t>(n) + 3];
    sums[0] += amount;
    sums.tail<3>() += amount * Eigen::Map<const Vec3>(scene.mesh.node(n));
  }
  scene.mesh.comm.sum(sums.data(), 4);
  return sums;
}

std::vector<float> pressure(const Scene& scene, const std::function<double(const Vec3&)>& q) {
  std::vector<float> nodal(4 * static_cast<std::size_t>(scene.mesh.local_nodes()), 7.0f);
  for (Index n = 0; n < scene.mesh.local_nodes(); ++n)
    nodal[4 * static_cast<std::size_t>(n) + 3] = static_cast<float>(q(Eigen::Map<const Vec3>(scene.mesh.node(n))));
  return nodal;
}

TEST(PressureConvection, OfLinearPressures) {
  linalg::initialize_petsc();
  for (const Option& option : scenes) {
    Scene scene(Comm(MPI_COMM_WORLD), option);
    fsi::PressureConvection convection(scene.field);
    convection.renew();
    const std::vector<float> q = pressure(scene, [](const Vec3& x) { return 2.0 + slope.dot(x); });
    std::vector<float> y(q.size(), 0.0f);
    convection.add(q.data(), y.data());
    const Eigen::Vector4d exact = convected(scene);
    EXPECT_LT((added(scene, y) - exact).norm(), 1e-5 * exact.norm()) << option.name;
    for (std::size_t k = 0; k < y.size(); ++k) EXPECT_TRUE(k % 4 == 3 || y[k] == 0.0f);
    const std::vector<float> constant = pressure(scene, [](const Vec3&) { return 3.0; });
    std::vector<float> nothing(q.size(), 0.0f);
    convection.add(constant.data(), nothing.data());
    for (const float value : nothing) EXPECT_NEAR(value, 0.0, 1e-6);
  }
}

TEST(PressureConvection, FollowsTheIterate) {
  linalg::initialize_petsc();
  Scene scene(Comm(MPI_COMM_WORLD), scenes[1]);
  fsi::PressureConvection convection(scene.field);
  convection.renew();
  const Eigen::Vector4d before = convected(scene);
  linalg::VecHandle delta = scene.field.create_vector();
  fill(scene.mesh, delta, [](GlobalIndex node, int c) { return noise(node, c, 9); });
  scene.drop_dirichlet(delta);
  scene.field.increment(delta);
  convection.renew();
  const std::vector<float> q = pressure(scene, [](const Vec3& x) { return slope.dot(x); });
  std::vector<float> y(q.size(), 0.0f);
  convection.add(q.data(), y.data());
  const Eigen::Vector4d after = convected(scene);
  EXPECT_GT((after - before).norm(), 1e-2 * after.norm());
  EXPECT_LT((added(scene, y) - after).norm(), 1e-5 * after.norm());
}

// The nodal mean of tau_C keeps its integral.
TEST(VelocityWeight, GradDivAtNodes) {
  linalg::initialize_petsc();
  for (const Option& option : scenes) {
    Scene scene(Comm(MPI_COMM_WORLD), option);
    fsi::VelocityWeight weight(scene.field);
    weight.renew();
    const std::vector<double> grad_div = weight.grad_div();
    ASSERT_EQ(grad_div.size(), static_cast<std::size_t>(scene.mesh.local_nodes()));
    LocalArray velocity(scene.field.iterate());
    double sums[2] = {0.0, 0.0};
    for (Index c = 0; c < scene.mesh.local_cells(); ++c) {
      const double volume = scene.field.cell_volume(c);
      sums[0] += volume * 0.5 * scene.field.parameters().density *
                 mean_velocity(scene.mesh, velocity.data(), c).norm() * std::cbrt(volume);
    }
    for (Index n = 0; n < scene.mesh.owned_nodes; ++n) sums[1] += scene.field.lumped_volume()[n] * grad_div[n];
    scene.mesh.comm.sum(sums, 2);
    // Volumes of warped cells and of their middles' parallelepipeds differ.
    EXPECT_NEAR(sums[1], sums[0], (option.warp > 0.0 ? 1e-2 : 1e-12) * sums[0]) << option.name;
  }
}

}  // namespace
}  // namespace fbi::fluid::test
