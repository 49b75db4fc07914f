#include "io/history.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <filesystem>

#include "base/error.hpp"
#include "base/log.hpp"
#include "io/pending_file.hpp"

namespace fbi::io {
namespace {

std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields;
  std::size_t begin = 0;
  for (std::size_t comma = line.find(','); comma != std::string::npos; comma = line.find(',', begin)) {
    fields.push_back(line.substr(begin, comma - begin));
    begin = comma + 1;
  }
  fields.push_back(line.substr(begin));
  return fields;
}

constexpr const char* unit_mark = "# units: ";
constexpr const char* failure_mark = "# failed: ";
constexpr const char* work_mark = "# work: ";

// What follows the mark at the begin of a line; nothing for another line.
std::optional<std::string> marked(const std::string& line, const std::string& mark) {
  if (line.compare(0, mark.size(), mark) != 0) return std::nullopt;
  return line.substr(mark.size());
}

// Calls `take(line)` for every complete line; a last line without its end is left out.
template <class Take>
void each_line(const std::string& text, Take take) {
  std::size_t begin = 0;
  for (std::size_t end = text.find('\n'); end != std::string::npos; end = text.find('\n', begin)) {
    take(text.substr(begin, end - begin));
    begin = end + 1;
  }
}

std::string joined(const std::vector<HistoryColumn>& columns, std::string HistoryColumn::*part) {
  std::string line;
  for (const HistoryColumn& column : columns) line += (line.empty() ? "" : ",") + column.*part;
  return line;
}

// The rows of an older file up to `step`, each with its line end.
std::string kept_rows(const std::string& path, const std::string& names, GlobalIndex step) {
  std::string rows;
  bool header_seen = false;
  each_line(read_text_file(path), [&](const std::string& line) {
    if (line.empty() || line[0] == '#') return;
    if (!header_seen) {
      header_seen = true;
      if (line != names)
        throw Error(ExitCode::file,
                    "\"" + path + "\" has other columns than this run; move it away or run the case from the start");
      return;
    }
    if (std::strtod(line.c_str(), nullptr) <= static_cast<double>(step)) rows += line + "\n";
  });
  return rows;
}

}  // namespace

const std::vector<HistoryColumn>& standard_history_columns() {
  static const std::vector<HistoryColumn> columns = {{"step", "-"},        {"time", "time"},
                                                     {"dt", "time"},       {"newton", "-"},
                                                     {"krylov", "-"},      {"coupling_iterations", "-"},
                                                     {"evaluations", "-"}, {"residual", "-"},
                                                     {"cfl", "-"},         {"constraint_violation", "-"},
                                                     {"wall_seconds", "s"}};
  return columns;
}

History::History(const Comm& comm, const std::string& path, const std::string& title,
                 const std::vector<HistoryColumn>& columns, std::optional<GlobalIndex> restart_step)
    : comm_(comm), path_(path), columns_(columns.size()) {
  std::string problem;
  if (comm_.rank() == 0) try {
      const std::string names = joined(columns, &HistoryColumn::name);
      std::string text = "# " + title + "\n" + unit_mark + joined(columns, &HistoryColumn::unit) + "\n" + names + "\n";
      if (restart_step && std::filesystem::exists(path_)) text += kept_rows(path_, names, *restart_step);
      write_text_file(path_, text);
      descriptor_ = open(path_.c_str(), O_WRONLY | O_APPEND | O_CLOEXEC);
      if (descriptor_ < 0) throw_write_error(path_, errno);
    } catch (const Error& error) {
      problem = error.what();
    }
  agree_on_error(comm_, ExitCode::file, problem);
}

History::~History() {
  if (descriptor_ >= 0) close(descriptor_);
}

void History::write(const std::vector<double>& row) {
  std::string problem;
  if (comm_.rank() == 0) try {
      if (row.size() != columns_) throw std::logic_error("a history row must have one number per column");
      std::string line;
      for (std::size_t c = 0; c < row.size(); ++c) line += log::format(c ? ",%.17g" : "%.17g", row[c]);
      append(line + "\n");
    } catch (const std::exception& error) {
      problem = error.what();
    }
  agree_on_error(comm_, ExitCode::file, problem);
}

void History::append(const std::string& line) {
  // A write that falls short does not say why; the next one does.
  for (std::size_t done = 0; done < line.size();) {
    const ssize_t written = ::write(descriptor_, line.data() + done, line.size() - done);
    if (written < 0 && errno != EINTR) throw_write_error(path_, errno);
    if (written == 0) throw_write_error(path_, ENOSPC);
    if (written > 0) done += static_cast<std::size_t>(written);
  }
}

void History::write_failure(const std::string& reason) {
  std::string line = failure_mark + reason;
  std::replace(line.begin(), line.end(), '\n', ' ');
  append_on_root(line + "\n");
}

void History::write_work(const std::vector<Counted>& work) {
  std::string text;
  for (const Counted& count : work) text += work_mark + count.what + " = " + std::to_string(count.number) + "\n";
  append_on_root(text);
}

void History::append_on_root(const std::string& text) {
  std::string problem;
  if (comm_.rank() == 0) try {
      append(text);
    } catch (const std::exception& error) {
      problem = error.what();
    }
  agree_on_error(comm_, ExitCode::file, problem);
}

int HistoryTable::column(const std::string& name) const {
  const auto at = std::find(columns.begin(), columns.end(), name);
  return at == columns.end() ? -1 : static_cast<int>(at - columns.begin());
}

HistoryTable read_history(const std::string& path) {
  HistoryTable table;
  int number = 0;
  each_line(read_text_file(path), [&](const std::string& line) {
    ++number;
    if (const auto units = marked(line, unit_mark)) table.units = split(*units);
    if (const auto failure = marked(line, failure_mark)) table.failure = *failure;
    if (const auto work = marked(line, work_mark)) {
      const std::size_t sign = work->rfind(" = ");
      if (sign != std::string::npos)
        table.work.push_back({work->substr(0, sign), std::strtoll(work->c_str() + sign + 3, nullptr, 10)});
    }
    if (line.empty() || line[0] == '#') return;
    const std::vector<std::string> fields = split(line);
    if (table.columns.empty()) {
      table.columns = fields;
      return;
    }
    std::vector<double> row;
    for (const std::string& field : fields) {
      char* end = nullptr;
      row.push_back(std::strtod(field.c_str(), &end));
      if (field.empty() || *end != '\0') row.clear();
      if (row.empty()) break;
    }
    if (row.size() != table.columns.size())
      throw Error(ExitCode::file,
                  log::format("\"%s\":%d: the row does not have one number for each of the %zu columns; cut it "
                              "or run the case again",
                              path.c_str(), number, table.columns.size()));
    table.rows.push_back(std::move(row));
  });
  if (table.columns.empty())
    throw Error(ExitCode::file,
                "\"" + path + "\" is not a history: it has no line of column names; give the NAME.run.csv of a run");
  table.units.resize(table.columns.size(), "-");
  return table;
}

}  // namespace fbi::io
