/// The tables of docs/verification.md, from the rows that tests and cases leave behind.
#pragma once

#include <string>
#include <vector>

namespace fbi::post {

/// One row of a table: what tests/record.hpp and fbi-run write, fields separated by tabs.
struct VerificationRow {
  std::string section, id, check, source, reference, ours, error, order, bar, test, labels;
};

/// Rows of all files *.tsv in the folders and the folders below them, in the order of the files' names and of their
/// lines. Throws Error(file) when a folder is not there or holds no rows, and for a line that is not a row.
std::vector<VerificationRow> read_rows(const std::vector<std::string>& folders);

/// The page with every table between `<!-- table: SECTION -->` and `<!-- end of table -->` replaced by the rows of that
/// section, sorted by id (rows without one last), then as read; sections without rows are appended to `empty`. Throws
/// Error(usage) for rows of a section that the page does not have and for markers that do not match; `name` of the page
/// is for the messages.
std::string fill_tables(const std::string& page, const std::string& name, const std::vector<VerificationRow>& rows,
                        std::vector<std::string>& empty);

}  // namespace fbi::post
