/// Cameras, tubes and cut planes: where points come to lie in a picture, what hides what, and the colors of pixels.
#include "post/render.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "io/pending_file.hpp"
#include "io/result_file.hpp"
#include "post/canvas.hpp"
#include "post/scalars.hpp"
#include "unit/io/example_case.hpp"
#include "unit/io/scratch.hpp"
#include "unit/post/helpers.hpp"

namespace fbi::post {
namespace {

using test::error_of;
using test::expect_contains;
using test::Scratch;

std::vector<Vec3> corners(const Vec3& size) {
  std::vector<Vec3> points;
  for (int k = 0; k < 8; ++k) points.push_back(Vec3(k & 1, k >> 1 & 1, k >> 2 & 1).cwiseProduct(size));
  return points;
}

TEST(Camera, LooksStraightAtThePlane) {
  View view;
  view.azimuth = view.elevation = 0.0;
  for (int up = 0; up < 3; ++up) {
    view.up = up;
    const Camera camera(view, corners(Vec3(2, 2, 2)), 400, 400, {100, 100, 100, 100});
    const Vec3 right = Vec3::Unit(up == 0 ? 1 : 0), vertical = Vec3::Unit(up);
    const Pixel middle = camera.project(Vec3::Ones()), moved = camera.project(Vec3::Ones() + right),
                above = camera.project(Vec3::Ones() + vertical),
                nearer = camera.project(Vec3::Ones() + right.cross(vertical));
    EXPECT_NEAR(middle.x, 200.0, 1e-9);
    EXPECT_NEAR(middle.y, 200.0, 1e-9);
    EXPECT_NEAR(moved.x, 300.0, 1e-9);
    EXPECT_NEAR(above.y, 100.0, 1e-9);
    EXPECT_NEAR(nearer.depth, middle.depth - 1.0, 1e-9);
    EXPECT_NEAR(middle.scale, 100.0, 1e-9);
  }
}

TEST(Camera, RaysGoBackToThePoints) {
  for (const double opening : {0.0, 40.0, 90.0})
    for (int up = 0; up < 3; ++up) {
      const std::vector<Vec3> box = corners(Vec3(13, 1, 2));
      const Camera camera({33.0, 21.0, opening, up}, box, 900, 0, {50, 60, 70, 80});
      double left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
      for (const Vec3& x : box) {
        const Pixel p = camera.project(x);
        const Ray ray = camera.ray(p.x, p.y);
        EXPECT_LT((ray.origin + p.depth * ray.direction - x).norm(), 1e-11);
        left = std::min(left, p.x);
        right = std::max(right, p.x);
        top = std::min(top, p.y);
        bottom = std::max(bottom, p.y);
      }
      // All of it, and as large as the margins allow.
      EXPECT_GE(left, 50.0 - 1e-9);
      EXPECT_LE(right, 840.0 + 1e-9);
      EXPECT_GE(top, 70.0 - 1e-9);
      EXPECT_LE(bottom, camera.height() - 80.0 + 1e-9);
      EXPECT_TRUE(std::abs(right - left - 790.0) < 1e-9 || std::abs(bottom - top - (camera.height() - 150.0)) < 1e-9);
    }
}

TEST(Camera, PerspectiveMakesDistantThingsSmall) {
  const Camera camera({0.0, 0.0, 60.0, 1}, corners(Vec3(2, 2, 2)), 400, 400, {0, 0, 0, 0});
  EXPECT_GT(camera.project(Vec3(1, 1, 2)).scale, 1.5 * camera.project(Vec3(1, 1, 0)).scale);
}

// A picture of 2 x 2 at 100 pixels a length: tubes along x at z = 0 and along y at z = 1, nearer to the eye.
TEST(Canvas, TubesHideWhatIsBehind) {
  View view;
  view.azimuth = view.elevation = 0.0;
  const Camera camera(view, corners(Vec3(2, 2, 1)), 200, 200, {0, 0, 0, 0});
  Canvas canvas(200, 200, 2);
  const Color red(1, 0, 0), blue(0, 0, 1);
  canvas.tube(camera, Vec3(1, 0.2, 1), Vec3(1, 1.8, 1), 0.1, 0.5, blue, blue);
  canvas.tube(camera, Vec3(0.2, 1, 0), Vec3(1.8, 1, 0), 0.1, 0.5, red, red);
  const double front = camera.project(Vec3(1, 1, 1)).depth;
  int red_pixels = 0, blue_pixels = 0;
  canvas.for_each_pixel([&](double x, double y, float depth, Color& color) {
    if (color[0] > 0.2 && color[2] < 0.01) ++red_pixels;
    if (color[2] > 0.2 && color[0] < 0.01) {
      ++blue_pixels;
      EXPECT_LE(std::abs(x - 100), 10.01);
      // The surface of the tube: front - sqrt(r^2 - (x - 1)^2), away from its ends.
      if (y > 25 && y < 175) {
        EXPECT_NEAR(depth, front - std::sqrt(std::max(0.0, 0.01 - std::pow(0.01 * x - 1, 2))), 1e-5);
      }
    }
  });
  const double tube = 4 * (160 * 20 + M_PI * 100);  // fine pixels of a tube with round ends
  EXPECT_NEAR(blue_pixels, tube, 0.01 * tube);
  EXPECT_NEAR(red_pixels, tube - 4 * 20 * 20, 0.01 * tube);
}

// The depth of a line that goes away from the eye: that of the point in space which a pixel shows.
TEST(Canvas, LinesKnowTheirDepthInPerspective) {
  for (const double opening : {0.0, 100.0}) {
    const Camera camera({30.0, 20.0, opening, 1}, corners(Vec3(8, 1, 1)), 800, 0, {10, 10, 10, 10});
    Canvas canvas(camera.width(), camera.height(), 1);
    const Vec3 a(0, 0.5, 1), b(8, 0.5, 1);
    canvas.line(camera, a, b, 1.0, Color::Zero());
    int pixels = 0;
    canvas.for_each_pixel([&](double x, double y, float depth, Color& color) {
      if (color != Color::Zero()) return;
      ++pixels;
      const Ray ray = camera.ray(x, y);
      const Vec3 seen = ray.origin + depth * ray.direction;
      EXPECT_LT((seen - Vec3(seen[0], 0.5, 1)).norm(), 1.0 / camera.project(seen).scale) << x;
    });
    EXPECT_GT(pixels, 500);
  }
}

TEST(Canvas, ThinTubesStayVisible) {
  View view;
  view.azimuth = view.elevation = 0.0;
  const Camera camera(view, corners(Vec3(2, 2, 1)), 200, 200, {0, 0, 0, 0});
  Canvas canvas(200, 200, 2);
  canvas.tube(camera, Vec3(0, 1, 0), Vec3(2, 1, 0), 1e-6, 0.6, Color::Zero(), Color::Zero());
  const std::string bytes = canvas.rgb();
  ASSERT_EQ(bytes.size(), 3u * 200 * 200);
  for (int i = 2; i < 198; ++i)
    EXPECT_LT(
        static_cast<unsigned char>(bytes[3 * (100 * 200 + i)]) + static_cast<unsigned char>(bytes[3 * (99 * 200 + i)]),
        400)
        << i;
}

TEST(ColorScale, GoesThroughItsColors) {
  const ColorScale scale({"#000000", "#ff0000", "#ffffff"}, -2.0, 2.0);
  EXPECT_EQ(scale(-5.0), Color(0, 0, 0));
  EXPECT_EQ(scale(0.0), Color(1, 0, 0));
  EXPECT_LT((scale(1.0) - Color(1, 0.5f, 0.5f)).norm(), 1e-6f);
  EXPECT_EQ(scale(2.0), Color(1, 1, 1));
}

TEST(Scalar, RangesAreSymmetricOnlyWhenBothSignsMatter) {
  EXPECT_EQ((Scalar{"", {-1.0, 3.0}}.range()), (std::array<double, 2>{-3.0, 3.0}));
  EXPECT_EQ((Scalar{"", {-0.1, 3.0}}.range()), (std::array<double, 2>{-0.1, 3.0}));
  EXPECT_EQ((Scalar{"", {1.0, 3.0}}.range()), (std::array<double, 2>{1.0, 3.0}));
}

class RenderTest : public ::testing::Test {
 protected:
  RenderTest() : comm(MPI_COMM_SELF), scratch(comm), paths(io::run_paths(scratch / "flow.run.h5")) {}

