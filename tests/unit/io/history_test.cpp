/// The history: rows come back with all digits, a restart cuts, a full disk is noticed.
#include "io/history.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "example_case.hpp"
#include "io/pending_file.hpp"
#include "scratch.hpp"

namespace fbi::io {
namespace {

using test::error_of;
using test::expect_contains;
using test::Scratch;

std::vector<HistoryColumn> columns() {
  std::vector<HistoryColumn> all = standard_history_columns();
  all.push_back({"patch/112/7:displacement_x", "length"});
  return all;
}

std::vector<double> row(GlobalIndex step) {
  std::vector<double> values(columns().size(), 1.0 / 3.0);
  values[0] = static_cast<double>(step);
  values[1] = 0.1 * static_cast<double>(step);
  values.back() = std::sin(static_cast<double>(step)) * 1e-7;
  return values;
}

TEST(History, StartsWithTheStandardColumns) {
  std::string names;
  for (const HistoryColumn& column : standard_history_columns()) names += column.name + " ";
  EXPECT_EQ(
      names,
      "step time dt newton krylov coupling_iterations evaluations residual cfl constraint_violation wall_seconds ");
}

TEST(History, RowsComeBackBitwiseAndEachIsThereAtOnce) {
  const Comm comm;
  const Scratch scratch(comm);
  History history(comm, scratch / "a.run.csv", "history of a.json", columns());
  for (GlobalIndex step = 1; step <= 5; ++step) {
    history.write(row(step));
    if (comm.rank() == 0) {
      const HistoryTable table = read_history(scratch / "a.run.csv");
      ASSERT_EQ(table.rows.size(), static_cast<std::size_t>(step));
      EXPECT_EQ(table.rows.back(), row(step));
      EXPECT_EQ(table.column("patch/112/7:displacement_x"), 11);
      EXPECT_EQ(table.column("nothing"), -1);
      EXPECT_EQ(table.units[1], "time");
    }
  }
  if (comm.rank() == 0) expect_contains(read_text_file(scratch / "a.run.csv"), "\nstep,time,dt,newton,");
}

TEST(History, ARestartCutsWhatComesAfterItsStep) {
  const Comm comm;
  const Scratch scratch(comm);
  const std::string path = scratch / "a.run.csv";
  {
    History history(comm, path, "title", columns());
    for (GlobalIndex step = 1; step <= 9; ++step) history.write(row(step));
  }
  if (comm.rank() == 0) std::ofstream(path, std::ios::app) << "10,1.0,0.1";  // a row that a kill left incomplete
  MPI_Barrier(comm.get());
  {
    History history(comm, path, "title", columns(), 6);
    history.write(row(7));
  }
  if (comm.rank() == 0) {
    const HistoryTable table = read_history(path);
    ASSERT_EQ(table.rows.size(), 7u);
    for (GlobalIndex step = 1; step <= 7; ++step) EXPECT_EQ(table.rows[step - 1], row(step));
  }
  expect_contains(error_of([&] { History(comm, path, "title", standard_history_columns(), 3); }), "other columns");
  { History fresh(comm, path, "title", columns()); }
  if (comm.rank() == 0) {
    EXPECT_TRUE(read_history(path).rows.empty());
  }
}

TEST(History, AFailureIsKeptUntilTheRunGoesOn) {
  const Comm comm;
  const Scratch scratch(comm);
  const std::string path = scratch / "a.run.csv";
  {
    History history(comm, path, "title", columns());
    history.write(row(1));
    history.write_failure("step 2 (t = 0.2) did not converge:\nresidual 1, 2 and 3");
  }
  if (comm.rank() == 0) {
    const HistoryTable table = read_history(path);
    EXPECT_EQ(table.rows.size(), 1u);
    EXPECT_EQ(table.failure, "step 2 (t = 0.2) did not converge: residual 1, 2 and 3");
  }
  MPI_Barrier(comm.get());
  { const History again(comm, path, "title", columns(), 1); }
  if (comm.rank() == 0) {
    EXPECT_EQ(read_history(path).rows.size(), 1u);
    EXPECT_EQ(read_history(path).failure, "");
  }
}

TEST(History, AnIncompleteLastRowIsLeftOutAndAWrongOneIsAnError) {
  const Comm comm;
  if (comm.rank() != 0) return;
  const Scratch scratch(Comm(MPI_COMM_SELF));
  std::ofstream(scratch / "a.csv") << "# units: -,time\nstep,time\n1,0.5\n2,nan\n3,1.";
  const HistoryTable table = read_history(scratch / "a.csv");
  ASSERT_EQ(table.rows.size(), 2u);
  EXPECT_TRUE(std::isnan(table.rows[1][1]));
  std::ofstream(scratch / "b.csv") << "step,time\n1,0.5\n2,abc\n3,1.\n";
  expect_contains(error_of([&] { read_history(scratch / "b.csv"); }), "b.csv\":3:");
  std::ofstream(scratch / "c.csv") << "# nothing\n";
  expect_contains(error_of([&] { read_history(scratch / "c.csv"); }), "not a history");
  expect_contains(error_of([&] { read_history(scratch / "d.csv"); }), "cannot read");
}

TEST(History, AFullDiskIsAnErrorOnAllRanks) {
  const Comm comm;
  const Scratch scratch(comm);
  History history(comm, scratch / "a.run.csv", "title", columns());
  MPI_Barrier(comm.get());
  std::string message;
  {
    const test::FileSizeLimit limit(4096);
    message = error_of([&] {
      for (GlobalIndex step = 1; step <= 100; ++step) history.write(row(step));
    });
  }
  expect_contains(message, "cannot write");
  if (comm.rank() == 0) {
    EXPECT_GT(read_history(scratch / "a.run.csv").rows.size(), 10u);  // what was written before is readable
  }
}

}  // namespace
}  // namespace fbi::io
