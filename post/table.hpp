/// Tables for people and programs.
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "base/types.hpp"

namespace fbi::post {

enum class TableFormat { text, csv, markdown, latex };

/// Rows of texts, whole numbers and numbers under named columns.
struct Table {
  using Cell = std::variant<std::string, GlobalIndex, double>;
  std::vector<std::string> columns;
  std::vector<std::vector<Cell>> rows;  ///< shape=(rows,columns)
};

/// The table as text. Numbers have 6 digits, in CSV 17.
std::string format_table(const Table& table, TableFormat format);

/// "text", "csv", "markdown", "latex"; nothing for another name.
std::optional<TableFormat> table_format(const std::string& name);

/// Ending of a file of that format: ".txt", ".csv", ".md", ".tex".
std::string file_ending(TableFormat format);

}  // namespace fbi::post
