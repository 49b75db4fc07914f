/// Work and precision: errors and slopes of synthetic histories whose errors are known.
#include "post/precision.hpp"

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

const std::vector<io::HistoryColumn> columns = {{"step", "-"},
                                                {"time", "time"},
                                                {"dt", "time"},
                                                {"krylov", "-"},
                                                {"wall_seconds", "s"},
                                                {"beam:displacement_x", "length"},
                                                {"beam:displacement_y", "length"},
                                                {"beam:displacement_z", "length"}};

/// A run until t = 1 whose end is at (t + (1 - t) early, t error, 0): at all times t it is off by t error across, and
/// `early` more along, which vanishes at the end. A step takes 3 Krylov iterations.
post::Run run(const std::string& name, int steps, double seconds, double error, double early = 0.0) {
  post::Run result;
  result.name = name;
  io::HistoryTable table;
  for (const io::HistoryColumn& column : columns) {
    table.columns.push_back(column.name);
    table.units.push_back(column.unit);
  }
  for (int step = 1; step <= steps; ++step) {
    const double t = static_cast<double>(step) / steps;
    table.rows.push_back({1.0 * step, t, 1.0 / steps, 3, seconds / steps, t + (1.0 - t) * early, t * error, 0.0});
  }
  result.history = table;
  return result;
}

WorkSeries series(const std::string& name, const std::vector<post::Run>& runs, const post::Run& reference) {
  WorkSeries result{name, {}};
  for (const post::Run& one : runs) {
    result.points.push_back(work_of(one));
    result.points.back().error = tip_error(one, reference, {});
  }
  return result;
}

TEST(Precision, WorkIsTheSumOfTheSteps) {
  const WorkPoint point = work_of(run("a", 8, 2.0, 0.0));
  EXPECT_EQ(point.run, "a");
  EXPECT_EQ(point.steps, 8);
  EXPECT_EQ(point.krylov, 24);
  EXPECT_DOUBLE_EQ(point.dt, 0.125);
  EXPECT_DOUBLE_EQ(point.seconds, 2.0);
}

TEST(Precision, ErrorOverAllSharedTimes) {
  const post::Run fine = run("fine", 12, 9.0, 0.0);
  EXPECT_EQ(tip_error(fine, fine, {}), 0.0);
  // Off by t error at every time, relative to t: the error itself, on the times of the coarse and of the finer run.
  for (const int steps : {3, 6, 12}) EXPECT_NEAR(tip_error(run("a", steps, 1.0, 0.05), fine, {"beam"}), 0.05, 1e-15);
  EXPECT_NEAR(tip_error(run("finer", 24, 1.0, 0.05), fine, {}), 0.05, 1e-15);
  // What happens before the end counts: t = 1/3, 2/3, 1 with deviations 0.2 (1 - t).
  EXPECT_NEAR(tip_error(run("early", 3, 1.0, 0.0, 0.2), fine, {}), 0.2 * std::sqrt(5.0 / 14.0), 1e-15);
  // Times that only one has do not count: 8 steps and 12 meet at 1/4, 1/2, 3/4, 1.
  EXPECT_NEAR(tip_error(run("other", 8, 1.0, 0.0, 0.2), fine, {}), 0.2 * std::sqrt(14.0 / 30.0), 1e-15);
}

TEST(Precision, SlopesOfKnownOrders) {
  const post::Run fine = run("fine", 64, 100.0, 0.0);
  std::vector<post::Run> first, second;
  for (const int n : {4, 8, 16, 32}) {
    first.push_back(run("first", n, 0.1 * n, 0.4 / n));
    second.push_back(run("second", n, 0.2 * n, 0.8 / (n * n)));
  }
  const WorkSeries one = series("one", first, fine), two = series("two", second, fine);
  EXPECT_NEAR(*slope(one), 1.0, 1e-12);
  EXPECT_NEAR(*slope(two), 2.0, 1e-12);
  EXPECT_NEAR(*slope(two.points[0], two.points[1]), 2.0, 1e-12);
  EXPECT_NEAR(*slope(two.points[1], two.points[0]), 2.0, 1e-12);
  const Table table = precision_table({one, two}, "tip");
  ASSERT_EQ(table.rows.size(), 8u);
  EXPECT_EQ(std::get<std::string>(cell(table, 0, "slope")), "-");
  EXPECT_NEAR(std::get<double>(cell(table, 1, "slope")), 1.0, 1e-12);
  EXPECT_NEAR(std::get<double>(cell(table, 7, "slope")), 2.0, 1e-12);
  EXPECT_NEAR(std::get<double>(cell(table, 4, "of the series")), 2.0, 1e-12);
  EXPECT_EQ(std::get<std::string>(cell(table, 4, "series")), "two");
  EXPECT_NEAR(std::get<double>(cell(table, 7, "error")), 0.8 / 1024, 1e-15);
  EXPECT_NEAR(std::get<double>(cell(table, 7, "wall [s]")), 6.4, 1e-12);
  const Plot plot = precision_plot({one, two}, "tip", "title");
  ASSERT_EQ(plot.curves.size(), 2u);
  EXPECT_TRUE(plot.log_axes);
  EXPECT_EQ(plot.curves[1].label, "two (2.0)");
  EXPECT_NEAR(plot.curves[1].rows.at(3).at(0), 6.4, 1e-12);
  EXPECT_NEAR(plot.curves[1].rows.at(3).at(1), 0.8 / 1024, 1e-15);
}

