/// fbi-gen as a program, on the cases of tests/input: exit codes, exact messages, files left untouched.
///
/// Beside each NAME.json of tests/input/invalid lies NAME.expected: a line "exit CODE", then the messages.
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cfenv>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "base/comm.hpp"
#include "io/case_file.hpp"

namespace {

namespace fs = std::filesystem;

const fs::path source = FBI_SOURCE_DIR;
const std::string program = std::string(FBI_BIN_DIR) + "/fbi-gen";

struct Outcome {
  int code = -1;
  std::string out;
  std::string err;
};

std::string file_text(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return std::string(std::istreambuf_iterator<char>(stream), {});
}

class FbiGen : public ::testing::Test {
 protected:
  void SetUp() override {
    scratch = fs::temp_directory_path() / ("fbi_gen_test_" + std::to_string(getpid()));
    fs::create_directories(scratch);
  }
  void TearDown() override { fs::remove_all(scratch); }

  Outcome run(const fs::path& folder, const std::string& arguments, const std::string& before = "") {
    const std::string out = scratch / "out", err = scratch / "err";
    const std::string command = "cd '" + folder.string() + "' && " + before + " '" + program + "' " + arguments +
                                " >'" + out + "' 2>'" + err + "'";
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128, file_text(out), file_text(err)};
  }

  fs::path scratch;
};

std::vector<fs::path> cases_of(const fs::path& folder) {
  std::vector<fs::path> paths;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".json") paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

}  // namespace

TEST_F(FbiGen, TakesEveryValidCase) {
  const std::vector<fs::path> paths = cases_of(source / "tests/input/valid");
  EXPECT_GE(paths.size(), 7u);
  for (const fs::path& path : paths) {
    const Outcome outcome =
        run(path.parent_path(), path.filename().string() + " --quiet -o '" + (scratch / "case.h5").string() + "'");
    EXPECT_EQ(outcome.code, 0) << path << "\n" << outcome.err;
    EXPECT_EQ(outcome.err, "") << path;
    EXPECT_EQ(outcome.out, "") << path;
  }
}

TEST_F(FbiGen, RefusesEveryInvalidCaseWithItsMessage) {
  const std::vector<fs::path> paths = cases_of(source / "tests/input/invalid");
  EXPECT_GE(paths.size(), 20u);
  for (const fs::path& path : paths) {
    fs::path expected = path;
    expected.replace_extension(".expected");
    ASSERT_TRUE(fs::exists(expected)) << expected;
    const Outcome outcome = run(path.parent_path(), path.filename().string() + " --check");
    EXPECT_EQ("exit " + std::to_string(outcome.code) + "\n" + outcome.err, file_text(expected)) << path;
    EXPECT_NE(outcome.code, 0) << path;
  }
}

TEST_F(FbiGen, KeepsAnOldFileWhenItFails) {
  const fs::path old = scratch / "old.h5";
  std::ofstream(old) << "precious";
  const std::string to_old = " -o '" + old.string() + "'";
  EXPECT_EQ(run(source / "tests/input/invalid", "unknown-key.json" + to_old).code, 1);
  EXPECT_EQ(file_text(old), "precious");
  EXPECT_EQ(run(source / "tests/input/invalid", "fiber-outside.json" + to_old).code, 2);
  EXPECT_EQ(file_text(old), "precious");
  // A full disk, by the file-size limit (in blocks of 512 or 1024 bytes; the file needs more).
  const Outcome full = run(source / "tests/input/valid", "reed.json" + to_old, "ulimit -f 8 &&");
  EXPECT_EQ(full.code, 6) << full.err;
  EXPECT_NE(full.err.find("old.h5"), std::string::npos) << full.err;
  EXPECT_EQ(file_text(old), "precious");
  std::size_t others = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(scratch)) {
    const std::string name = entry.path().filename();
    others += name != "old.h5" && name != "out" && name != "err";
  }
  EXPECT_EQ(others, 0u) << "temporary files are left";
}

TEST_F(FbiGen, ReportsFilesItCannotUse) {
  EXPECT_EQ(run(scratch, "nothing.json").code, 6);
  EXPECT_EQ(run(scratch, "nothing.json").err, "nothing.json: cannot be read: No such file or directory\n");
  EXPECT_EQ(run(scratch, ".").code, 6);
  EXPECT_EQ(run(source / "tests/input/valid", "reed.json -o /nonexistent/reed.h5").code, 6);
}

TEST_F(FbiGen, ExplainsItsUse) {
  EXPECT_EQ(run(scratch, "--help").code, 0);
  EXPECT_NE(run(scratch, "--help").out.find("Exit codes"), std::string::npos);
  EXPECT_EQ(run(scratch, "").code, 1);
  EXPECT_EQ(run(scratch, "--chek x.json").code, 1);
  const Outcome version = run(scratch, "--version");
  EXPECT_EQ(version.code, 0);
  for (const char* word : {"fbi-gen", "revision", "build", "HDF5", "PETSc", "Eigen", "muParser"}) {
    EXPECT_NE(version.out.find(word), std::string::npos) << word;
  }
  EXPECT_EQ(run(scratch, "--reference").out, file_text(source / "docs/input-reference.md"));
  EXPECT_EQ(run(scratch, "--schema").out.substr(0, 1), "{");
}

TEST_F(FbiGen, PrintsTheShippedCases) {
  std::size_t count = 0;
  for (const fs::directory_entry& folder : fs::directory_iterator(source / "cases")) {
    const std::string name = folder.path().filename();
    const fs::path text = folder.path() / (name + ".json");
    if (!fs::exists(text)) continue;
    ++count;
    const Outcome printed = run(scratch, "--template " + name);
    EXPECT_EQ(printed.code, 0) << name;
    EXPECT_EQ(printed.out, file_text(text)) << name;
  }
  EXPECT_GE(count, 3u);
  const Outcome wrong = run(scratch, "--template canopi");
  EXPECT_EQ(wrong.code, 1);
  EXPECT_NE(wrong.err.find("there is no template \"canopi\"; there are:"), std::string::npos) << wrong.err;
  EXPECT_NE(wrong.err.find("single-beam"), std::string::npos) << wrong.err;
}

TEST_F(FbiGen, ChecksWithoutWriting) {
  fs::copy_file(source / "tests/input/valid/reed.json", scratch / "reed.json");
  const Outcome checked = run(scratch, "reed.json --check");
  EXPECT_EQ(checked.code, 0);
  EXPECT_NE(checked.out.find("fluid   125 nodes, 64 cells (4 x 4 x 4), 500 unknowns"), std::string::npos)
      << checked.out;
  EXPECT_FALSE(fs::exists(scratch / "reed.h5"));
  EXPECT_EQ(run(scratch, "reed.json").code, 0);
  EXPECT_TRUE(fs::exists(scratch / "reed.h5"));
}

TEST_F(FbiGen, WritesTheCanopy) {
  fs::copy_file(source / "tests/input/valid/canopy.json", scratch / "canopy.json");
  ASSERT_EQ(run(scratch, "canopy.json").code, 0);
  const fbi::io::CaseHeader header = fbi::io::read_case_header(fbi::Comm(), scratch / "canopy.h5");
  EXPECT_EQ(header.nodes, 523809);
  EXPECT_EQ(header.cells, 491520);
  EXPECT_EQ(header.fibers, 3375);
  EXPECT_EQ(header.fiber_nodes, 13500);
  EXPECT_EQ(header.fiber_elements, 10125);
  EXPECT_TRUE(header.box);
  EXPECT_EQ(header.json, file_text(scratch / "canopy.json"));
  EXPECT_EQ(header.json_name, "canopy.json");
}
