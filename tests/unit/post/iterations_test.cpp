/// Tables and pictures of iterations: counts of schemes with different columns, failed runs.
#include "post/iterations.hpp"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "base/error.hpp"
#include "io/history.hpp"
#include "io/pending_file.hpp"
#include "unit/io/example_case.hpp"
#include "unit/io/scratch.hpp"
#include "unit/post/helpers.hpp"

namespace fbi::post {
namespace {

using test::cell;

using test::error_of;
using test::expect_contains;
using test::Scratch;

const std::vector<io::HistoryColumn> columns = {{"step", "-"},        {"time", "time"},
                                                {"newton", "-"},      {"krylov", "-"},
                                                {"relaxation", "-"},  {"coupling_iterations", "-"},
                                                {"evaluations", "-"}, {"wall_seconds", "s"}};

/// A run of 4 steps: coupling iterations 1, 2, 3, 6; evaluations one more; 10 Krylov iterations and 0.5 s each.
post::Run run(const std::string& name, const std::vector<std::string>& more = {}, double relaxation = 0.0) {
  post::Run result;
  result.name = name;
  io::HistoryTable table;
  for (const io::HistoryColumn& column : columns) {
    table.columns.push_back(column.name);
    table.units.push_back(column.unit);
  }
  table.columns.insert(table.columns.end(), more.begin(), more.end());
  table.units.resize(table.columns.size(), "-");
  for (int step = 1; step <= 4; ++step) {
    const double iterations = step == 4 ? 6.0 : step;
    std::vector<double> row = {1.0 * step, 0.1 * step, 2, 10, relaxation * step, iterations, iterations + 1.0, 0.5};
    for (std::size_t k = 0; k < more.size(); ++k) row.push_back(0.25 * step);
    table.rows.push_back(row);
  }
  result.history = table;
  return result;
}

TEST(Iterations, MeanAndMostOfEachRun) {
  const Table table = iterations_table({run("a"), run("b")});
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_EQ(std::get<std::string>(cell(table, 1, "run")), "b");
  EXPECT_EQ(std::get<GlobalIndex>(cell(table, 0, "steps")), 4);
  EXPECT_DOUBLE_EQ(std::get<double>(cell(table, 0, "iterations, mean")), 3.0);
  EXPECT_EQ(std::get<GlobalIndex>(cell(table, 0, "iterations, most")), 6);
  EXPECT_DOUBLE_EQ(std::get<double>(cell(table, 0, "evaluations, mean")), 4.0);
  EXPECT_EQ(std::get<GlobalIndex>(cell(table, 0, "evaluations, most")), 7);
  EXPECT_DOUBLE_EQ(std::get<double>(cell(table, 0, "wall [s]")), 2.0);
  EXPECT_DOUBLE_EQ(std::get<double>(cell(table, 0, "wall a step [s]")), 0.5);
  EXPECT_EQ(std::get<std::string>(cell(table, 0, "failed at")), "-");
  for (const std::string& column : table.columns) EXPECT_EQ(column.find("interface"), std::string::npos);
}

TEST(Iterations, ColumnsThatOneRunHasAreAbsentInTheOthers) {
  const std::vector<post::Run> runs = {run("plain"), run("newton", {"interface_krylov"}, 0.25)};
  const Table table = iterations_table(runs);
  EXPECT_EQ(std::get<std::string>(cell(table, 0, "interface Krylov, mean")), "-");
  EXPECT_DOUBLE_EQ(std::get<double>(cell(table, 1, "interface Krylov, mean")), 0.625);
  const std::vector<Plot> plots = iterations_plots(runs);
  ASSERT_EQ(plots.size(), 4u);
  EXPECT_EQ(plots[2].y_label, "relaxation factor");
  ASSERT_EQ(plots[2].curves.size(), 2u);
  EXPECT_TRUE(std::isnan(plots[2].curves[0].rows.at(0).at(1)));
  EXPECT_DOUBLE_EQ(plots[2].curves[1].rows.at(3).at(1), 1.0);
  EXPECT_DOUBLE_EQ(plots[0].curves[0].rows.at(3).at(1), 6.0);
  EXPECT_EQ(iterations_plots({runs[0]}).size(), 3u);
}

TEST(Iterations, FailedRuns) {
  post::Run late = run("late"), early = run("early"), empty = run("empty");
  late.history->failure = "step 5 (t = 0.5) did not converge";
  early.history->failure = "step 1 (t = 0.1) did not converge";
  early.history->rows.clear();
  const Table table = iterations_table({late, early});
  EXPECT_EQ(std::get<GlobalIndex>(cell(table, 0, "failed at")), 5);
  EXPECT_EQ(std::get<GlobalIndex>(cell(table, 1, "failed at")), 1);
  EXPECT_EQ(std::get<GlobalIndex>(cell(table, 1, "steps")), 0);
  EXPECT_EQ(std::get<std::string>(cell(table, 1, "iterations, mean")), "-");
  empty.history->rows.clear();
  expect_contains(error_of([&] { iterations_table({empty}); }), "has no rows yet");
}

TEST(Iterations, TheProgramFromOutside) {
  const Comm comm(MPI_COMM_SELF);
  const Scratch scratch(comm);
  for (const char* name : {"one", "two"}) {
    io::History history(comm, scratch / (std::string(name) + ".run.csv"), name, columns);
    const post::Run example = run(name);
    for (const std::vector<double>& row : example.history->rows) history.write(row);
    if (name == std::string("two")) history.write_failure("step 5 (t = 0.5) did not converge");
  }
  const std::string command = "cd '" + scratch.path() +
                              "' && '" FBI_BIN_DIR
                              "/fbi-post' iterations one.run.h5 two.run.h5 --format csv > output 2>&1";
  const int status = std::system(command.c_str());
  const std::string output = io::read_text_file(scratch / "output");
  EXPECT_EQ(WIFEXITED(status) ? WEXITSTATUS(status) : -1, 0) << output;
  expect_contains(output, "one,4,3,6,4,7,2,2,10,10,2,0.5,-\n");
  expect_contains(output, "two,4,3,6,4,7,2,2,10,10,2,0.5,5\n");
  for (const char* ending : {"csv", "dat", "gp", "svg", "png", "pdf"}) {
    const std::string file = scratch / ("compare.iterations." + std::string(ending));
    EXPECT_TRUE(std::filesystem::exists(file) && std::filesystem::file_size(file) > 0) << ending;
  }
}

}  // namespace
}  // namespace fbi::post