  // A box 3 x 1 x 1 with velocity (x + z, -y, 0), and seven fibers whose tips move by (0.1, 0, 0); `warped`: inner
  // nodes are moved.
  void write(bool warped = false, bool with_fluid = true) {
    io::CaseFile content = test::example_case(warped);
    if (warped)
      for (std::size_t n = 0; n < content.mesh.nodes.size(); n += 3) {
        double* x = &content.mesh.nodes[n];
        x[0] += 0.05 * std::sin(M_PI / 3 * x[0]) * std::sin(M_PI * x[1]) * std::sin(M_PI * x[2]);
      }
    const mesh::HexMesh fluid = test::distribute_mesh(comm, content);
    const mesh::FiberMesh fibers = test::distribute_fibers(comm, content, &fluid);
    io::ResultWriter writer(comm, paths, with_fluid ? &fluid : nullptr, &fibers,
                            {content.json, content.json_name, "", "", 1}, 8);
    std::vector<double> state, dofs = fibers.reference_dofs();
    for (Index n = 0; n < fluid.owned_nodes; ++n) {
      const double* x = fluid.node(n);
      state.insert(state.end(), {x[0] + x[2], -x[1], 0.0, 1.0});
    }
    for (std::size_t k = 0; k < dofs.size(); k += 6) dofs[k] += 0.1 * dofs[k + 1] / 0.3;
    std::vector<io::NodeField> fields;
    if (with_fluid) fields = {{"velocity", 3, 4, 0, state.data()}};
    writer.write_step(2, 0.5, fields, {&dofs, nullptr, nullptr});
  }

