// Curves, crossings, inverse maps and segments of single elements.
#include "coupling/segmentation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "coupling/coupling_matrices.hpp"
#include "coupling/face_crossings.hpp"
#include "fem/hex8.hpp"
#include "fem/line_shapes.hpp"

namespace fbi::coupling {
namespace {

Eigen::Matrix<double, 3, 8> unit_cell() {
  Eigen::Matrix<double, 3, 8> corners;
  for (int a = 0; a < 8; ++a)
    for (int i = 0; i < 3; ++i) corners(i, a) = 0.5 * (1.0 + fem::hex8_corners[a][i]);
  return corners;
}

Eigen::Matrix<double, 3, 8> random_cell(std::mt19937& random, double amount) {
  std::uniform_real_distribution<double> shift(-amount, amount);
  Eigen::Matrix<double, 3, 8> corners = unit_cell();
  for (int a = 0; a < 8; ++a)
    for (int i = 0; i < 3; ++i) corners(i, a) += shift(random);
  return corners;
}

Curve line(const Vec3& from, const Vec3& to) {
  const double length = (to - from).norm();
  const Vec3 t = (to - from) / length;
  const double dofs[12] = {from[0], from[1], from[2], t[0], t[1], t[2], to[0], to[1], to[2], t[0], t[1], t[2]};
  return hermite_curve(dofs, dofs + 6, length);
}

TEST(Curve, EqualsHermiteFunctions) {
  const double dofs[12] = {0.1, 0.4, -2.0, 0.8, 0.1, 0.6, 0.9, 0.2, -1.5, 0.3, -0.9, 0.2};
  const double length = 1.3;
  const Curve curve = hermite_curve(dofs, dofs + 6, length);
  for (const double x : {-1.0, -0.6, 0.0, 0.3, 1.0}) {
    const std::array<double, 4> h = fem::hermite(x), g = fem::hermite_first(x);
    for (int i = 0; i < 3; ++i) {
      const double q[4] = {dofs[i], 0.5 * length * dofs[3 + i], dofs[6 + i], 0.5 * length * dofs[9 + i]};
      EXPECT_NEAR(curve.point(x)[i], h[0] * q[0] + h[1] * q[1] + h[2] * q[2] + h[3] * q[3], 1e-15);
      EXPECT_NEAR(curve.slope(x)[i], g[0] * q[0] + g[1] * q[1] + g[2] * q[2] + g[3] * q[3], 1e-15);
    }
  }
}

TEST(Curve, BoxHoldsABentCurveThatLeavesTheBoxOfItsNodes) {
  const double dofs[12] = {0, 0, 0, 0, 3, 0, 1, 0, 0, 0, -3, 0};
  const Curve curve = hermite_curve(dofs, dofs + 6, 1.0);
  const search::Aabb box = curve_box(curve);
  double highest = 0.0;
  for (int i = 0; i <= 100; ++i) {
    const Vec3 r = curve.point(-1.0 + 0.02 * i);
    highest = std::max(highest, r[1]);
    for (int d = 0; d < 3; ++d) {
      EXPECT_GE(r[d], box.low[d] - 1e-15);
      EXPECT_LE(r[d], box.high[d] + 1e-15);
    }
  }
  EXPECT_GT(highest, 0.7);
}

TEST(Crossings, OfCubicsWithKnownRoots) {
  // (x + 0.9)(x - 0.1)(x - 0.2) = x^3 + 0.6 x^2 - 0.25 x + 0.018
  const MonotonePieces pieces(Cubic{{0.018, -0.25, 0.6, 1.0}});
  double roots[3];
  ASSERT_EQ(pieces.crossings(0.0, roots), 3);
  EXPECT_NEAR(roots[0], -0.9, 1e-15);
  EXPECT_NEAR(roots[1], 0.1, 1e-14);
  EXPECT_NEAR(roots[2], 0.2, 1e-14);
  const MonotonePieces straight(Cubic{{0.25, 0.5, 1e-300, 0.0}});
  ASSERT_EQ(straight.crossings(0.0, roots), 1);
  EXPECT_NEAR(roots[0], -0.5, 1e-16);
  EXPECT_EQ(MonotonePieces(Cubic{{0.3, 0.0, 0.0, 0.0}}).crossings(0.3, roots), 0);  // in the plane: no cut
}

TEST(Crossings, RandomCubicsMissNoSignChange) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> c(-1, 1);
  for (int trial = 0; trial < 2000; ++trial) {
    const Cubic cubic{{0.3 * c(random), c(random), c(random), c(random)}};
    const MonotonePieces pieces(cubic);
    double roots[3];
    const int found = pieces.crossings(0.0, roots);
    for (int i = 0; i < found; ++i) EXPECT_NEAR(cubic.value(roots[i]), 0.0, 1e-15);
    int changes = 0;
    for (int i = 0; i < 1000; ++i)
      changes += (cubic.value(-1 + 0.002 * i) < 0) != (cubic.value(-1 + 0.002 * (i + 1)) < 0);
    EXPECT_GE(found, changes);
    EXPECT_EQ((found - changes) % 2, 0);
  }
}

TEST(Projection, InvertsTheTrilinearMap) {
  std::mt19937 random(6);
  std::uniform_real_distribution<double> inside(-1, 1);
  for (int trial = 0; trial < 1000; ++trial) {
    const Cell cell = make_cell(random_cell(random, trial % 2 ? 0.2 : 0.0));
    EXPECT_EQ(cell.aligned, trial % 2 == 0);
    const Vec3 expected(inside(random), inside(random), inside(random));
    const std::array<double, 8> n = fem::hex8_shape(expected);
    const Vec3 point = cell.corners * Eigen::Map<const Eigen::Matrix<double, 8, 1>>(n.data());
    Vec3 xi = Vec3::Zero();
    Mat3 inverse;
    ASSERT_TRUE(project(cell, point, xi, &inverse));
    EXPECT_LT((xi - expected).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_LT((inverse * cell.corners * fem::hex8_gradient(xi) - Mat3::Identity()).cwiseAbs().maxCoeff(), 1e-7);
    EXPECT_TRUE(is_inside(xi));
  }
  Vec3 xi = Vec3::Zero();
  EXPECT_FALSE(project(make_cell(random_cell(random, 0.2)), Vec3(50, -40, 30), xi));
}

TEST(FaceCrossings, TangentAndSecantOfAWarpedFace) {
  // Face zeta = 1 is z = 1 + 0.2 xi eta over the unit square.
  Eigen::Matrix<double, 3, 8> corners = unit_cell();
  for (int a = 4; a < 8; ++a) corners(2, a) += 0.2 * fem::hex8_corners[a][0] * fem::hex8_corners[a][1];
  const Cell cell = make_cell(corners);
  EXPECT_TRUE(face_planes(cell, 5).warped);
  EXPECT_FALSE(face_planes(cell, 4).warped);
  // Along the diagonal xi = eta = x: z of the face is 1 + 0.2 x^2; the line z = 1.05 crosses it at x = -+0.5.
  std::vector<double> roots;
  warped_face_crossings(line(Vec3(0, 0, 1.05), Vec3(1, 1, 1.05)), cell, 5, -1.0, 1.0, roots);
  ASSERT_EQ(roots.size(), 2u);
  EXPECT_NEAR(roots[0], -0.5, 1e-14);
  EXPECT_NEAR(roots[1], 0.5, 1e-14);
  // It is inside where the face is above it.
  std::vector<Claim> claims;
  claim_parts(line(Vec3(0, 0, 1.05), Vec3(1, 1, 1.05)), cell, 7, claims);
  ASSERT_EQ(claims.size(), 2u);
  EXPECT_NEAR(claims[0].end, -0.5, 1e-14);
  EXPECT_NEAR(claims[1].begin, 0.5, 1e-14);
  // A line that touches the face from inside is inside as a whole; straight lines of the face itself, too.
  claims.clear();
  claim_parts(line(Vec3(0, 0, 1.0), Vec3(1, 1, 1.0)), cell, 7, claims);
  ASSERT_EQ(claims.size(), 1u);
  EXPECT_EQ(claims[0].begin, -1.0);
  EXPECT_EQ(claims[0].end, 1.0);
  claims.clear();
  claim_parts(line(Vec3(0.75, 0, 0.9), Vec3(0.75, 1, 1.1)), cell, 7, claims);
  ASSERT_EQ(claims.size(), 1u);
  EXPECT_EQ(claims[0].begin, -1.0);
  EXPECT_EQ(claims[0].end, 1.0);
}

TEST(Claims, AgreeWithDenseSamplingInDistortedCells) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> place(-0.5, 1.5), turn(-3.0, 3.0);
  int claimed = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const Cell cell = make_cell(random_cell(random, 0.15));
    double dofs[12];
    for (int i = 0; i < 12; ++i) dofs[i] = i % 6 < 3 ? place(random) : turn(random);
    const Curve curve = hermite_curve(dofs, dofs + 6, 1.0);
    std::vector<Claim> claims;
    claim_parts(curve, cell, 1, claims);
    claimed += static_cast<int>(claims.size());
    for (int i = 0; i < 400; ++i) {
      const double x = -1.0 + (i + 0.5) / 200.0;
      Vec3 xi = Vec3::Zero();
      const bool inside = project(cell, curve.point(x), xi) && xi.cwiseAbs().maxCoeff() <= 1.0;
      const bool in_claim = std::any_of(claims.begin(), claims.end(),
                                        [x](const Claim& claim) { return claim.begin <= x && x <= claim.end; });
      EXPECT_EQ(inside, in_claim) << "trial " << trial << " x " << x;
    }
  }
  EXPECT_GT(claimed, 200);
}

