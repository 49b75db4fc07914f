/// Reading a run (finished, going on, without index), the tip table and plot, pictures, info, and fbi-post from
/// outside.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "io/checkpoint.hpp"
#include "io/history.hpp"
#include "io/pending_file.hpp"
#include "io/result_file.hpp"
#include "post/info.hpp"
#include "post/picture.hpp"
#include "post/reader.hpp"
#include "post/table.hpp"
#include "post/tip.hpp"
#include "unit/io/example_case.hpp"
#include "unit/io/scratch.hpp"
#include "unit/post/helpers.hpp"

namespace fbi::post {
namespace {

using test::error_of;
using test::expect_contains;
using test::Scratch;

double tip_x(double time) { return 0.2 * std::sin(3.0 * time); }

// A run of ten steps of 0.1 with outputs at steps 0, 5 and 10: the tips move by tip_x(time) in x.
class PostTest : public ::testing::Test {
 protected:
  PostTest() : comm(MPI_COMM_SELF), scratch(comm), paths(io::run_paths(scratch / "example.run.h5")) {}

  void write(bool probe, bool finish) {
    const io::CaseFile content = test::example_case();
    io::write_case_file(scratch / "example.h5", content);
    const mesh::HexMesh fluid = test::distribute_mesh(comm, content);
    const mesh::FiberMesh fibers = test::distribute_fibers(comm, content, &fluid);
    io::ResultWriter writer(comm, paths, &fluid, &fibers,
                            {content.json, content.json_name, "fbi-run 0.1.0", "fbi-run example.h5", 1}, 8);
    std::vector<io::HistoryColumn> columns = io::standard_history_columns();
    if (probe)
      for (const char* axis : {"x", "y", "z"})
        columns.push_back({std::string("patch/3:displacement_") + axis, "length"});
    io::History history(comm, paths.csv, "history of example.json", columns);
    for (int step = 0; step <= 10; ++step) {
      const double time = 0.1 * step;
      if (step > 0) {
        std::vector<double> row(columns.size(), 1.0);
        row[0] = step;
        row[1] = time;
        if (probe) {
          row[11] = tip_x(time);
          row[12] = row[13] = 0.0;
        }
        history.write(row);
      }
      if (step % 5) continue;
      std::vector<double> state, dofs = fibers.reference_dofs();
      for (Index n = 0; n < fluid.owned_nodes; ++n) state.insert(state.end(), {fluid.node(n)[1] * time, 0.0, 0.0, 1.0});
      for (std::size_t n = 0; n < dofs.size() / 6; ++n) dofs[6 * n] += tip_x(time) * dofs[6 * n + 1] / 0.3;
      writer.write_step(step, time, {{"velocity", 3, 4, 0, state.data()}, {"pressure", 1, 4, 3, state.data()}},
                        {&dofs, nullptr, nullptr});
    }
    io::write_checkpoint(comm, paths, {10, 1.0, io::fingerprint(content.json), {{"dt", 0.1}}, {}}, nullptr, {}, nullptr,
                         {});
    if (finish) writer.finish();
  }

  // Exit code of fbi-post with these arguments; its output goes to `output`.
  int fbi_post(const std::string& arguments) { return test::run_fbi_post(scratch, arguments, output); }

