/// Heat maps of judged points: one cell a pair of parameters, colored by what a run did there.
#pragma once

#include <string>
#include <vector>

namespace fbi::post {

/// A map as tools/stability writes it: points in rows, two of the columns are the axes.
struct Map {
  std::string title, x_label, y_label;
  std::vector<std::string> x, y;  ///< names of the points on the axes, in the order of their first rows
  /// One cell, at the point (i, j) of the axes.
  struct Cell {
    std::size_t i = 0, j = 0;
    std::string outcome, text;  ///< class that colors the cell; up to three lines of numbers within it
  };
  std::vector<Cell> cells;
};

/// The classes of cells in the order of the key, the best first.
struct Outcome {
  const char* name;
  const char* about;
  const char* color;
};
const std::vector<Outcome>& map_outcomes();

/// Reads a table with lines "# title:", "# x:", "# y:", one line of column names and rows, fields separated by tabs;
/// the columns x, y and outcome are needed, `shown` ("newton mean", "growth" ...) are the lines of text within the
/// cells. Throws Error(file) for a file that is no such table, Error(usage) for columns that it does not have.
Map read_map(const std::string& path, const std::vector<std::string>& shown);

/// Writes BASE.dat and BASE.gp; gnuplot makes BASE.png and BASE.svg. `shown` explains the text of the cells below the
/// axis. Returns the files' paths. Throws Error(file), also when gnuplot is missing or fails.
std::vector<std::string> write_map(const std::string& base, const Map& map, const std::vector<std::string>& shown);

}  // namespace fbi::post
