// Fully developed flow in a square duct of unit side, driven by a pressure drop between two traction ends (two cells
// along the axis): exact series. Steady: center velocity and flow rate.
#include <gtest/gtest.h>

#include "base/log.hpp"
#include "convergence/fluid_solver.hpp"
#include "record.hpp"

namespace fbi::fluid::test {
namespace {

// w(x, y) for -dp/dz = mu: sum over odd k of sines in x, cosh in y.
double series(double x, double y) {
  double sum = 0;
  for (int k = 1; k < 200; k += 2) {
    const double n = k * M_PI;
    // cosh(n (y - 1/2)) / cosh(n/2) without overflow
    const double ratio = (std::exp(n * (y - 1)) + std::exp(-n * y)) / (1 + std::exp(-n));
    sum += 4 / (n * n * n) * std::sin(n * x) * (1 - ratio);
  }
  return sum;
}

struct Duct {
  mesh::HexMesh mesh;
  FluidField field;
  Duct(const std::vector<double>& side, double warp, ConvectiveForm form, bool general = false)
      : mesh(box_mesh(Comm(MPI_COMM_SELF), {side, side, uniform(0, length(side), 2)}, general, warp)),
        field(mesh, fluid(form), boundaries(length(side)), {TimeScheme::steady, 1.0}) {
    field.initialize();
    StepSolver solver(field);
    // tau follows the velocity by repeated solves of the steady equations
    for (int n = 0; n < (form == ConvectiveForm::none ? 1 : 6); ++n) {
      field.begin_step(0, 0);
      solver.solve();
      field.accept_step();
    }
  }
  static FluidParameters fluid(ConvectiveForm form) {
    FluidParameters p;
    p.density = 1;
    p.viscosity = 0.05;
    p.convective_form = form;
    return p;
  }
  // The cells keep their aspect ratio under refinement, because V^(1/3) in tau does not see which side of a cell is
  // long.
  static double length(const std::vector<double>& side) { return 2.0 / static_cast<double>(side.size() - 1); }
  // G = mu: the traction at the inlet is mu times the length
  static BoundaryConditions boundaries(double length) {
    BoundaryConditions all;
    for (const char* face : {"xmin", "xmax", "ymin", "ymax"}) all[face] = of_type(BoundaryType::no_slip);
    for (const char* face : {"zmin", "zmax"}) {
      all[face] = of_type(BoundaryType::mixed);
      all[face].velocity[0] = input::Expression(0.0);
      all[face].velocity[1] = input::Expression(0.0);
    }
    all["zmin"].traction = {input::Expression(0.0), input::Expression(0.0), input::Expression(0.05 * length)};
    return all;
  }
  double center() {
    LocalArray u(field.iterate());
    for (Index n = 0; n < mesh.local_nodes(); ++n)
      if ((Eigen::Map<const Vec3>(mesh.node(n)) - Vec3(0.5, 0.5, 0)).norm() < 1e-12) return u[4 * n + 2];
    return NAN;
  }
  Errors error() {
    return errors(field, [](const Vec3& x, double* value) {
      value[0] = value[1] = 0;
      value[2] = series(x[0], x[1]);
      value[3] = -0.05 * x[2];
    });
  }
};

constexpr double exact_center = 0.0736713532815;

TEST(Duct, SeriesMatchesPublishedValues) {
  EXPECT_NEAR(series(0.5, 0.5), exact_center, 1e-7);  // 100 terms
  EXPECT_NEAR(series(0.25, 0.5), 0.0573349064746, 1e-7);
  EXPECT_NEAR(series(0.25, 0.25), 0.0452861581095, 1e-7);
}

void check(const char* name, const std::vector<double>& coarse, const std::vector<double>& fine, double warp,
           ConvectiveForm form) {
  Duct one(coarse, warp, form), two(fine, warp, form);
  const double e1 = one.error().velocity, e2 = two.error().velocity, order = std::log2(e1 / e2);
  const double center = two.center() / exact_center - 1;
  std::printf("%s, %zu cells: velocity error %.3e, order %.3f, center velocity %+.3e relative\n", name, fine.size() - 1,
              e2, order, center);
  fbi::test::record({.section = "Fluid",
                     .id = "S-F3",
                     .check = log::format("square duct, %s, %zu cells a side: L2 error of the velocity", name,
                                          fine.size() - 1),
                     .source = "series solution",
                     .reference = 0.0,
                     .ours = e2,
                     .order = order,
                     .bar = "order 1.9"});
  fbi::test::record({.section = "Fluid",
                     .id = "S-F3",
                     .check = log::format("square duct, %s, %zu cells a side: velocity at the center", name,
                                          fine.size() - 1),
                     .source = "series solution",
                     .reference = exact_center,
                     .ours = exact_center * (1 + center),
                     .bar = "0.5 %"});
  EXPECT_GE(order,
            1.9);  // above 2: the part of the ends (pressure layers of PSPG) falls faster
  EXPECT_LT(std::abs(center), 0.005);
}

TEST(Duct, OrderTwoAndCenterVelocity) {
  linalg::initialize_petsc();
  check("Navier-Stokes", uniform(0, 1, 16), uniform(0, 1, 32), 0, ConvectiveForm::advective);
  check("Stokes", uniform(0, 1, 16), uniform(0, 1, 32), 0, ConvectiveForm::none);
}

std::vector<double> halved(const std::vector<double>& x) {
  std::vector<double> fine;
  for (std::size_t i = 0; i + 1 < x.size(); ++i) {
    fine.push_back(x[i]);
    fine.push_back(0.5 * (x[i] + x[i + 1]));
  }
  fine.push_back(x.back());
  return fine;
}

// Cells grow away from both walls, so that the center stays a node.
TEST(Duct, OrderTwoOnAGradedBox) {
  linalg::initialize_petsc();
  std::vector<double> coarse = graded(0, 0.5, 8, 1.15);
  for (int i = 7; i >= 0; --i) coarse.push_back(1 - coarse[i]);
  check("graded", coarse, halved(coarse), 0, ConvectiveForm::advective);
}

// The same equations by the kernels of general cells: `mixed` ends, traction at one of them.
TEST(Duct, GeneralMeshFlowsLikeTheBox) {
  linalg::initialize_petsc();
  const std::vector<double> side = graded(0, 1, 12, 1.1);
  Duct box(side, 0, ConvectiveForm::advective), general(side, 0, ConvectiveForm::advective, true);
  ASSERT_FALSE(general.mesh.box.has_value());
  LocalArray a(box.field.iterate()), b(general.field.iterate());
  double difference = 0, size = 0;
  ASSERT_EQ(box.mesh.local_nodes(), general.mesh.local_nodes());
  std::vector<double> by_number(4 * static_cast<std::size_t>(box.mesh.local_nodes()));
  for (std::size_t n = 0; n < by_number.size() / 4; ++n)
    for (int c = 0; c < 4; ++c) by_number[4 * static_cast<std::size_t>(box.mesh.node_id[n]) + c] = a[4 * n + c];
  for (std::size_t n = 0; n < by_number.size() / 4; ++n)
    for (int c = 0; c < 4; ++c) {
      const double value = by_number[4 * static_cast<std::size_t>(general.mesh.node_id[n]) + c];
      difference = std::max(difference, std::abs(value - b[4 * n + c]));
      size = std::max(size, std::abs(value));
    }
  std::printf("duct with mixed ends, general mesh against box: %.1e\n", difference / size);
  EXPECT_LT(difference, 1e-8 * size);  // both are solved to a residual of 1e-10
  ::fbi::test::record({.section = "General meshes",
                       .id = "",
                       .check = "duct between mixed ends, general cells against the box: velocity, pressure",
                       .source = "identity",
                       .error = difference / size,
                       .bar = "1e-8"});
}

}  // namespace
}  // namespace fbi::fluid::test
