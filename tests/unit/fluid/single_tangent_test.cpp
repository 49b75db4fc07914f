// The tangent in single precision against the one in double precision, on any number of ranks; rows of cells and
// others.
#include "fluid/single_tangent.hpp"

#include <gtest/gtest.h>

#include "fem/simd.hpp"
#include "fluid_scene.hpp"
#include "record.hpp"

namespace fbi::fluid::test {
namespace {

const Option options[] = {
    {"box", 0, ConvectiveForm::advective, ViscousResidual::full, TimeScheme::one_step_theta, 0.5},
    {"box, no viscous residual", 0, ConvectiveForm::advective, ViscousResidual::none, TimeScheme::one_step_theta, 1.0},
    {"box, Stokes", 0, ConvectiveForm::none, ViscousResidual::full, TimeScheme::one_step_theta, 0.7},
    {"general", 0.2, ConvectiveForm::advective, ViscousResidual::full, TimeScheme::one_step_theta, 0.5},
    {"general, no viscous residual", 0.2, ConvectiveForm::advective, ViscousResidual::none, TimeScheme::one_step_theta,
     1.0},
    {"general, Stokes", 0.2, ConvectiveForm::none, ViscousResidual::none, TimeScheme::one_step_theta, 1.0},
};

/// Product with all columns, continuity rows times `scale`, on owned nodes.
std::vector<float> single_product(const mesh::HexMesh& mesh, const FluidField& field, SingleTangent& tangent,
                                  const std::vector<double>& x, float scale) {
  std::vector<float> in(4 * static_cast<std::size_t>(mesh.local_nodes())), out(in.size(), -1.0f);
  for (std::size_t k = 0; k < x.size(); ++k) in[k] = field.is_dirichlet()[k] != 0 ? 0.0f : static_cast<float>(x[k]);
  tangent.remove_normal(in.data(), mesh.owned_nodes);
  tangent.halo().update_ghosts(in.data());
  tangent.set_continuity_scale(scale);
  tangent.apply_to_pressure(in.data(), out.data());
  tangent.add_velocity(in.data(), out.data(), nullptr);
  return out;
}

TEST(SingleTangent, IsTheTangent) {
  linalg::initialize_petsc();
  for (const Option& option : options) {
    Scene scene(Comm(MPI_COMM_WORLD), option);
    SingleTangent* tangent = scene.field.single_tangent();
    ASSERT_NE(tangent, nullptr);
    linalg::VecHandle x = scene.field.create_vector(), y = scene.field.create_vector();
    fill(scene.mesh, x, [&](GlobalIndex node, int c) { return noise(node, c, 7); });
    scene.field.apply_jacobian(x, y);
    const std::vector<double> exact = owned_values(y);
    const float scale = 8.0f;
    const std::vector<float> single = single_product(scene.mesh, scene.field, *tangent, owned_values(x), scale);
    double largest[2] = {0, 0}, error[2] = {0, 0};  // momentum, continuity
    for (std::size_t k = 0; k < exact.size(); ++k) {
      if (scene.field.is_dirichlet()[k] != 0) {
        EXPECT_EQ(single[k], 0.0f);
        continue;
      }
      const int row = k % 4 == 3 ? 1 : 0;
      const double value = row == 1 ? single[k] / scale : single[k];
      largest[row] = std::max(largest[row], std::abs(exact[k]));
      error[row] = std::max(error[row], std::abs(value - exact[k]));
    }
    for (int row = 0; row < 2; ++row) {
      const double relative = scene.mesh.comm.max(error[row]) / scene.mesh.comm.max(largest[row]);
      fbi::test::record({.section = "Fluid",
                         .check = std::string("tangent in single against double precision, ") +
                                  (row == 0 ? "momentum rows: " : "continuity rows: ") + option.name,
                         .source = "second scheme",
                         .reference = 0.0,
                         .ours = relative,
                         .bar = "2e-6"});
      EXPECT_LT(relative, 2e-6) << option.name << " row " << row;
    }
  }
}

TEST(SingleTangent, IsNotThereForEquationsThatItDoesNotHave) {
  linalg::initialize_petsc();
  const Option option{"projection",
                      0,
                      ConvectiveForm::advective,
                      ViscousResidual::full,
                      TimeScheme::one_step_theta,
                      1.0,
                      [](FluidParameters& p) { p.pressure_stabilization = PressureStabilization::projection; }};
  Scene scene(Comm(MPI_COMM_WORLD), option);
  EXPECT_EQ(scene.field.single_tangent(), nullptr);
}

// The two ways to sixteen nodes agree where both apply, and lanes left out stay out.
TEST(SingleTangent, RowsOfNodesAreNodesOneAfterTheOther) {
  std::vector<float> array(4 * 20), copy;
  for (std::size_t k = 0; k < array.size(); ++k) array[k] = 0.25f * static_cast<float>(k);
  Index node[16];
  for (int i = 0; i < 16; ++i) node[fem::lane_of_sixteen(i)] = 3 + i;
  fem::BatchOf<float> one[4], other[4];
  fem::gather_row(array.data(), 3, one);
  fem::gather_four(array.data(), node, other);
  for (int c = 0; c < 4; ++c)
    for (int lane = 0; lane < 16; ++lane) {
      EXPECT_EQ(one[c][lane], array[4 * node[lane] + c]);
      EXPECT_EQ(one[c][lane], other[c][lane]);
    }
  copy = array;
  fem::scatter_add_row(one, 3, copy.data());
  std::vector<float> twice = array;
  fem::scatter_add_four(one, node, 16, twice.data());
  EXPECT_EQ(copy, twice);
  for (std::size_t k = 0; k < array.size(); ++k) EXPECT_EQ(copy[k], (k >= 12 && k < 76 ? 2.0f : 1.0f) * array[k]) << k;
  std::vector<float> some = array;
  fem::scatter_add_four(one, node, 5, some.data());
  for (std::size_t k = 0; k < array.size(); ++k) EXPECT_EQ(some[k], (k >= 12 && k < 32 ? 2.0f : 1.0f) * array[k]) << k;
}

}  // namespace
}  // namespace fbi::fluid::test
