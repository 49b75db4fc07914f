#include "post/map.hpp"

#include <algorithm>
#include <filesystem>

#include "base/error.hpp"
#include "base/log.hpp"
#include "io/pending_file.hpp"
#include "post/plot.hpp"

namespace fbi::post {
namespace {

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == separator)
      parts.emplace_back();
    else
      parts.back() += c;
  }
  return parts;
}

/// Position of a name in the list, added at its end when it is new.
std::size_t place_of(const std::string& name, std::vector<std::string>& names) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) names.push_back(name);
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

std::string tics(const std::vector<std::string>& names) {
  std::string text;
  for (std::size_t k = 0; k < names.size(); ++k)
    text += (k ? ", " : "") + gnuplot_quoted(names[k]) + " " + std::to_string(k);
  return text;
}

std::string joined(const std::vector<std::string>& words, const char* separator) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : separator) + word;
  return text;
}

}  // namespace

const std::vector<Outcome>& map_outcomes() {
  static const std::vector<Outcome> outcomes = {{"stable", "stable", "#b7dfc4"},
                                                {"rough", "stable, pressure rough", "#c9d7f0"},
                                                {"alternating", "alternating from step to step", "#fbe29a"},
                                                {"growing", "growing", "#f39b5f"},
                                                {"failed", "ended early", "#c8506b"}};
  return outcomes;
}

Map read_map(const std::string& path, const std::vector<std::string>& shown) {
  Map map;
  std::vector<std::string> columns;
  const auto column = [&](const std::string& name, ExitCode code) {
    const auto found = std::find(columns.begin(), columns.end(), name);
    if (found == columns.end())
      throw Error(code, "\"" + path + "\" has no column \"" + name + "\"; there are: " + joined(columns, ", "));
    return static_cast<std::size_t>(found - columns.begin());
  };
  for (const std::string& line : split(io::read_text_file(path), '\n')) {
    const std::pair<const char*, std::string*> heads[] = {
        {"# title: ", &map.title}, {"# x: ", &map.x_label}, {"# y: ", &map.y_label}};
    for (const auto& [head, text] : heads)
      if (line.rfind(head, 0) == 0) *text = line.substr(std::string(head).size());
    if (line.empty() || line[0] == '#') continue;
    const std::vector<std::string> fields = split(line, '\t');
    if (columns.empty()) {
      columns = fields;
      for (const char* name : {"x", "y", "outcome"}) column(name, ExitCode::file);
      for (const std::string& name : shown) column(name, ExitCode::usage);
      continue;
    }
    if (fields.size() != columns.size())
      throw Error(ExitCode::file, "\"" + path + "\": a row has " + std::to_string(fields.size()) + " fields, not " +
                                      std::to_string(columns.size()) + ": " + line);
    Map::Cell cell{place_of(fields[column("x", ExitCode::file)], map.x),
                   place_of(fields[column("y", ExitCode::file)], map.y), fields[column("outcome", ExitCode::file)], ""};
    if (std::none_of(map_outcomes().begin(), map_outcomes().end(),
                     [&](const Outcome& outcome) { return outcome.name == cell.outcome; }))
      throw Error(ExitCode::file, "\"" + path + "\": unknown outcome \"" + cell.outcome + "\"");
    std::vector<std::string> lines;
    for (const std::string& name : shown) lines.push_back(fields[column(name, ExitCode::usage)]);
    cell.text = joined(lines, "\\n");
    map.cells.push_back(std::move(cell));
  }
  if (map.cells.empty()) throw Error(ExitCode::file, "\"" + path + "\" holds no points of a map");
  return map;
}

