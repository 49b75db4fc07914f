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

/// Largest difference between the owned entries, over the largest entry.
template <class T>
double distance(const mesh::HexMesh& mesh, const std::vector<T>& a, const std::vector<T>& b) {
  double largest = 0.0, difference = 0.0;
  for (std::size_t k = 0; k < 4 * static_cast<std::size_t>(mesh.owned_nodes); ++k) {
    largest = std::max(largest, std::abs(static_cast<double>(a[k])));
    difference = std::max(difference, std::abs(static_cast<double>(a[k]) - b[k]));
  }
  return mesh.comm.max(difference) / mesh.comm.max(largest);
}

// A residual that linearises as well: the same residual, and a tangent that is that of its iterate, not of an older
// one. Compilers contract products and sums of the two ways differently.
TEST(SingleTangent, TakenWithTheResidualIsTheSame) {
  linalg::initialize_petsc();
  for (const Option& option : options) {
    Scene scene(Comm(MPI_COMM_WORLD), option);
    FluidField& field = scene.field;
    linalg::VecHandle x = field.create_vector(), r = field.create_vector(), change = field.create_vector();
    fill(scene.mesh, x, [&](GlobalIndex node, int c) { return noise(node, c, 7); });
    fill(scene.mesh, change, [&](GlobalIndex node, int c) { return 0.1 * noise(node, c, 3); });
    const auto product = [&] {
      return single_product(scene.mesh, field, *field.single_tangent(), owned_values(x), 1.0f);
    };
    field.linearize();
    const std::vector<float> before = product();
    field.increment(change);
    field.residual(r);
    const std::vector<double> residual = owned_values(r);
    field.linearize();
    const std::vector<float> separate = product();
    field.residual(r, nullptr, true);
    EXPECT_LT(distance(scene.mesh, residual, owned_values(r)), 1e-13) << option.name;
    field.linearize();
    EXPECT_LT(distance(scene.mesh, separate, product()), 1e-6) << option.name;
    EXPECT_LT(distance(scene.mesh, separate, product()), 1e-6) << option.name << ", taken again";
    const double moved = distance(scene.mesh, separate, before);
    if (option.form == ConvectiveForm::none) {
      EXPECT_LT(moved, 1e-6) << option.name;
    } else {
      EXPECT_GT(moved, 1e-3) << option.name;
    }
    // What was taken with a residual does not outlive its iterate.
    field.residual(r, nullptr, true);
    FBI_PETSC(VecScale(change, -1.0));
    field.increment(change);
    field.linearize();
    EXPECT_LT(distance(scene.mesh, before, product()), 1e-5) << option.name;
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

// The ways to sixteen nodes agree where they apply, and lanes left out stay out. All numbers are sums of powers of two.
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
  fem::BatchOf<float> high[4];
  for (int c = 0; c < 4; ++c) high[c] = 8.0f * one[c];
  fem::scatter_add_edges(one, high, 3, copy.data());
  std::vector<float> twice = array;
  fem::scatter_add_four(one, node, 16, twice.data());
  for (std::size_t k = 0; k < array.size(); ++k) EXPECT_EQ(twice[k], (k >= 12 && k < 76 ? 2.0f : 1.0f) * array[k]) << k;
  for (int i = 0; i < 16; ++i) node[fem::lane_of_sixteen(i)] = 4 + i;
  fem::scatter_add_four(high, node, 16, twice.data());
  EXPECT_EQ(copy, twice);
  for (int i = 0; i < 16; ++i) node[fem::lane_of_sixteen(i)] = 3 + i;
  std::vector<float> some = array;
  fem::scatter_add_four(one, node, 5, some.data());
  for (std::size_t k = 0; k < array.size(); ++k) EXPECT_EQ(some[k], (k >= 12 && k < 32 ? 2.0f : 1.0f) * array[k]) << k;
}

}  // namespace
}  // namespace fbi::fluid::test