TEST(Resolve, OverlapsGoToTheLowestCellAndGapsAreOutside) {
  std::vector<Segment> segments;
  resolve({{9, -1.0, 0.5, -1.0, 0.5}, {4, 0.0, 0.5, 0.0, 0.5}, {6, 0.75, 1.0, 0.75, 1.0}}, segments);
  ASSERT_EQ(segments.size(), 4u);
  EXPECT_EQ(segments[0].cell, 9);
  EXPECT_EQ(segments[1].cell, 4);
  EXPECT_EQ(segments[2].cell, -1);
  EXPECT_EQ(segments[3].cell, 6);
  EXPECT_EQ(segments[0].begin, -1.0);
  EXPECT_EQ(segments[1].begin, 0.0);
  EXPECT_EQ(segments[2].begin, 0.5);
  EXPECT_EQ(segments[3].end, 1.0);
}

TEST(Resolve, GapOfRoundOffIsClosedByReach) {
  std::vector<Segment> segments;
  resolve({{5, -1.0, 0.1, -1.0, 0.1 + 1e-7}, {3, 0.1 + 1e-8, 1.0, 0.1, 1.0}}, segments);
  ASSERT_EQ(segments.size(), 2u);
  EXPECT_EQ(segments[0].cell, 5);
  EXPECT_EQ(segments[1].cell, 3);
  EXPECT_EQ(segments[0].end, segments[1].begin);
}

