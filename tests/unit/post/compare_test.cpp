/// Differences of runs on meshes that do not match, observed orders, statistics of histories, tables of a page; and
/// fbi-post from outside.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "io/history.hpp"
#include "io/pending_file.hpp"
#include "io/result_file.hpp"
#include "post/convergence.hpp"
#include "post/difference.hpp"
#include "post/history_series.hpp"
#include "post/quantities.hpp"
#include "post/verification.hpp"
#include "unit/io/example_case.hpp"
#include "unit/io/scratch.hpp"
#include "unit/post/helpers.hpp"

namespace fbi::post {
namespace {

using input::Expression;
using test::error_of;
using test::expect_contains;
using test::Scratch;

using Field = std::array<std::string, 4>;  // velocity and pressure
const Field linear = {"1+x-2*y+3*z", "t*(x+y)", "-z", "4+x+y"};
const Field smooth = {"sin(2*x)*y", "cos(x+y)+z*z", "x*y*z+t", "1000+sin(x+2*y+z)"};

class CompareTest : public ::testing::Test {
 protected:
  CompareTest() : comm(MPI_COMM_SELF), scratch(comm) {}

  // A box (2 x 1 x 1), or with `general` cells of moved inner nodes; outputs at t = 0 and t = 1 (step = `steps`).
  post::Run write(const std::string& name, std::array<Index, 3> cells, const Field& field, bool general = false,
                  double width = 2.0, int steps = 10, bool history = true) {
    io::CaseFile content = test::example_case();
    content.mesh = mesh::make_box(
        {test::spread(cells[0], width), test::spread(cells[1], 1.0), test::spread(cells[2], 1.0)}, general);
    if (general)
      for (std::size_t n = 0; n < content.mesh.nodes.size(); n += 3) {
        double* x = &content.mesh.nodes[n];
        const double bump = std::sin(M_PI * x[0] / width) * std::sin(M_PI * x[1]) * std::sin(M_PI * x[2]);
        x[0] += 0.06 * bump;
        x[1] -= 0.05 * bump;
        x[2] += 0.04 * bump;
      }
    const io::RunPaths paths = io::run_paths(scratch / (name + ".run.h5"));
    const mesh::HexMesh fluid = test::distribute_mesh(comm, content);
    const Expression f[4] = {Expression(field[0]), Expression(field[1]), Expression(field[2]), Expression(field[3])};
    io::ResultWriter writer(comm, paths, &fluid, nullptr, {content.json, content.json_name, "", "", 1}, 8);
    for (int k = 0; k < 2; ++k) {
      std::vector<double> state;
      for (Index n = 0; n < fluid.owned_nodes; ++n)
        for (const Expression& e : f) state.push_back(e(Eigen::Map<const Vec3>(fluid.node(n)), k));
      writer.write_step(k * steps, k, {{"velocity", 3, 4, 0, state.data()}, {"pressure", 1, 4, 3, state.data()}}, {});
    }
    if (history) {
      io::History rows(comm, paths.csv, name, io::standard_history_columns());
      for (int step = 1; step <= steps; ++step)
        rows.write({1.0 * step, 1.0 * step / steps, 1.0 / steps, 1, 1, 1, 1, 0, 0, 0, 0.25});
    }
    return read_run(paths.index);
  }

  // One fiber from (0,0,0) to (1,0,0), deflected by a cubic of s at t = 1: every Hermite mesh holds it exactly; with
  // `quintic` by s^5.
  post::Run write_fiber(const std::string& name, Index elements, bool quintic = false) {
    mesh::FiberMeshData data;
    data.name = {"fiber"};
    data.group = {0};
    data.first_node = {0, elements + 1};
    for (Index n = 0; n <= elements; ++n) {
      data.position.insert(data.position.end(), {1.0 * n / elements, 0.0, 0.0});
      data.tangent.insert(data.tangent.end(), {1.0, 0.0, 0.0});
    }
    data.element_length.assign(static_cast<std::size_t>(elements), 1.0 / elements);
    GlobalIndex first = 0, node = 0;
    const mesh::FiberMesh fibers = distribute(comm, chunk_of(comm, data, first, node), first, node, nullptr);
    const io::RunPaths paths = io::run_paths(scratch / (name + ".run.h5"));
    io::ResultWriter writer(comm, paths, nullptr, &fibers, {"{}", "f.json", "", "", 1}, 2);
    std::vector<double> dofs = fibers.reference_dofs();
    for (std::size_t n = 0; n < dofs.size() / 6; ++n) {
      const double s = dofs[6 * n];
      dofs[6 * n + 1] = quintic ? std::pow(s, 5) : s * s * s;
      dofs[6 * n + 4] = quintic ? 5 * std::pow(s, 4) : 3 * s * s;
    }
    writer.write_step(4, 1.0, {}, {&dofs, nullptr, nullptr});
    return read_run(paths.index);
  }

