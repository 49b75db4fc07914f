/// What tests of fbi-post share.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <string>

#include "io/pending_file.hpp"
#include "post/table.hpp"
#include "unit/io/scratch.hpp"

namespace fbi::test {

/// Exit code of fbi-post with these arguments in a scratch folder; what it prints goes to `output`.
inline int run_fbi_post(const Scratch& scratch, const std::string& arguments, std::string& output) {
  const std::string command = "cd '" + scratch.path() + "' && '" FBI_BIN_DIR "/fbi-post' " + arguments + " > '" +
                              scratch.path() + "/output' 2>&1";
  const int status = std::system(command.c_str());
  output = io::read_text_file(scratch / "output");
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// The cell of a row under a column.
inline post::Table::Cell cell(const post::Table& table, std::size_t row, const std::string& column) {
  for (std::size_t c = 0; c < table.columns.size(); ++c)
    if (table.columns[c] == column) return table.rows.at(row).at(c);
  ADD_FAILURE() << "no column " << column;
  return std::string();
}

}  // namespace fbi::test