std::vector<std::string> write_map(const std::string& base, const Map& map, const std::vector<std::string>& shown) {
  const std::string name = std::filesystem::path(base).filename().string(), data_name = gnuplot_quoted(name + ".dat");
  // One block for each class that occurs, one for the texts of all.
  std::string data = "# x y left right bottom top\n", drawing;
  std::size_t block = 0;
  for (const Outcome& outcome : map_outcomes()) {
    std::string rows;
    for (const Map::Cell& cell : map.cells)
      if (cell.outcome == outcome.name)
        rows += log::format("%zu %zu %g %g %g %g\n", cell.i, cell.j, static_cast<double>(cell.i) - 0.5,
                            static_cast<double>(cell.i) + 0.5, static_cast<double>(cell.j) - 0.5,
                            static_cast<double>(cell.j) + 0.5);
    if (rows.empty()) continue;
    data += std::string("# ") + outcome.name + "\n" + rows + "\n\n";
    drawing += (block > 0 ? ", \\\n     " : "plot ") + data_name + " index " + std::to_string(block) +
               " using 1:2:3:4:5:6 with boxxyerror fillstyle solid border linecolor rgb 'white' fillcolor rgb " +
               gnuplot_quoted(outcome.color) + " title " + gnuplot_quoted(outcome.about);
    ++block;
  }
  data += "# x y text\n";
  for (const Map::Cell& cell : map.cells) data += log::format("%zu %zu \"", cell.i, cell.j) + cell.text + "\"\n";
  if (!shown.empty())
    drawing += ", \\\n     " + data_name + " index " + std::to_string(block) + " using 1:2:3 with labels offset 0," +
               log::format("%g", 0.47 * static_cast<double>(shown.size() - 1)) +
               " font ',12' textcolor rgb '#202020' noenhanced notitle";
  const std::size_t widest = std::max_element(map.y.begin(), map.y.end(), [](const auto& a, const auto& b) {
                               return a.size() < b.size();
                             })->size();
  // Pixels: names of the rows and the label of their axis, the cells, the key.
  const double left = 85.0 + 11.5 * static_cast<double>(widest), right = 390.0;
  const double width = left + 94.0 * static_cast<double>(map.x.size()) + right,
               height = 170.0 + 70.0 * static_cast<double>(map.y.size());
  std::string about = gnuplot_quoted(map.x_label);
  if (!shown.empty()) about += ".\"\\n\"." + gnuplot_quoted("in the cells: " + joined(shown, ", "));
  std::string script =
      "# Run it with: gnuplot " + name + ".gp\nset encoding utf8\nset title " + gnuplot_quoted(map.title) +
      " noenhanced\nset xlabel " + about + " noenhanced\nset ylabel " + gnuplot_quoted(map.y_label) +
      log::format(" offset %.1f,0", 0.1 * static_cast<double>(widest)) + " noenhanced\nset xtics (" + tics(map.x) +
      ") scale 0 noenhanced\nset ytics (" + tics(map.y) + ") scale 0 noenhanced\n" +
      log::format("set lmargin at screen %.4f\nset rmargin at screen %.4f\n", left / width, 1.0 - right / width) +
      log::format("set xrange [-0.5:%g]\nset yrange [-0.5:%g]\n", static_cast<double>(map.x.size()) - 0.5,
                  static_cast<double>(map.y.size()) - 0.5) +
      log::format("set key at screen %.4f, graph 1 left top vertical Left reverse samplen 2 spacing 1.3\n",
                  1.0 - (right - 20.0) / width) +
      "unset border\n";
  script +=
      log::format("set terminal pngcairo size %.0f,%.0f font 'sans,15'\nset output ", width, height) +
      gnuplot_quoted(name + ".png") + "\n" + drawing +
      log::format("\nset terminal svg size %.0f,%.0f font 'sans,15' background 'white'\nset output ", width, height) +
      gnuplot_quoted(name + ".svg") + "\nreplot\nset output\n";
  io::write_text_file(base + ".dat", data);
  io::write_text_file(base + ".gp", script);
  run_gnuplot(base + ".gp");
  return {base + ".dat", base + ".gp", base + ".png", base + ".svg"};
}

}  // namespace fbi::post
