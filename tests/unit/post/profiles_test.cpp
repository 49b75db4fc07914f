/// Profiles over a height against means that are known exactly: fields that trilinear cells hold without error.
#include "post/profiles.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "input/expression.hpp"
#include "io/pending_file.hpp"
#include "io/result_file.hpp"
#include "unit/io/example_case.hpp"
#include "unit/io/scratch.hpp"
#include "unit/post/helpers.hpp"

namespace fbi::post {
namespace {

using input::Expression;
using test::error_of;
using test::expect_contains;
using test::Scratch;

class ProfilesTest : public ::testing::Test {
 protected:
  ProfilesTest() : comm(MPI_COMM_SELF), scratch(comm) {}

  // A box 2 x 1 x 1 of 6 x 4 x 3 cells, graded in y, with seven fibers bent to 0.28 of their 0.3; with `warped` inner
  // nodes that are moved. With `stress` (its xx and xy) the flow is a running mean over 0.5.
  post::Run write(const std::string& name, const std::array<std::string, 3>& velocity, bool warped = false,
                  const std::vector<std::string>& stress = {}) {
    io::CaseFile content = test::example_case();
    content.mesh = mesh::make_box({test::spread(6, 2.0), {0.0, 0.1, 0.3, 0.6, 1.0}, test::spread(3, 1.0)}, warped);
    if (warped)
      for (std::size_t n = 0; n < content.mesh.nodes.size(); n += 3) {
        double* x = &content.mesh.nodes[n];
        const double bump = std::sin(0.5 * M_PI * x[0]) * std::sin(M_PI * x[1]) * std::sin(M_PI * x[2]);
        x[0] += 0.06 * bump;
        x[1] -= 0.05 * bump;
        x[2] += 0.04 * bump;
      }
    for (std::size_t k = 0; k < content.fibers.position.size(); k += 3) content.fibers.position[k] *= 0.6;
    const io::RunPaths paths = io::run_paths(scratch / (name + ".run.h5"));
    const mesh::HexMesh fluid = test::distribute_mesh(comm, content);
    const mesh::FiberMesh fibers = test::distribute_fibers(comm, content, &fluid);
    io::ResultWriter writer(comm, paths, &fluid, &fibers, {content.json, content.json_name, "", "", 1}, 8);
    const Expression v[3] = {Expression(velocity[0]), Expression(velocity[1]), Expression(velocity[2])};
    std::vector<double> state, r;
    for (Index n = 0; n < fluid.owned_nodes; ++n) {
      const Eigen::Map<const Vec3> x(fluid.node(n));
      for (const Expression& e : v) state.push_back(e(x, 0.0));
      state.push_back(7.0 - x[1]);
      for (std::size_t c = 0; c < 6; ++c) r.push_back(c < stress.size() ? Expression(stress[c])(x, 0.0) : 0.0);
    }
    std::vector<io::NodeField> fields = {{"velocity", 3, 4, 0, state.data()}, {"pressure", 1, 4, 3, state.data()}};
    const std::vector<double> still(state.size(), 0.0);
    if (!stress.empty())
      fields = {{"velocity", 3, 4, 0, still.data()},
                {"mean_velocity", 3, 4, 0, state.data(), 0.5},
                {"mean_pressure", 1, 4, 3, state.data(), 0.5},
                {"reynolds_stress", 6, 6, 0, r.data(), 0.5}};
    std::vector<double> dofs = fibers.reference_dofs();
    for (std::size_t k = 0; k < dofs.size(); k += 6) {
      dofs[k + 1] *= 0.28 / 0.3;
      dofs[k + 4] *= 0.28 / 0.3;
    }
    writer.write_step(3, 1.0, fields, {&dofs, nullptr, nullptr});
    return read_run(paths.index);
  }

  int fbi_post(const std::string& arguments) { return test::run_fbi_post(scratch, arguments, output); }