TEST(Precision, NoSlopeWhereThereIsNone) {
  const post::Run fine = run("fine", 8, 9.0, 0.0);
  const WorkSeries equal = series("equal", {run("a", 4, 1.0, 0.1), run("b", 4, 1.05, 0.01)}, fine);
  EXPECT_FALSE(slope(equal).has_value());
  const WorkSeries exact = series("exact", {run("a", 4, 1.0, 0.1), fine}, fine);
  EXPECT_FALSE(slope(exact).has_value());
  EXPECT_FALSE(slope(exact.points[0], exact.points[1]).has_value());
  EXPECT_EQ(precision_plot({exact}, "tip", "").curves.at(0).rows.size(), 1u);
  EXPECT_EQ(precision_plot({exact}, "tip", "").curves.at(0).label, "exact");
  const WorkSeries nothing = series("nothing", {fine}, fine);
  expect_contains(error_of([&] { precision_plot({nothing}, "tip", ""); }, ExitCode::usage), "all errors are exactly 0");
  // More work with a larger error: negative.
  EXPECT_LT(*slope(series("worse", {run("a", 4, 1.0, 0.1), run("b", 4, 2.0, 0.2)}, fine)), -0.99);
}

TEST(Precision, Mistakes) {
  const post::Run fine = run("fine", 8, 9.0, 0.0);
  post::Run failed = run("failed", 4, 1.0, 0.1), timeless = failed, still = fine, shorter = fine, other = fine;
  failed.history->failure = "step 5 (t = 1.25) did not converge";
  expect_contains(error_of([&] { work_of(failed); }), "did not converge");
  timeless.history->columns[4] = "something";
  expect_contains(error_of([&] { work_of(timeless); }), "wall_seconds");
  expect_contains(error_of([&] { work_of(run("a", 4, 0.0, 0.1)); }), "are 0");
  for (std::vector<double>& row : still.history->rows) row[5] = row[6] = 0.0;
  expect_contains(error_of([&] { tip_error(fine, still, {}); }, ExitCode::usage), "do not move");
  shorter.history->rows.resize(4);
  expect_contains(error_of([&] { tip_error(fine, shorter, {}); }, ExitCode::usage), "no row (its last time is 0.5)");
  for (int c : {5, 6, 7}) other.history->columns[c].replace(0, 4, "rod");
  expect_contains(error_of([&] { tip_error(fine, other, {}); }, ExitCode::usage), "no fiber end in common");
  expect_contains(error_of([&] { tip_error(fine, fine, {"mast"}); }, ExitCode::usage), "no record of fiber");
}

TEST(Precision, TheProgramFromOutside) {
  const Comm comm(MPI_COMM_SELF);
  const Scratch scratch(comm);
  const auto write = [&](const post::Run& one) {
    io::History history(comm, scratch / (one.name + ".run.csv"), one.name, columns);
    for (const std::vector<double>& row : one.history->rows) history.write(row);
  };
  write(run("fine", 8, 16.0, 0.0));
  write(run("other", 8, 16.0, 0.5));
  write(run("a", 2, 1.0, 0.25));
  write(run("b", 4, 2.0, 0.0625));
  write(run("c", 4, 4.0, 0.25));
  const auto call = [&](const std::string& arguments, int expected) {
    const std::string command =
        "cd '" + scratch.path() + "' && '" FBI_BIN_DIR "/fbi-post' precision " + arguments + " > output 2>&1";
    const int status = std::system(command.c_str());
    const std::string output = io::read_text_file(scratch / "output");
    EXPECT_EQ(WIFEXITED(status) ? WEXITSTATUS(status) : -1, expected) << output;
    return output;
  };
  const std::string output = call(
      "--series 'time step' a.run.h5 b.run.h5 --series mesh c.run.h5 --reference fine.run.h5 "
      "--series-reference mesh other.run.h5 --format csv --quiet",
      0);
  expect_contains(output, "series,run,quantity,dt,steps,Krylov,wall [s],error,slope,of the series\n");
  expect_contains(output, "time step,a,tip,0.5,2,6,1,0.25,-,2\n");
  expect_contains(output, "time step,b,tip,0.25,4,12,2,0.0625,2,2\n");
  expect_contains(output, "mesh,c,tip,0.25,4,12,4,0.2236067977");  // 0.25 across against 0.5: 0.25/sqrt(1.25)
  EXPECT_EQ(output.find("wrote"), std::string::npos);
  for (const char* ending : {"csv", "dat", "gp", "svg", "png", "pdf"}) {
    const std::string file = scratch / ("compare.precision." + std::string(ending));
    EXPECT_TRUE(std::filesystem::exists(file) && std::filesystem::file_size(file) > 0) << ending;
  }
  expect_contains(call("--series only --reference fine.run.h5", 1), "has no runs");
  expect_contains(call("--series s a.run.h5 --series s b.run.h5 --reference fine.run.h5", 1), "two series \"s\"");
  expect_contains(call("--series s a.run.h5 --reference fine.run.h5 --series-reference t b.run.h5", 1),
                  "there is no series \"t\"");
  expect_contains(call("--series s a.run.h5", 1), "--reference");
}

}  // namespace
}  // namespace fbi::post