TEST(Resolve, NothingClaimedIsOutside) {
  std::vector<Segment> segments;
  resolve({}, segments);
  ASSERT_EQ(segments.size(), 1u);
  EXPECT_EQ(segments[0].cell, -1);
}

TEST(CutInBox, LineInAFaceBelongsToTheLowerCellOnly) {
  mesh::Box box;
  for (auto& x : box.coordinates) x = {0.0, 0.5, 1.0};
  std::vector<Segment> segments;
  cut_in_box(line(Vec3(0.5, 0.1, 0.2), Vec3(0.5, 0.9, 0.2)), box, segments);
  ASSERT_EQ(segments.size(), 2u);
  EXPECT_EQ(segments[0].cell, 0);
  EXPECT_EQ(segments[1].cell, 2);
  EXPECT_NEAR(segments[0].end, 0.0, 1e-15);
}

// Even and strongly graded planes, two planes, points between, on and outside them.
TEST(CutInBox, PointsAreInTheLowestCellThatHoldsThem) {
  mesh::Box box;
  for (int i = 0; i <= 12; ++i) {
    box.coordinates[0].push_back(i / 12.0);
    box.coordinates[1].push_back(std::pow(i / 12.0, 4));
  }
  box.coordinates[2] = {0.0, 1.0};
  const auto along = [&](int d, double x) -> GlobalIndex {
    const std::vector<double>& planes = box.coordinates[d];
    for (std::size_t c = 0; c + 1 < planes.size(); ++c)
      if (x >= planes[c] && x <= planes[c + 1]) return static_cast<GlobalIndex>(c);
    return -1;
  };
  std::vector<double> places = {-3.0, -0.1, 0.0, 1.0, 1.1, 50.0};
  for (int i = 1; i < 100; ++i) places.push_back(i / 100.0 + 0.001);
  places.insert(places.end(), box.coordinates[0].begin(), box.coordinates[0].end());
  places.insert(places.end(), box.coordinates[1].begin(), box.coordinates[1].end());
  for (const double x : places)
    for (const double y : places)
      for (const double z : {-0.1, 0.0, 0.3, 1.0}) {
        const GlobalIndex at[3] = {along(0, x), along(1, y), along(2, z)};
        const bool inside = at[0] >= 0 && at[1] >= 0 && at[2] >= 0;
        ASSERT_EQ(cell_in_box(box, Vec3(x, y, z)), inside ? at[0] + 12 * at[1] : -1) << x << ' ' << y << ' ' << z;
      }
  std::vector<Segment> segments;
  cut_in_box(line(Vec3(0.5, -0.5, 0.5), Vec3(0.5, 1.5, 0.5)), box, segments);
  EXPECT_EQ(segments.size(), 14u);  // one in each cell, two outside
}