  int fbi_post(const std::string& arguments) { return test::run_fbi_post(scratch, arguments, output); }

  Comm comm;
  Scratch scratch;
  std::string output;
};

DifferenceOptions with_gradient(const std::string& field = "velocity") {
  DifferenceOptions options;
  options.field = field;
  options.with_gradient = true;
  return options;
}

TEST_F(CompareTest, EqualRunsDifferByExactlyZero) {
  for (const bool general : {false, true}) {
    const post::Run a = write("a", {5, 4, 3}, smooth, general), b = write("b", {5, 4, 3}, smooth, general);
    const Difference d = field_difference(a, b, with_gradient());
    EXPECT_EQ(d.l2, 0.0);
    EXPECT_EQ(d.largest, 0.0);
    EXPECT_EQ(d.h1, 0.0);
    EXPECT_GT(d.l2_reference, 0.1);
    EXPECT_EQ(d.uncovered, 0.0);
  }
}

// Trilinear cells hold a linear field on any mesh: what is left is round-off of the search and of the sums.
TEST_F(CompareTest, LinearFieldsAgreeOnAnyMeshes) {
  const post::Run box = write("box", {5, 4, 3}, linear), fine = write("fine", {7, 9, 4}, linear),
                  warped = write("warped", {6, 5, 5}, linear, true);
  for (const auto& [one, other] : {std::pair{&box, &fine}, {&fine, &box}, {&warped, &fine}, {&box, &warped}})
    for (const bool coarse : {false, true})
      for (const char* field : {"velocity", "pressure"}) {
        DifferenceOptions options = with_gradient(field);
        options.on_coarse = coarse;
        const Difference d = field_difference(*one, *other, options);
        EXPECT_LE(d.l2, 1e-12 * d.l2_reference);
        EXPECT_LE(d.h1, 1e-11 * d.h1_reference);
        EXPECT_NEAR(d.measure, 2.0, 1e-12);
      }
  // The norm itself: int (4+x+y)^2 over 2 x 1 x 1.
  const Difference p = field_difference(box, fine, with_gradient("pressure"));
  EXPECT_NEAR(p.l2_reference * p.l2_reference, 2 * (5.5 * 5.5 + 1.0 / 3 + 1.0 / 12), 1e-10);
  EXPECT_NEAR(p.h1_reference * p.h1_reference, 2 * 2.0, 1e-10);
}

TEST_F(CompareTest, OrdersOfTheInterpolation) {
  for (const bool general : {false, true}) {
    const post::Run a = write("a", {8, 4, 4}, smooth, general), b = write("b", {16, 8, 8}, smooth, general);
    std::vector<Expression> exact = parse_formulas("sin(2*x)*y, cos(x+y)+z*z, x*y*z+t", 3, "--exact");
    const Difference one = field_difference(a, exact, with_gradient()),
                     two = field_difference(b, exact, with_gradient());
    EXPECT_EQ(one.time, 1.0);
    EXPECT_NEAR(std::log2(one.l2 / two.l2), 2.0, 0.05);
    EXPECT_NEAR(std::log2(one.h1 / two.h1), 1.0, 0.05);
    // int |grad v|^2 over the box: (4 cos(2x)^2 y^2 + sin(2x)^2) + (2 sin(x+y)^2 + 4 z^2) + (yz)^2 + (xz)^2 + (xy)^2
    EXPECT_NEAR(two.h1_reference, one.h1_reference, 0.01 * one.h1_reference);
  }
}

TEST_F(CompareTest, MeansAreRemovedAndCostNoDigits) {
  Field shifted = smooth;
  shifted[3] = "1e9+sin(x+2*y+z)";
  const post::Run a = write("a", {4, 4, 4}, shifted), b = write("b", {4, 4, 4}, smooth),
                  c = write("c", {8, 4, 5}, smooth);
  DifferenceOptions options;
  options.field = "pressure";
  EXPECT_NEAR(field_difference(a, b, options).l2, (1e9 - 1000) * std::sqrt(2.0), 1.0);
  options.remove_mean = true;
  EXPECT_LE(field_difference(a, b, options).l2, 1e-6);  // round-off of 1e9
  const double plain = field_difference(b, c, options).l2, moved = field_difference(a, c, options).l2;
  EXPECT_NEAR(moved, plain, 1e-6);
  EXPECT_GT(plain, 1e-3);
}

TEST_F(CompareTest, UncoveredVolumeIsReportedAndLimited) {
  const post::Run whole = write("whole", {8, 4, 4}, linear), part = write("part", {4, 4, 4}, linear, false, 1.0);
  for (const auto& [one, other] : {std::pair{&whole, &part}, {&part, &whole}}) {
    DifferenceOptions options;
    expect_contains(error_of([&] { field_difference(*one, *other, options); }, ExitCode::geometry), "--uncovered 0.55");
    options.allowed_uncovered = 0.5001;
    const Difference d = field_difference(*one, *other, options);
    EXPECT_NEAR(d.uncovered, 0.5, 1e-12);
    EXPECT_LE(d.l2, 1e-13 * d.l2_reference);
  }
}

TEST_F(CompareTest, CenterLines) {
  const post::Run a = write_fiber("a", 4), b = write_fiber("b", 7);
  DifferenceOptions options;
  options.field = "centerline";
  EXPECT_EQ(field_difference(a, a, options).l2, 0.0);
  const Difference d = field_difference(a, b, options);
  EXPECT_LE(d.l2, 1e-15);  // both hold the cubic
  EXPECT_NEAR(d.l2_reference, std::sqrt(1.0 / 7), 1e-14);
  EXPECT_NEAR(d.measure, 1.0, 1e-14);
  const std::vector<Expression> exact = parse_formulas("x, x^5, 0", 3, "--exact");
  const double one = field_difference(write_fiber("c", 4, true), exact, options).l2,
               two = field_difference(write_fiber("d", 8, true), exact, options).l2;
  EXPECT_NEAR(std::log2(one / two), 4.0, 0.05);
  // A difference known by hand: x^3 against x^3 + 1/2.
  EXPECT_NEAR(field_difference(a, parse_formulas("x, x^3+0.5, 0", 3, "--exact"), options).l2, 0.5, 1e-14);
}

TEST_F(CompareTest, TimesAndStepsThatAreNotThere) {
  const post::Run a = write("a", {2, 2, 2}, linear), b = write("b", {3, 2, 2}, linear, false, 2.0, 20);
  DifferenceOptions options;
  options.at.step = 10;  // of the first run: t = 1, step 20 of the second one
  EXPECT_LE(field_difference(a, b, options).l2, 1e-13);
  options.at.step = 11;
  expect_contains(error_of([&] { field_difference(a, b, options); }, ExitCode::usage), "there are: 0, 10");
  options.at = {std::nullopt, 0.3};
  expect_contains(error_of([&] { field_difference(a, b, options); }, ExitCode::usage),
                  "no output at time 0.3; the nearest are at 0 (step 0) and 1 (step 10)");
  options = DifferenceOptions();
  options.field = "temperature";
  expect_contains(error_of([&] { field_difference(a, b, options); }, ExitCode::usage), "it has: pressure, velocity");
}

Series sine(double frequency, double end, int steps, double noise) {
  Series series{"lift", "force", {}, {}};
  for (int i = 0; i <= steps; ++i) {
    const double t = end * i / steps;
    series.time.push_back(t + 0.2 * end / steps * std::sin(0.7 * i));  // steps of different length
    series.value.push_back(3.0 + 2.0 * std::sin(2 * M_PI * frequency * series.time.back()) +
                           noise * std::cos(31.0 * i));
  }
  return series;
}

TEST(Statistics, OfASine) {
  for (const double noise : {0.0, 0.02}) {
    const Statistics s = statistics(sine(1.7, 10.0, 2000, noise));
    EXPECT_EQ(s.periods, 15);  // between the crossings at 1/1.7 and 16/1.7
    EXPECT_NEAR(s.frequency, 1.7, noise > 0 ? 2e-3 : 1e-4);
    EXPECT_NEAR(s.spectral, 1.7, 5e-3);
    EXPECT_NEAR(s.mean, 3.0, 5e-3);
    EXPECT_NEAR(s.amplitude, 2.0, 0.01 + noise);
    EXPECT_NEAR(s.middle, 3.0, 0.01 + noise);
    EXPECT_NEAR(s.largest - s.smallest, 4.0, 0.01 + 2 * noise);
  }
  const Statistics still = statistics(sine(0.0, 1.0, 100, 0.0));
  EXPECT_EQ(still.frequency, 0.0);
  EXPECT_EQ(still.periods, 0);
  EXPECT_NEAR(still.mean, 3.0, 1e-14);
}

TEST_F(CompareTest, ForcesAndEnergiesOfAHistory) {
  const io::RunPaths paths = io::run_paths(scratch / "wake.run.h5");
  std::vector<io::HistoryColumn> columns = io::standard_history_columns();
  for (const char* name : {"cylinder:force_x", "energy:fluid_kinetic", "power:fiber"}) columns.push_back({name, "-"});
  {
    io::History history(comm, paths.csv, "wake", columns);
    for (int step = 1; step <= 400; ++step) {
      const double t = 0.01 * step;
      history.write(
          {1.0 * step, t, 0.01, 1, 1, 1, 1, 0, 0, 0, 0.5, 5.6 + 0.1 * std::cos(2 * M_PI * 3 * t), 2.0, 2 * t});
    }
  }
  EXPECT_EQ(fbi_post("forces wake.run.h5 --from 1 --length 0.1 --speed 2 --format csv"), 0) << output;
  expect_contains(output, "cylinder:force_x,5.5999");
  const post::Run run = read_run(paths.index);
  const Table table = forces_table(read_forces(run, {}, 1.0), 0.1, 2.0);
  EXPECT_NEAR(std::get<double>(table.rows[0][7]), 3.0, 1e-3);
  EXPECT_NEAR(std::get<double>(table.rows[0].back()), 0.15, 1e-4);
  EXPECT_TRUE(std::filesystem::exists(scratch / "wake.forces.svg"));
  const std::vector<Series> energies = read_energies(run);
  ASSERT_EQ(energies.size(), 3u);
  EXPECT_EQ(energies[2].name, "work:fiber");
  EXPECT_NEAR(energies[2].value.back(), 16.0 - 1e-4, 1e-10);  // int 2t from 0.01 to 4
  EXPECT_EQ(fbi_post("energy wake.run.h5"), 0) << output;
  expect_contains(output, "work:fiber");
  EXPECT_TRUE(std::filesystem::exists(scratch / "wake.energy.pdf"));
  EXPECT_EQ(fbi_post("forces wake.run.h5 --quantity tail:force_x"), 1);
  expect_contains(output, "it has: step, time");
  EXPECT_EQ(fbi_post("forces wake.run.h5 --from 7"), 1);
  expect_contains(output, "ends at time 4, before --from 7");
  EXPECT_EQ(fbi_post("forces wake.run.h5 --length 1"), 1);
  write("plain", {2, 2, 2}, linear);
  EXPECT_EQ(fbi_post("forces plain.run.h5"), 6);
  EXPECT_EQ(fbi_post("energy plain.run.h5"), 6);
}

TEST_F(CompareTest, TheProgramFromOutside) {
  write("n4", {8, 4, 4}, smooth);
  write("n8", {16, 8, 8}, smooth);
  write("n16", {32, 16, 16}, smooth, true);
  EXPECT_EQ(fbi_post("l2 n4.run.h5 n4.run.h5 --norm l2 --norm h1 --norm max --format csv"), 0) << output;
  expect_contains(output, "velocity,l2,1,0,0,");
  EXPECT_TRUE(std::filesystem::exists(scratch / "n4.l2.csv"));
  EXPECT_EQ(fbi_post("l2 n4.run.h5 n16.run.h5 --field pressure --remove-mean"), 0) << output;
  EXPECT_EQ(fbi_post("convergence n16.run.h5 n4.run.h5 n8.run.h5 --format csv --quiet "
                     "--exact 'sin(2*x)*y, cos(x+y)+z*z, x*y*z+t' --exact-pressure '1000+sin(x+2*y+z)'"),
            0)
      << output;
  EXPECT_LT(output.find("n4,velocity l2"), output.find("n16,velocity l2"));  // from coarse to fine
  expect_contains(output, "n16,pressure l2");
  for (const char* ending : {"csv", "dat", "svg", "png", "pdf", "wall.dat", "wall.svg"}) {
    const std::string file = scratch / ("compare.convergence." + std::string(ending));
    EXPECT_TRUE(std::filesystem::exists(file)) << ending;
  }
  expect_contains(io::read_text_file(scratch / "compare.convergence.gp"), "set label '2'");  // the slope triangle
  EXPECT_EQ(fbi_post("convergence n4.run.h5 n8.run.h5 --reference n16.run.h5 --against unknowns --no-plot"), 0)
      << output;
  EXPECT_EQ(fbi_post("convergence n4.run.h5 n8.run.h5 --quantity wall_seconds --reference-value 0 --no-plot"), 0);
  // What cannot be done is said, with its remedy.
  EXPECT_EQ(fbi_post("l2 n4.run.h5"), 1);
  expect_contains(output, "--exact");
  EXPECT_EQ(fbi_post("l2 n4.run.h5 n8.run.h5 --exact 'x,y,z'"), 1);
  EXPECT_EQ(fbi_post("l2 n4.run.h5 --exact 'x,y'"), 1);
  expect_contains(output, "needs 3 formulas");
  EXPECT_EQ(fbi_post("l2 n4.run.h5 --exact 'x,y,q'"), 1);
  expect_contains(output, "\"q\"");
  EXPECT_EQ(fbi_post("l2 n4.run.h5 --exact '1/(x-x),y,z'"), 1);
  expect_contains(output, "not finite");
  EXPECT_EQ(fbi_post("l2 n4.run.h5 n8.run.h5 --field centerline"), 1);
  expect_contains(output, "has no fibers");
  EXPECT_EQ(fbi_post("l2 n4.run.h5 n8.run.h5 --time 0.4"), 1);
  EXPECT_EQ(fbi_post("convergence n4.run.h5 n8.run.h5 --reference n16.run.h5 --against dt"), 1);
  expect_contains(output, "choose another axis");
  EXPECT_EQ(fbi_post("convergence n4.run.h5 --quantity cfl"), 1);
  expect_contains(output, "--reference-value");
  write("small", {4, 4, 4}, linear, false, 1.0);
  EXPECT_EQ(fbi_post("l2 n4.run.h5 small.run.h5"), 2);
  EXPECT_EQ(fbi_post("l2 n4.run.h5 small.run.h5 --uncovered 0.6"), 0) << output;
  expect_contains(output, "warning");
  for (const char* name : {"l2", "convergence", "energy", "forces", "verification"}) {
    EXPECT_EQ(fbi_post(std::string(name) + " --help"), 0);
    EXPECT_EQ(fbi_post(name), 1);
  }
}

TEST_F(CompareTest, TablesOfAPage) {
  const std::string rows = scratch / "records";
  io::make_directory(rows);
  io::write_text_file(rows + "/b_test.tsv",
                      "Fluid\tS-F10\tlater\tsource A\t1.5\t1.51\t0.0066\t\t1 %\tb_test\tregression,slow\n"
                      "Fluid\tS-F2\tfirst | one\texact\t0\t3.25e-05\t\t1.98765\torder 1.9\tb_test\tunit\n");
  io::write_text_file(rows + "/a_test.tsv", "Fluid\t\tno name\tidentity\t0\tmet\t\t\t\ta_test\t\n");
  const std::string page = scratch / "page.md";
  const std::string text = "# Page\n\n<!-- table: Fluid -->\nold\n<!-- end of table -->\nprose\n";
  io::write_text_file(page, text);
  const std::string command = "verification '" + rows + "' -o '" + page + "'";
  EXPECT_EQ(fbi_post(command), 0) << output;
  const std::string wanted =
      "# Page\n\n<!-- table: Fluid -->\n"
      "| case | check | reference | ours | error | order | bar | test |\n|---|---|---|---|---|---|---|---|\n"
      "| S-F2 | first \\| one | 0 (exact) | 3.25e-05 | | 1.99 | order 1.9 | `b_test` |\n"
      "| S-F10 | later | 1.5 (source A) | 1.51 | 6.6e-03 | | 1 % | `b_test` (slow) |\n"
      "| | no name | 0 (identity) | met | | | | `a_test` |\n<!-- end of table -->\nprose\n";
  EXPECT_EQ(io::read_text_file(page), wanted);
  EXPECT_EQ(fbi_post(command), 0) << output;  // again: the same page
  EXPECT_EQ(io::read_text_file(page), wanted);
  io::write_text_file(rows + "/c_test.tsv", "Fluidd\t\tx\t\t\t\t\t\t\tc_test\t\n");
  EXPECT_EQ(fbi_post(command), 1);
  expect_contains(output, "c_test\" records rows of the section \"Fluidd\"");
  expect_contains(output, "it has \"Fluid\"");
  EXPECT_EQ(io::read_text_file(page), wanted);
  io::write_text_file(rows + "/c_test.tsv", "Fluid\ttoo short\n");
  EXPECT_EQ(fbi_post(command), 6);
  expect_contains(output, "c_test.tsv\":1: a row has 11 fields");
  std::filesystem::remove(rows + "/c_test.tsv");
  io::write_text_file(page, "<!-- table: Fluid -->\n");
  EXPECT_EQ(fbi_post(command), 1);
  expect_contains(output, "does not end");
  io::write_text_file(page, text + "<!-- table: Fibers -->\n<!-- end of table -->\n");
  EXPECT_EQ(fbi_post(command), 0);
  expect_contains(output, "no rows for the table \"Fibers\"");
  EXPECT_EQ(fbi_post("verification nowhere -o '" + page + "'"), 6);
}

}  // namespace
}  // namespace fbi::post
