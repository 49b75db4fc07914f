/// Rows of the tables in docs/verification.md: what a test measured, against what reference.
#pragma once

#include <mpi.h>

#include <cstdio>
#include <cstdlib>
#include <limits>
#include <string>

namespace fbi::test {

inline constexpr double not_given = std::numeric_limits<double>::quiet_NaN();

/// One row. Numbers that are not given stay empty in the table; `reference_text` and `ours_text` replace numbers where
/// words say more.
struct Record {
  std::string section{};  ///< table: "Fluid", "Fibers: statics", "Fibers: dynamics", "General meshes", "Coupling", ...
  std::string id{};       ///< name in the catalogue of cases, such as "S-B8"; empty for identities
  std::string check{};    ///< what was computed, with the options that matter
  std::string source{};   ///< author and year, "exact solution", "identity", "definition"
  double reference = not_given;
  double ours = not_given;
  std::string reference_text{};
  std::string ours_text{};
  double error = not_given;  ///< relative; computed from reference and ours when both are given
  double order = not_given;  ///< observed order
  std::string bar{};         ///< what the test asks for; "reported" when nothing is asked
};

/// Appends a row to FOLDER/TEST.tsv (environment FBI_RECORDS and FBI_TEST_NAME); nothing without them. The first row of
/// a process begins the file anew. Fields are separated by tabs, numbers have 17 digits. Rank 0 writes.
inline void record(const Record& row) {
  const char* folder = std::getenv("FBI_RECORDS");
  const char* test = std::getenv("FBI_TEST_NAME");
  if (folder == nullptr || test == nullptr) return;
  int started = 0, rank = 0;
  MPI_Initialized(&started);
  if (started != 0) MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  if (rank != 0) return;
  static bool first = true;
  std::FILE* file = std::fopen((std::string(folder) + "/" + test + ".tsv").c_str(), first ? "w" : "a");
  if (file == nullptr) return;
  first = false;
  const auto number = [](double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.17g", value);
    return value == value ? std::string(text) : std::string();
  };
  double error = row.error;
  // Comparisons with < would trap on a number that is not given.
  const bool both = row.ours == row.ours && row.reference == row.reference;
  if (error != error && both && row.reference != 0.0) error = (row.ours - row.reference) / row.reference;
  if (error == error && error < 0) error = -error;
  const char* labels = std::getenv("FBI_TEST_LABELS");
  const std::string line = row.section + "\t" + row.id + "\t" + row.check + "\t" + row.source + "\t" +
                           (row.reference_text.empty() ? number(row.reference) : row.reference_text) + "\t" +
                           (row.ours_text.empty() ? number(row.ours) : row.ours_text) + "\t" + number(error) + "\t" +
                           number(row.order) + "\t" + row.bar + "\t" + test + "\t" + (labels != nullptr ? labels : "") +
                           "\n";
  std::fputs(line.c_str(), file);
  std::fclose(file);
}

}  // namespace fbi::test