  Comm comm;
  Scratch scratch;
  io::RunPaths paths;
  std::string output;
};

TEST_F(PostTest, TipsFromProbes) {
  write(true, true);
  const post::Run run = read_run(paths.index);
  EXPECT_TRUE(run.complete);
  EXPECT_EQ(run.name, "example");
  EXPECT_EQ(run.outputs.size(), 3u);
  const std::vector<TipSeries> tips = read_tips(run, {});
  ASSERT_EQ(tips.size(), 1u);
  EXPECT_EQ(tips[0].fiber, "patch/3");
  ASSERT_EQ(tips[0].time.size(), 10u);
  for (std::size_t i = 0; i < 10; ++i) EXPECT_EQ(tips[0].displacement[i][0], tip_x(tips[0].time[i]));
  const Table table = tip_table(tips);
  ASSERT_EQ(table.rows.size(), 1u);
  EXPECT_DOUBLE_EQ(std::get<double>(table.rows[0][2]), tip_x(0.5));  // the sample nearest to the maximum at pi/6
  EXPECT_DOUBLE_EQ(std::get<double>(table.rows[0][3]), 0.5);
  EXPECT_DOUBLE_EQ(std::get<double>(table.rows[0][5]), tip_x(1.0));
  expect_contains(error_of([&] { read_tips(run, {"patch/9"}); }, ExitCode::usage), "it has: patch/3");
}

TEST_F(PostTest, TipsFromOutputsWithoutProbes) {
  write(false, true);
  const std::vector<TipSeries> tips = read_tips(read_run(paths.index), {});
  ASSERT_EQ(tips.size(), 7u);
  for (const TipSeries& tip : tips) {
    ASSERT_EQ(tip.time, (std::vector<double>{0.0, 0.5, 1.0}));
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_NEAR(tip.displacement[i][0], tip_x(tip.time[i]), 1e-15);
      EXPECT_EQ(tip.displacement[i][1], 0.0);
    }
  }
  EXPECT_EQ(read_tips(read_run(paths.index), {"patch/5", "patch/1"})[1].fiber, "patch/1");
}

TEST_F(PostTest, ARunIsReadWhileItGoesOn) {
  write(true, false);
  EXPECT_FALSE(read_run(paths.index).complete);
  // An index that lists less than the folder holds, or none at all.
  std::filesystem::remove(paths.index);
  const post::Run run = read_run(paths.index);
  ASSERT_EQ(run.outputs.size(), 3u);
  EXPECT_EQ(run.outputs[1].time, 0.5);
  EXPECT_EQ(read_tips(run, {}).size(), 1u);
  // The history of a finished run is in the index as well.
  write(true, true);
  std::filesystem::remove(paths.csv);
  EXPECT_EQ(read_tips(read_run(paths.index), {})[0].time.size(), 10u);
  expect_contains(error_of([&] { read_run(scratch / "other.run.h5"); }), "no such file");
  expect_contains(error_of([&] { read_run(scratch / "example.h5"); }), "is a case file, not a result index");
}

TEST_F(PostTest, PlotsLieBesideTheirData) {
  write(true, true);
  const std::string base = scratch / "plots of one's run";
  const std::vector<TipSeries> tips = read_tips(read_run(paths.index), {});
  const std::vector<std::string> files = write_plot(base, tip_plot(tips, 12));
  ASSERT_EQ(files.size(), 5u);
  for (const std::string& file : files) EXPECT_GT(std::filesystem::file_size(file), 100u) << file;
  EXPECT_EQ(io::read_text_file(base + ".png").substr(1, 3), "PNG");
  EXPECT_EQ(io::read_text_file(base + ".pdf").substr(0, 4), "%PDF");
  expect_contains(io::read_text_file(base + ".svg"), "</svg>");
  std::ifstream data(base + ".dat");
  std::string line;
  std::size_t rows = 0;
  while (std::getline(data, line))
    if (!line.empty() && line[0] != '#') {
      double time = 0, x = 0;
      ASSERT_EQ(std::sscanf(line.c_str(), "%lf %lf", &time, &x), 2);
      EXPECT_EQ(x, tips[0].displacement[rows++][0]);
    }
  EXPECT_EQ(rows, 10u);
}

TEST_F(PostTest, TheProgramFromOutside) {
  write(true, true);
  EXPECT_EQ(fbi_post("tip example.run.h5 --format csv -o pictures"), 0) << output;
  for (const char* ending : {"csv", "dat", "gp", "svg", "png", "pdf"})
    EXPECT_TRUE(std::filesystem::exists(scratch / ("pictures/example.tip." + std::string(ending)))) << ending;
  expect_contains(output, "example,patch/3,0.199");
  EXPECT_EQ(fbi_post("tip example.run.h5 example.run.h5 --format markdown"), 0) << output;
  expect_contains(output, "| run ");
  EXPECT_TRUE(std::filesystem::exists(scratch / "compare.tip.png"));
  EXPECT_EQ(fbi_post("picture example.run.h5 --step 5 --quiet"), 0) << output;
  EXPECT_EQ(output, "");
  EXPECT_GT(std::filesystem::file_size(scratch / "example.picture.png"), 1000u);
  EXPECT_EQ(fbi_post("picture example.run.h5 --step 6"), 1);
  expect_contains(output, "there are: 0, 5, 10");
  EXPECT_EQ(
      fbi_post(
          "info example.h5 example.run.h5 example.run/000005.h5 example.run/restart-000010.h5 example.run/mesh.h5"),
      0);
  for (const char* part : {"case file", "6 x 4 x 2, from (0, 0, 0) to (3, 1, 1)", "face set zmax",
                           "patch/0, patch/1, patch/2", "ended properly", "fbi-run example.h5", "step 5",
                           "10 steps, to time 1", "steps 10", "/fluid/velocity", "105 x 3", "checkpoint", "dt"})
    expect_contains(output, part);
  EXPECT_EQ(fbi_post("--help"), 0);
  expect_contains(output, "Exit codes");
  EXPECT_EQ(fbi_post("--version"), 0);
  EXPECT_EQ(fbi_post(""), 1);
  EXPECT_EQ(fbi_post("tip example.run.h5 --format html"), 1);
  EXPECT_EQ(fbi_post("tip missing.run.h5"), 6);
  expect_contains(output, "there is no such file; give the NAME.run.h5");
  EXPECT_EQ(fbi_post("tip example.h5"), 6);
  EXPECT_EQ(fbi_post("tip example.json"), 1);
  EXPECT_EQ(fbi_post("info output"), 6);
  expect_contains(output, "not an HDF5 file");
}

TEST(Table, HasFourFormats) {
  const Table table = {{"name", "value_x"}, {{std::string("a|b,c_d"), 1.0 / 3.0}, {std::string("e"), 2.0}}};
  EXPECT_EQ(format_table(table, TableFormat::text),
            "name      value_x\n-----------------\na|b,c_d  0.333333\ne               2\n");
  EXPECT_EQ(format_table(table, TableFormat::csv), "name,value_x\n\"a|b,c_d\",0.33333333333333331\ne,2\n");
  EXPECT_EQ(format_table(table, TableFormat::markdown),
            "| name     |  value_x |\n| :------- | -------: |\n| a\\|b,c_d | 0.333333 |\n| e        |        2 |\n");
  EXPECT_EQ(format_table(table, TableFormat::latex),
            "\\begin{tabular}{lr}\n\\hline\nname     & value\\_x \\\\\n\\hline\n"
            "a|b,c\\_d & 0.333333 \\\\\ne        &        2 \\\\\n\\hline\n\\end{tabular}\n");
}

}  // namespace
}  // namespace fbi::post
