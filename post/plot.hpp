/// Pictures by gnuplot, with the data and the script beside them so that users can change both.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace fbi::post {

/// One curve of a plot: rows of numbers; the x axis is the first column.
struct Curve {
  std::string label;
  std::vector<std::vector<double>> rows;  ///< shape=(rows,columns)
};

/// Curves over a common x axis; column `y_column` (from 1, the first is x) of each curve is drawn, all columns are in
/// the data.
struct Plot {
  std::string title, x_label, y_label;
  std::vector<std::string> columns;  ///< names, for the head of the data file
  int y_column = 2;
  std::vector<Curve> curves;
  bool log_axes = false;  ///< both axes logarithmic, points joined by lines
  /// Thin gray lines without an entry in the key, such as slope triangles; a label stands beside the last point.
  std::vector<Curve> guides{};
};

/// Writes BASE.dat and BASE.gp and lets gnuplot make BASE.svg, BASE.png and BASE.pdf. Returns the files' paths. Throws
/// Error(file), also when gnuplot is missing or fails (data and script stay).
std::vector<std::string> write_plot(const std::string& base, const Plot& plot);

/// The same for several plots over one x axis, one above the other in one picture: title of the first, x label of the
/// last, the key once, below, with the curves of the last, which all of them should have. The data of all are in one
/// file, one block a curve in the order of the plots. Without logarithmic axes and guides.
std::vector<std::string> write_panels(const std::string& base, const std::vector<Plot>& panels);

/// A text as a gnuplot string.
std::string gnuplot_quoted(const std::string& text);

/// Runs a gnuplot script in its directory. Throws Error(file).
void run_gnuplot(const std::string& script);

}  // namespace fbi::post
