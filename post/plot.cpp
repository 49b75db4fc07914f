#include "post/plot.hpp"

#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>

#include "base/error.hpp"
#include "base/log.hpp"
#include "io/pending_file.hpp"

namespace fbi::post {

std::string gnuplot_quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? "''" : std::string(1, c);
  return result + "'";
}

void run_gnuplot(const std::string& script) {
  const std::filesystem::path path(script);
  const std::string directory = path.has_parent_path() ? path.parent_path().string() : ".",
                    name = path.filename().string();
  const pid_t child = fork();
  if (child == 0) {
    if (chdir(directory.c_str()) == 0) execlp("gnuplot", "gnuplot", name.c_str(), static_cast<char*>(nullptr));
    _exit(127);
  }
  int status = 0;
  while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (child > 0 && WIFEXITED(status) && WEXITSTATUS(status) == 0) return;
  const bool missing = child < 0 || (WIFEXITED(status) && WEXITSTATUS(status) == 127);
  throw Error(ExitCode::file,
              missing ? "cannot run gnuplot, so there are no pictures; install gnuplot-nox and run: gnuplot " + script
                      : "gnuplot failed on \"" + script + "\"; its message is above, the script can be changed");
}

namespace {

constexpr std::size_t colors = 8;  // of gnuplot; further curves are dashed

// Names of the columns and a block for each curve, separated by two empty lines.
std::string data_of(const Plot& plot) {
  std::string data = "#";
  for (const std::string& column : plot.columns) data += " " + column;
  data += "\n";
  std::vector<Curve> blocks = plot.curves;
  blocks.insert(blocks.end(), plot.guides.begin(), plot.guides.end());
  for (const Curve& curve : blocks) {
    data += "# " + curve.label + "\n";
    for (const std::vector<double>& row : curve.rows) {
      for (std::size_t c = 0; c < row.size(); ++c) data += log::format(c ? " %.17g" : "%.17g", row[c]);
      data += "\n";
    }
    data += "\n\n";
  }
  return data;
}

std::vector<std::string> write_pictures(const std::string& base, const std::string& data, const std::string& script) {
  io::write_text_file(base + ".dat", data);
  io::write_text_file(base + ".gp", script);
  run_gnuplot(base + ".gp");
  return {base + ".dat", base + ".gp", base + ".svg", base + ".png", base + ".pdf"};
}

}  // namespace

std::vector<std::string> write_plot(const std::string& base, const Plot& plot) {
  const std::string name = std::filesystem::path(base).filename().string();
  std::string curves;
  for (std::size_t i = 0; i < plot.curves.size(); ++i)
    curves += std::string(i ? ", \\\n     " : "plot ") + gnuplot_quoted(name + ".dat") + " index " + std::to_string(i) +
              " using 1:" + std::to_string(plot.y_column) + " with " +
              (plot.curves[i].rows.size() < 2 ? "points"
               : plot.log_axes                ? "linespoints pointtype 7"
                                              : "lines") +
              (i < colors ? "" : log::format(" dashtype %zu", i / colors + 1)) + " linewidth 2 title " +
              gnuplot_quoted(plot.curves[i].label) + " noenhanced";
  std::string settings = plot.log_axes ? "set logscale xy\nset format y '%.0e'\n" : "";
  for (std::size_t i = 0; i < plot.guides.size(); ++i) {
    curves += ", \\\n     " + gnuplot_quoted(name + ".dat") + " index " + std::to_string(plot.curves.size() + i) +
              " using 1:2 with lines linewidth 1 linecolor rgb '#707070' notitle";
    const std::vector<double>& last = plot.guides[i].rows.back();
    settings += "set label " + gnuplot_quoted(plot.guides[i].label) +
                log::format(" at first %.9g, first %.9g offset 0.6,0 noenhanced\n", last[0], last[1]);
  }
  const std::string script =
      "# Run it with: gnuplot " + name + ".gp\nset encoding utf8\nset title " + gnuplot_quoted(plot.title) +
      " noenhanced\nset xlabel " + gnuplot_quoted(plot.x_label) + "\nset ylabel " + gnuplot_quoted(plot.y_label) +
      "\n" + settings +
      "set grid\nset key outside below\nset terminal svg size 900,560 font 'sans,16' dynamic background 'white'\n"
      "set output " +
      gnuplot_quoted(name + ".svg") + "\n" + curves +
      "\nset terminal pngcairo size 1350,840 font 'sans,16'\nset output " + gnuplot_quoted(name + ".png") +
      "\nreplot\nset terminal pdfcairo size 18cm,11.2cm font 'sans,12'\nset output " + gnuplot_quoted(name + ".pdf") +
      "\nreplot\nset output\n";
  return write_pictures(base, data_of(plot), script);
}

std::vector<std::string> write_panels(const std::string& base, const std::vector<Plot>& panels) {
  const std::string name = std::filesystem::path(base).filename().string();
  const std::size_t count = panels.size();
  std::string data, drawing = log::format("set multiplot layout %zu,1\n", count);
  std::size_t block = 0;
  for (std::size_t p = 0; p < count; ++p) {
    const Plot& panel = panels[p];
    data += data_of(panel);
    drawing += "set title " + gnuplot_quoted(p == 0 ? panel.title : "") + " noenhanced\nset ylabel " +
               gnuplot_quoted(panel.y_label) + "\nset xlabel " + gnuplot_quoted(p + 1 == count ? panel.x_label : "") +
               "\nset key " + (p + 1 == count ? "outside below\n" : "off\n");
    for (std::size_t i = 0; i < panel.curves.size(); ++i)
      drawing += std::string(i ? ", \\\n     " : "plot ") + gnuplot_quoted(name + ".dat") + " index " +
                 std::to_string(block++) + " using 1:" + std::to_string(panel.y_column) + " with " +
                 (panel.curves[i].rows.size() < 2 ? "points" : "lines") +
                 log::format(" linestyle %zu dashtype %zu", i % colors + 1, i / colors + 1) + " linewidth 2 title " +
                 gnuplot_quoted(panel.curves[i].label) + " noenhanced";
    drawing += "\n";
  }
  drawing += "unset multiplot\n";
  const double height = 0.15 + 0.27 * static_cast<double>(count) + 0.01 * static_cast<double>(panels[0].curves.size());
  std::string script = "# Run it with: gnuplot " + name +
                       ".gp\nset encoding utf8\nset grid\nset lmargin 10\nset rmargin 3\nset yrange [0:*]\n";
  const auto draw = [&](const std::string& terminal, const std::string& ending) {
    script +=
        "set terminal " + terminal + "\nset output " + gnuplot_quoted(name + ending) + "\n" + drawing + "set output\n";
  };
  draw(log::format("svg size 900,%.0f font 'sans,16' dynamic background 'white'", 900.0 * height), ".svg");
  draw(log::format("pngcairo size 1350,%.0f font 'sans,16'", 1350.0 * height), ".png");
  draw(log::format("pdfcairo size 18cm,%.1fcm font 'sans,12'", 18.0 * height), ".pdf");
  return write_pictures(base, data, script);
}

}  // namespace fbi::post
