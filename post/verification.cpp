#include "post/verification.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>

#include "base/error.hpp"
#include "base/log.hpp"
#include "io/pending_file.hpp"

namespace fbi::post {
namespace {

namespace fs = std::filesystem;
constexpr std::size_t fields_of_a_row = 11;
constexpr const char* begin_mark = "<!-- table: ";
constexpr const char* begin_end = " -->";
constexpr const char* end_mark = "<!-- end of table -->";

std::vector<std::string> split(const std::string& text, char by) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == by)
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

// A number with so many digits, a text as it is, "|" escaped.
std::string shown(const std::string& field, const char* format) {
  char* end = nullptr;
  const double value = std::strtod(field.c_str(), &end);
  if (!field.empty() && *end == '\0' && std::isfinite(value)) return log::format(format, value);
  std::string text;
  for (const char c : field) text += c == '|' ? "\\|" : std::string(1, c);
  return text;
}

std::string test_cell(const VerificationRow& row) {
  const std::vector<std::string> labels = split(row.labels, ',');
  const bool slow = std::find(labels.begin(), labels.end(), "slow") != labels.end();
  return "`" + row.test + "`" + (slow ? " (slow)" : "");
}

// Digits grouped so that S-B10 follows S-B9.
std::vector<std::string> natural_key(const std::string& text) {
  std::vector<std::string> parts;
  std::string number;
  const auto flush = [&] {
    if (!number.empty()) parts.push_back(std::string(number.size() < 8 ? 8 - number.size() : 0, '0') + number);
    number.clear();
  };
  for (const char c : text) {
    if (c >= '0' && c <= '9') {
      number += c;
    } else {
      flush();
      parts.emplace_back(1, c);
    }
  }
  flush();
  return parts;
}

std::string table_of(std::vector<VerificationRow> rows) {
  std::stable_sort(rows.begin(), rows.end(), [](const VerificationRow& a, const VerificationRow& b) {
    if (a.id.empty() != b.id.empty()) return b.id.empty();
    return natural_key(a.id) < natural_key(b.id);
  });
  std::string text =
      "| case | check | reference | ours | error | order | bar | test |\n|---|---|---|---|---|---|---|---|\n";
  for (const VerificationRow& row : rows) {
    std::string reference = shown(row.reference, "%.8g");
    if (!row.source.empty())
      reference += (reference.empty() ? "" : " (") + shown(row.source, "%s") + (reference.empty() ? "" : ")");
    const std::string cells[] = {row.id,
                                 shown(row.check, "%.8g"),
                                 reference,
                                 shown(row.ours, "%.6g"),
                                 shown(row.error, "%.1e"),
                                 shown(row.order, "%.2f"),
                                 shown(row.bar, "%.3g"),
                                 test_cell(row)};
    text += "|";
    for (const std::string& cell : cells) text += cell.empty() ? " |" : " " + cell + " |";
    text += "\n";
  }
  return text;
}

}  // namespace

std::vector<VerificationRow> read_rows(const std::vector<std::string>& folders) {
  std::vector<fs::path> files;
  for (const std::string& folder : folders) {
    std::error_code error;
    for (auto entry = fs::recursive_directory_iterator(folder, error); !error && entry != fs::end(entry);
         entry.increment(error))
      if (entry->path().extension() == ".tsv") files.push_back(entry->path());
    if (error)
      throw Error(ExitCode::file, "cannot read the folder \"" + folder + "\": " + error.message() +
                                      "; run the tests first: they write build/release/records");
  }
  std::sort(files.begin(), files.end());
  std::vector<VerificationRow> rows;
  for (const fs::path& file : files) {
    int number = 0;
    for (const std::string& line : split(io::read_text_file(file.string()), '\n')) {
      ++number;
      if (line.empty()) continue;
      const std::vector<std::string> f = split(line, '\t');
      if (f.size() != fields_of_a_row)
        throw Error(ExitCode::file, log::format("\"%s\":%d: a row has %zu fields between tabs, not %zu; run the test "
                                                "again that writes it",
                                                file.c_str(), number, fields_of_a_row, f.size()));
      rows.push_back({f[0], f[1], f[2], f[3], f[4], f[5], f[6], f[7], f[8], f[9], f[10]});
    }
  }
  if (rows.empty())
    throw Error(ExitCode::file, "there are no rows (*.tsv) in \"" + folders.front() +
                                    "\"; run the tests first: they write build/release/records");
  return rows;
}

std::string fill_tables(const std::string& page, const std::string& name, const std::vector<VerificationRow>& rows,
                        std::vector<std::string>& empty) {
  std::map<std::string, std::vector<VerificationRow>> sections;
  for (const VerificationRow& row : rows) sections[row.section].push_back(row);
  std::string text, known;
  std::size_t at = 0;
  for (std::size_t begin = page.find(begin_mark); begin != std::string::npos; begin = page.find(begin_mark, at)) {
    const std::size_t title = begin + std::string(begin_mark).size(), close = page.find(begin_end, title),
                      end = page.find(end_mark, begin), next = page.find(begin_mark, title);
    if (close == std::string::npos || end == std::string::npos || (next != std::string::npos && next < end))
      throw Error(ExitCode::usage, "\"" + name + "\": a table begins with " +
                                       page.substr(begin, page.find('\n', begin) - begin) +
                                       " and does not end; add the line " + end_mark);
    const std::string section = page.substr(title, close - title);
    const auto found = sections.find(section);
    known += (known.empty() ? "\"" : ", \"") + section + "\"";
    text += page.substr(at, close + std::string(begin_end).size() - at) + "\n";
    if (found == sections.end()) {
      empty.push_back(section);
      text += "Nothing is recorded.\n";
    } else {
      text += table_of(found->second);
      sections.erase(found);
    }
    text += end_mark;
    at = end + std::string(end_mark).size();
  }
  if (!sections.empty()) {
    const VerificationRow& row = sections.begin()->second.front();
    throw Error(ExitCode::usage, "test \"" + row.test + "\" records rows of the section \"" + row.section +
                                     "\", which \"" + name + "\" does not have (it has " +
                                     (known.empty() ? "none" : known) + "); correct the test, or add the lines " +
                                     begin_mark + row.section + begin_end + " and " + end_mark + " to the page");
  }
  return text + page.substr(at);
}

}  // namespace fbi::post