  Comm comm;
  Scratch scratch;
  std::string output;
};

// v = (xy, z, x) over [a,b] x [c,d], which cuts cells: <xy> = y (a+b)/2, and of a variable that is spread evenly over
// a length L the variance is L^2/12.
TEST_F(ProfilesTest, LayersOfABoxAreExact) {
  const post::Run run = write("box", {"x*y", "z", "x"});
  ProfileOptions options;
  const double a = 0.4, b = 1.7, c = 0.2, d = 0.9, xx = (b - a) * (b - a) / 12, zz = (d - c) * (d - c) / 12;
  options.from = Vec3(a, 0.05, c);
  options.to = Vec3(b, 2.0, d);
  const Profiles profiles = mean_profiles(run, options);
  EXPECT_TRUE(profiles.layers);
  EXPECT_EQ(profiles.averaged_over, 0.0);
  ASSERT_EQ(profiles.rows.size(), 4u);  // 0.1, 0.3, 0.6, 1
  const double layers[] = {0.1, 0.3, 0.6, 1.0};
  for (std::size_t k = 0; k < 4; ++k) {
    const ProfileRow& row = profiles.rows[k];
    const double y = layers[k];
    EXPECT_EQ(row.height, y);
    EXPECT_NEAR(row.measure, (b - a) * (d - c), 1e-14);
    EXPECT_NEAR(row.velocity[0], y * (a + b) / 2, 1e-14);
    EXPECT_NEAR(row.velocity[1], (c + d) / 2, 1e-14);
    EXPECT_NEAR(row.velocity[2], (a + b) / 2, 1e-14);
    EXPECT_NEAR(row.pressure, 7.0 - y, 1e-14);
    const double expected[6] = {y * y * xx, 0.0, y * xx, zz, 0.0, xx};
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(row.reynolds[i], expected[i], 1e-14) << i;
  }
  ASSERT_TRUE(profiles.canopy);
  EXPECT_NEAR(profiles.canopy->rest, 0.3, 1e-14);
  EXPECT_NEAR(profiles.canopy->current, 0.28, 1e-14);
  options.from = Vec3(1.85, 0.0, 0.0);  // behind the last fiber
  options.to = Vec3(2.0, 1.0, 1.0);
  EXPECT_FALSE(mean_profiles(run, options).canopy);
}

TEST_F(ProfilesTest, OtherAxes) {
  const post::Run run = write("axes", {"x*y", "z", "x"});
  ProfileOptions options;
  options.axis = 0;
  const std::vector<ProfileRow> along_x = mean_profiles(run, options).rows;
  ASSERT_EQ(along_x.size(), 7u);
  EXPECT_NEAR(along_x[3].velocity[0], 1.0 * 0.5, 1e-14);
  EXPECT_NEAR(along_x[3].reynolds[0], 1.0 / 12, 1e-14);
  options.axis = 2;
  const std::vector<ProfileRow> along_z = mean_profiles(run, options).rows;
  ASSERT_EQ(along_z.size(), 4u);
  EXPECT_NEAR(along_z[1].velocity[1], 1.0 / 3, 1e-14);
  EXPECT_NEAR(along_z[1].reynolds[0], 4.0 / 9 - 1.0 / 4, 1e-14);  // <x^2><y^2> - <x>^2<y>^2
}

// Reynolds stress in time and the dispersive stress of the means are kept apart.
TEST_F(ProfilesTest, RunningMeans) {
  const post::Run run = write("means", {"x*y", "z", "x"}, false, {"1+x*z", "0-y"});
  ProfileOptions options;
  const Profiles profiles = mean_profiles(run, options);
  EXPECT_EQ(profiles.averaged_over, 0.5);
  ASSERT_EQ(profiles.rows.size(), 5u);
  for (const ProfileRow& row : profiles.rows) {
    EXPECT_NEAR(row.velocity[0], row.height, 1e-14);
    EXPECT_NEAR(row.reynolds[0], 1.5, 1e-14);
    EXPECT_NEAR(row.reynolds[1], -row.height, 1e-14);
    EXPECT_NEAR(row.dispersive[0], row.height * row.height / 3, 1e-14);
  }
  options.instantaneous = true;
  for (const ProfileRow& row : mean_profiles(run, options).rows) EXPECT_EQ(row.velocity.norm(), 0.0);
}

// Poiseuille's parabola at the nodes: the mean of its interpolation over one layer of cells is that of two nodes.
TEST_F(ProfilesTest, BinsOfABox) {
  const post::Run run = write("bins", {"4*y*(1-y)", "0", "0"});
  ProfileOptions options;
  options.bins = 10;
  const Profiles profiles = mean_profiles(run, options);
  EXPECT_FALSE(profiles.layers);
  const auto u = [](double y) { return 4 * y * (1 - y); };
  EXPECT_NEAR(profiles.rows[0].height, 0.05, 1e-14);
  EXPECT_NEAR(profiles.rows[0].velocity[0], 0.5 * (u(0.0) + u(0.1)), 1e-14);
  double volume = 0.0, flow = 0.0;
  for (const ProfileRow& row : profiles.rows) {
    volume += row.measure;
    flow += row.measure * row.velocity[0];
    EXPECT_NEAR(row.reynolds[0], 0.0, 1e-14);
  }
  EXPECT_NEAR(volume, 2.0, 1e-13);
  double exact = 0.0;  // trapezoidal rule: the field is linear between the layers
  const double layers[] = {0.0, 0.1, 0.3, 0.6, 1.0};
  for (int k = 0; k < 4; ++k) exact += (layers[k + 1] - layers[k]) * (u(layers[k]) + u(layers[k + 1]));
  EXPECT_NEAR(flow, exact, 1e-13);
}

// Any mesh: what is linear in the height is exact at the mean height of a bin, sums over bins are integrals.
TEST_F(ProfilesTest, BinsOfWarpedCells) {
  const post::Run run = write("warped", {"3*y+1", "x", "2*z-x"}, true);
  const Profiles usual = mean_profiles(run, {});
  EXPECT_FALSE(usual.layers);
  EXPECT_EQ(usual.rows.size(), 4u);
  for (const Index bins : {1, 5, 13}) {
    ProfileOptions options;
    options.bins = bins;
    double volume = 0.0;
    Vec3 integral = Vec3::Zero();
    for (const ProfileRow& row : mean_profiles(run, options).rows) {
      EXPECT_NEAR(row.velocity[0], 3 * row.height + 1, 1e-13);
      EXPECT_NEAR(row.reynolds[0], 0.0, 1e-13);
      EXPECT_NEAR(row.reynolds[3], 1.0 / 3,
                  bins == 1 ? 1e-9 : 0.02);  // 2^2/12; points, not exact parts of cells, go to bins
      volume += row.measure;
      integral += row.measure * row.velocity;
    }
    EXPECT_NEAR(volume, 2.0, 1e-12);
    EXPECT_NEAR(integral[0], 5.0, 1e-12);
    EXPECT_NEAR(integral[1], 2.0, 1e-12);
    EXPECT_NEAR(integral[2], 0.0, 1e-12);
  }
}

TEST_F(ProfilesTest, FromOutside) {
  write("flow", {"x*y", "z", "x"}, false, {"1"});
  ASSERT_EQ(fbi_post("profiles flow.run.h5 --from 0.5 0 0 --to 1.5 1 1"), 0) << output;
  expect_contains(output, "dispersive_xx");
  expect_contains(output, "canopy height 0.28, at rest 0.3");
  for (const char* ending : {"txt", "csv", "dat", "gp", "svg", "png", "pdf"})
    EXPECT_TRUE(std::filesystem::exists(scratch / ("flow.profiles." + std::string(ending)))) << ending;
  ASSERT_EQ(fbi_post("profiles flow.run.h5 --axis z --format markdown --no-plot --quiet -o tables"), 0) << output;
  EXPECT_EQ(output.substr(0, 2), "| ");
  EXPECT_EQ(output, io::read_text_file(scratch / "tables/flow.profiles.md"));
  EXPECT_EQ(fbi_post("profiles flow.run.h5 --from 3 0 0"), 1);
  expect_contains(output, "holds no fluid of run \"flow\"");
  EXPECT_EQ(fbi_post("profiles flow.run.h5 --from 0 0.31 0 --to 2 0.35 1"), 1);
  expect_contains(output, "--bins N");
  EXPECT_EQ(fbi_post("profiles flow.run.h5 --time 3"), 1);
  EXPECT_EQ(fbi_post("profiles flow.run.h5 --axis w"), 1);
  EXPECT_EQ(fbi_post("profiles flow.run.h5 --from 0 1"), 1);
  EXPECT_EQ(fbi_post("profiles missing.run.h5"), 6);
}

}  // namespace
}  // namespace fbi::post
