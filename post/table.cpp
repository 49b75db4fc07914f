#include "post/table.hpp"

#include <algorithm>

#include "base/log.hpp"

namespace fbi::post {
namespace {

std::string text_of(const Table::Cell& cell, TableFormat format) {
  if (const std::string* text = std::get_if<std::string>(&cell)) return *text;
  if (const GlobalIndex* number = std::get_if<GlobalIndex>(&cell)) return std::to_string(*number);
  return log::format(format == TableFormat::csv ? "%.17g" : "%.6g", std::get<double>(cell));
}

std::string escaped(const std::string& text, TableFormat format) {
  std::string result;
  if (format == TableFormat::csv && text.find_first_of(",\"\n") != std::string::npos) {
    result = "\"";
    for (const char c : text) result += c == '"' ? "\"\"" : std::string(1, c);
    return result + "\"";
  }
  for (const char c : text) {
    if (format == TableFormat::markdown && c == '|') result += '\\';
    if (format == TableFormat::latex && std::string("_%&#${}").find(c) != std::string::npos) result += '\\';
    result += c;
  }
  return result;
}

using Lines = std::vector<std::vector<std::string>>;  // the columns' names first

std::vector<std::size_t> widths(const Lines& lines) {
  std::vector<std::size_t> width(lines[0].size(), 3);
  for (const auto& line : lines)
    for (std::size_t c = 0; c < line.size(); ++c) width[c] = std::max(width[c], line[c].size());
  return width;
}

std::string padded(const std::string& text, std::size_t width, bool left) {
  const std::string space(width - text.size(), ' ');
  return left ? text + space : space + text;
}

}  // namespace

std::string format_table(const Table& table, TableFormat format) {
  Lines lines(1);
  for (const std::string& name : table.columns) lines[0].push_back(escaped(name, format));
  for (const auto& row : table.rows) {
    lines.emplace_back();
    for (const Table::Cell& cell : row) lines.back().push_back(escaped(text_of(cell, format), format));
  }
  std::vector<bool> left(table.columns.size(), false);  // texts stand left, numbers right
  for (std::size_t c = 0; c < left.size(); ++c)
    left[c] = !table.rows.empty() && std::all_of(table.rows.begin(), table.rows.end(), [c](const auto& row) {
      return std::holds_alternative<std::string>(row[c]);
    });
  const std::vector<std::size_t> width = widths(lines);

  const bool markdown = format == TableFormat::markdown, latex = format == TableFormat::latex,
             csv = format == TableFormat::csv;
  const std::string open = markdown ? "| " : "",
                    between = csv        ? ","
                              : markdown ? " | "
                              : latex    ? " & "
                                         : "  ",
                    close = markdown ? " |"
                            : latex  ? " \\\\"
                                     : "";
  std::string text;
  if (latex) {
    text = "\\begin{tabular}{";
    for (const bool l : left) text += l ? 'l' : 'r';
    text += "}\n\\hline\n";
  }
  for (std::size_t i = 0; i < lines.size(); ++i) {
    std::string line = open;
    for (std::size_t c = 0; c < lines[i].size(); ++c)
      line += (c ? between : "") + (csv ? lines[i][c] : padded(lines[i][c], width[c], left[c]));
    if (format == TableFormat::text) line.erase(line.find_last_not_of(' ') + 1);
    text += line + close + "\n";
    if (i > 0) continue;
    if (markdown) {
      text += "|";
      for (std::size_t c = 0; c < width.size(); ++c)
        text += (left[c] ? " :" : " ") + std::string(width[c] - 1, '-') + (left[c] ? " |" : ": |");
      text += "\n";
    } else if (latex) {
      text += "\\hline\n";
    } else if (format == TableFormat::text) {
      std::size_t total = 2 * (width.size() - 1);
      for (const std::size_t w : width) total += w;
      text += std::string(total, '-') + "\n";
    }
  }
  return latex ? text + "\\hline\n\\end{tabular}\n" : text;
}

std::optional<TableFormat> table_format(const std::string& name) {
  if (name == "text") return TableFormat::text;
  if (name == "csv") return TableFormat::csv;
  if (name == "markdown") return TableFormat::markdown;
  if (name == "latex") return TableFormat::latex;
  return std::nullopt;
}

std::string file_ending(TableFormat format) {
  switch (format) {
    case TableFormat::csv:
      return ".csv";
    case TableFormat::markdown:
      return ".md";
    case TableFormat::latex:
      return ".tex";
    default:
      return ".txt";
  }
}

}  // namespace fbi::post