  int fbi_post(const std::string& arguments) { return test::run_fbi_post(scratch, arguments, output); }

  Comm comm;
  Scratch scratch;
  io::RunPaths paths;
  std::string output;
};

// Seen from the front, pixel i of the slice z = 0.5 is at x = 3 (i + 1/2 - 60)/(width - 120): its color is that of
// x + 0.5.
TEST_F(RenderTest, PixelsOfASlice) {
  for (const bool warped : {false, true}) {
    write(warped);
    RenderOptions options;
    options.view.azimuth = options.view.elevation = 0.0;
    options.slices = {{2, 0.5}};
    options.quantity = "velocity_x";
    options.fibers = "none";
    options.range = {0.5, 3.5};
    options.width = 720;
    write_render(scratch / "slice", read_run(paths.index), options);
    const std::string bytes = io::read_text_file(scratch / "slice.rgb");
    const ColorScale scale({"#ffffff", "#b5d4e9", "#60a6d1", "#2070b4", "#08306b"}, 0.5, 3.5);
    ASSERT_EQ(bytes.size(), 3u * 720 * 390);  // 200 pixels for the height of 1, margins 70 and 120
    for (int i = 63; i < 657; i += 11) {
      const Color expected = scale(3.0 * (i + 0.5 - 60) / 600 + 0.5);
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(static_cast<unsigned char>(bytes[3 * (720 * (70 + 100) + i) + c]), 255 * expected[c], 1.1)
            << i << " " << c;
    }
    EXPECT_EQ(static_cast<unsigned char>(bytes[3 * (720 * 170 + 30)]), 255);  // paper
  }
}

TEST_F(RenderTest, FromOutside) {
  write();
  ASSERT_EQ(fbi_post("render flow.run.h5 --slice z=0 --slice x=2.9 --fibers displacement_x --perspective 30"), 0)
      << output;
  EXPECT_EQ(io::read_text_file(scratch / "flow.render.png").substr(1, 3), "PNG");
  expect_contains(io::read_text_file(scratch / "flow.render.gp"), "slice z = 0, x = 2.9");
  expect_contains(io::read_text_file(scratch / "flow.render.gp"), "'0.1'");  // of the fibers' colors
  ASSERT_EQ(fbi_post("render flow.run.h5 --slice none --fibers plain --up z --size 400 300 --quiet -o p"), 0) << output;
  EXPECT_EQ(output, "");
  EXPECT_EQ(std::filesystem::file_size(scratch / "p/flow.render.rgb"), 3u * 400 * 300);
  EXPECT_EQ(fbi_post("render flow.run.h5 --slice z=5"), 1);
  expect_contains(output, "z goes from 0 to 1");
  EXPECT_EQ(fbi_post("render flow.run.h5 --slice q=1"), 1);
  expect_contains(output, "is no slice");
  EXPECT_EQ(fbi_post("render flow.run.h5 --quantity vorticity"), 1);
  expect_contains(output, "velocity_x, velocity_y, velocity_z, velocity_magnitude");
  EXPECT_EQ(fbi_post("render flow.run.h5 --fibers temperature"), 1);
  expect_contains(output, "displacement_z");
  EXPECT_EQ(fbi_post("render flow.run.h5 --fibers none --slice none"), 1);
  EXPECT_EQ(fbi_post("render flow.run.h5 --step 7"), 1);
  EXPECT_EQ(fbi_post("render flow.run.h5 --range 2 1"), 1);
  expect_contains(output, "LOW HIGH");
  EXPECT_EQ(fbi_post("render flow.run.h5 --from 5 0 0"), 1);
  EXPECT_EQ(fbi_post("render missing.run.h5"), 6);
  write(false, false);  // fibers alone
  EXPECT_EQ(fbi_post("render flow.run.h5"), 0) << output;
}

}  // namespace
}  // namespace fbi::post
