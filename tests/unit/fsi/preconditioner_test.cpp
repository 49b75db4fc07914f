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

/// Volume integral of rho v . slope by one point a cell, with the mean velocity of its corners.
double convected(const Scene& scene) {
  LocalArray velocity(const_cast<Scene&>(scene).field.iterate());
  double sum = 0.0;
  for (Index c = 0; c < scene.mesh.local_cells(); ++c) {
    Vec3 v = Vec3::Zero();
    for (int a = 0; a < 8; ++a)
      v += 0.125 * Eigen::Map<const Vec3>(velocity.data() + 4 * scene.mesh.cells[8 * static_cast<std::size_t>(c) + a]);
    sum += scene.field.parameters().density * scene.field.cell_volume(c) * v.dot(slope);
  }
  return scene.mesh.comm.sum(sum);
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
    double sum = 0.0, others = 0.0;
    for (std::size_t k = 0; k < y.size(); ++k) (k % 4 == 3 ? sum : others) += y[k];
    const double exact = convected(scene);
    EXPECT_NEAR(scene.mesh.comm.sum(sum), exact, 1e-5 * std::abs(exact)) << option.name;
    EXPECT_EQ(others, 0.0);
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
  const double before = convected(scene);
  linalg::VecHandle delta = scene.field.create_vector();
  fill(scene.mesh, delta, [](GlobalIndex node, int c) { return noise(node, c, 9); });
  scene.drop_dirichlet(delta);
  scene.field.increment(delta);
  convection.renew();
  const std::vector<float> q = pressure(scene, [](const Vec3& x) { return slope.dot(x); });
  std::vector<float> y(q.size(), 0.0f);
  convection.add(q.data(), y.data());
  double sum = 0.0;
  for (std::size_t k = 3; k < y.size(); k += 4) sum += y[k];
  const double after = convected(scene);
  EXPECT_GT(std::abs(after - before), 1e-3);
  EXPECT_NEAR(scene.mesh.comm.sum(sum), after, 1e-5 * std::abs(after));
}

// The nodal mean of tau_C keeps its integral, and is tau_C where that is the same in all cells.
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
      Vec3 v = Vec3::Zero();
      for (int a = 0; a < 8; ++a)
        v +=
            0.125 * Eigen::Map<const Vec3>(velocity.data() + 4 * scene.mesh.cells[8 * static_cast<std::size_t>(c) + a]);
      const double volume = scene.field.cell_volume(c);
      sums[0] += volume * 0.5 * scene.field.parameters().density * v.norm() * std::cbrt(volume);
    }
    for (Index n = 0; n < scene.mesh.owned_nodes; ++n) sums[1] += scene.field.lumped_volume()[n] * grad_div[n];
    scene.mesh.comm.sum(sums, 2);
    // Volumes of warped cells and of their middles' parallelepipeds differ.
    EXPECT_NEAR(sums[1], sums[0], (option.warp > 0.0 ? 1e-2 : 1e-12) * sums[0]) << option.name;
  }
}

}  // namespace
}  // namespace fbi::fluid::test