TEST(Cells, OfBoxesAreThoseOfTheirNodes) {
  const std::vector<double> even = {0.0, 0.1, 0.2, 0.3}, graded = {-1.0, 0.01, 0.5, 7.0, 7.1};
  const mesh::HexMesh mesh =
      mesh::distribute(Comm(MPI_COMM_SELF), mesh::chunk_of(Comm(MPI_COMM_SELF), mesh::make_box({even, graded, even})));
  ASSERT_TRUE(mesh.box);
  for (Index c = 0; c < mesh.local_cells(); ++c) {
    const Cell cell = make_cell(mesh, c);
    Eigen::Matrix<double, 3, 8> corners;
    for (int a = 0; a < 8; ++a)
      corners.col(a) = Eigen::Map<const Vec3>(mesh.node(mesh.cells[8 * static_cast<std::size_t>(c) + a]));
    const Cell expected = make_cell(corners);
    EXPECT_EQ(cell.corners, expected.corners);
    EXPECT_EQ(cell.aligned, expected.aligned);
    EXPECT_EQ(cell.size, expected.size);
  }
}

TEST(Measure, IsConstantOnStraightElementsOnly) {
  const Measure straight = make_measure(line(Vec3(0.1, 0.2, 0.3), Vec3(0.4, -0.2, 0.9)));
  for (const double x : {-1.0, 0.3, 1.0}) EXPECT_NEAR(straight(x), 0.5 * Vec3(0.3, -0.4, 0.6).norm(), 1e-15);
  const double dofs[12] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
  const Curve bent = hermite_curve(dofs, dofs + 6, 1.5);
  const Measure measure = make_measure(bent);
  EXPECT_LT(measure.constant, 0.0);
  for (const double x : {-1.0, 0.3, 1.0}) EXPECT_NEAR(measure(x), bent.slope(x).norm(), 1e-15);
}

}  // namespace
}  // namespace fbi::coupling
