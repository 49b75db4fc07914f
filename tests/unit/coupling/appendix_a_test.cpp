// One fiber element in one distorted hexahedron: Appendix A of Hagemeyer, Mayr, Popp 2024 with its misprints corrected.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "coupling/coupling_matrices.hpp"
#include "record.hpp"

namespace fbi::coupling {
namespace {

TEST(AppendixA, MatricesToTwelveDigits) {
  std::ifstream file(FBI_SOURCE_DIR "/tests/unit/coupling/data/appendix_a.json");
  ASSERT_TRUE(file.good());
  const nlohmann::json data = nlohmann::json::parse(file);
  double dofs[12];
  for (int i = 0; i < 3; ++i) {
    dofs[i] = data["beam"]["x1"][i];
    dofs[3 + i] = data["beam"]["t1"][i];
    dofs[6 + i] = data["beam"]["x2"][i];
    dofs[9 + i] = data["beam"]["t2"][i];
  }
  const double length = data["beam"]["ref_length"];
  Eigen::Matrix<double, 3, 8> corners;
  for (int a = 0; a < 8; ++a)
    for (int i = 0; i < 3; ++i) corners(i, a) = data["hex_nodes"][a][i];
  const Curve curve = hermite_curve(dofs, dofs + 6, length);
  const Measure measure = make_measure(curve);
  const fem::QuadratureRule rule = fem::gauss_legendre(data["gauss_points"]);
  const Basis basis(Multiplier::linear);
  std::vector<IntegrationPoint> points;
  integration_points(measure, rule, {.cell = 0, .begin = -1.0, .end = 1.0}, points);
  ElementIntegrals fiber;
  fiber.reset(2);
  integrate_fiber(basis, 0.5 * length, points, fiber);
  std::vector<std::array<double, 8>> m(2);
  ASSERT_TRUE(integrate_fluid(basis, curve, make_cell(corners), points, m));
  double worst = 0.0;
  for (int p = 0; p < 2; ++p) {
    worst = std::max(worst, std::abs(fiber.kappa[p] - data["kappa"][p].get<double>()));
    for (int j = 0; j < 4; ++j)
      worst =
          std::max(worst, std::abs(fiber.d[p][j] - data["D_rows_multiplier_columns_d1_t1_d2_t2"][p][j].get<double>()));
    for (int a = 0; a < 8; ++a)
      worst = std::max(worst, std::abs(m[p][a] - data["M_rows_multiplier_columns_hex_nodes"][p][a].get<double>()));
    EXPECT_NEAR(fiber.kappa[p], data["kappa"][p].get<double>(), 1e-12);
    for (int j = 0; j < 4; ++j)
      EXPECT_NEAR(fiber.d[p][j], data["D_rows_multiplier_columns_d1_t1_d2_t2"][p][j].get<double>(), 1e-12);
    double sum = 0.0;
    for (int a = 0; a < 8; ++a) {
      EXPECT_NEAR(m[p][a], data["M_rows_multiplier_columns_hex_nodes"][p][a].get<double>(), 1e-12);
      sum += m[p][a];
    }
    EXPECT_NEAR(sum, fiber.kappa[p], 1e-15);
    EXPECT_NEAR(fiber.d[p][0] + fiber.d[p][2], fiber.kappa[p], 1e-15);
  }
  fbi::test::record({.section = "Coupling",
                     .check = "D, M, kappa of one fiber element in a distorted hexahedron: largest difference",
                     .source = "Hagemeyer, Mayr, Popp 2024, appendix A, in full precision",
                     .reference = 0.0,
                     .ours = worst,
                     .bar = "1e-12"});
}

}  // namespace
}  // namespace fbi::coupling
