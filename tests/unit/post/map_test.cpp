/// Heat maps: reading of tables, colors and texts of the cells, mistakes.
#include "post/map.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "base/error.hpp"
#include "io/pending_file.hpp"
#include "unit/io/example_case.hpp"
#include "unit/io/scratch.hpp"

namespace fbi::post {
namespace {

using test::error_of;
using test::expect_contains;
using test::Scratch;

constexpr const char* table =
    "# title: Step and ratio\n# x: time step\n# y: density ratio\n"
    "x\ty\toutcome\tgrowth\tnewton mean\n"
    "1e-4\t10\tstable\t0.7\t2\n"
    "1e-2\t10\tfailed\t-\t5.5\n"
    "1e-4\tlight, it's 0.1\talternating\t0.99\t3\n"
    "1e-2\tlight, it's 0.1\tgrowing\t1.2\t4\n";

TEST(Map, AxesCellsAndTexts) {
  const Comm comm;
  const Scratch scratch(comm);
  io::write_text_file(scratch / "a.tsv", table);
  const Map map = read_map(scratch / "a.tsv", {"newton mean", "growth"});
  EXPECT_EQ(map.title, "Step and ratio");
  EXPECT_EQ(map.x_label, "time step");
  EXPECT_EQ(map.y_label, "density ratio");
  EXPECT_EQ(map.x, (std::vector<std::string>{"1e-4", "1e-2"}));
  EXPECT_EQ(map.y, (std::vector<std::string>{"10", "light, it's 0.1"}));
  ASSERT_EQ(map.cells.size(), 4u);
  EXPECT_EQ(map.cells[3].i, 1u);
  EXPECT_EQ(map.cells[3].j, 1u);
  EXPECT_EQ(map.cells[3].outcome, "growing");
  EXPECT_EQ(map.cells[3].text, "4\\n1.2");

  write_map(scratch / "a", map, {"newton mean", "growth"});
  const std::string script = io::read_text_file(scratch / "a.gp"), data = io::read_text_file(scratch / "a.dat");
  expect_contains(script, "'light, it''s 0.1' 1");
  expect_contains(script, "'ended early'");
  EXPECT_EQ(script.find("pressure rough"), std::string::npos);  // no such cell, no entry in the key
  expect_contains(data, "# failed\n1 0 0.5 1.5 -0.5 0.5\n");
  expect_contains(data, "1 1 \"4\\n1.2\"\n");
  EXPECT_GT(std::filesystem::file_size(scratch / "a.png"), 1000u);
}

TEST(Map, Mistakes) {
  const Comm comm;
  const Scratch scratch(comm);
  const auto text_of = [&](const std::string& text, const std::vector<std::string>& shown) {
    io::write_text_file(scratch / "b.tsv", text);
    return error_of([&] { read_map(scratch / "b.tsv", shown); }, shown.empty() ? ExitCode::file : ExitCode::usage);
  };
  expect_contains(text_of(table, {"krylov"}), "no column \"krylov\"; there are: x, y, outcome, growth, newton mean");
  expect_contains(text_of("x\ty\n1\t2\n", {}), "no column \"outcome\"");
  expect_contains(text_of("x\ty\toutcome\n1\t2\n", {}), "has 2 fields, not 3");
  expect_contains(text_of("x\ty\toutcome\n1\t2\tfine\n", {}), "unknown outcome \"fine\"");
  expect_contains(text_of("x\ty\toutcome\n", {}), "holds no points");
}

}  // namespace
}  // namespace fbi::post
