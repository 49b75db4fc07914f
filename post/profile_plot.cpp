/// Table and plot of profiles.
#include <algorithm>
#include <filesystem>

#include "base/log.hpp"
#include "io/pending_file.hpp"
#include "post/plot.hpp"
#include "post/profiles.hpp"

namespace fbi::post {
namespace {

constexpr const char* components[6] = {"xx", "xy", "xz", "yy", "yz", "zz"};

// Curves of columns first ... first + labels.size() - 1 over the height in column 1.
std::string curves(const std::string& data, const std::vector<std::string>& labels, std::size_t first) {
  std::string text;
  for (std::size_t i = 0; i < labels.size(); ++i)
    text += (i ? ", \\\n     " : "plot ") + data + " using " + std::to_string(first + i) + ":1 with lines " +
            log::format("linestyle %zu linewidth 2 title ", i + 1) + gnuplot_quoted(labels[i]) + " noenhanced";
  return text + "\n";
}

}  // namespace

Table profile_table(const Profiles& profiles) {
  const bool means = profiles.averaged_over > 0.0;
  Table table;
  table.columns = {std::string(1, "xyz"[profiles.axis]), profiles.layers ? "area" : "volume"};
  for (const char* axis : {"x", "y", "z"}) table.columns.push_back(std::string("velocity_") + axis);
  table.columns.push_back("pressure");
  for (const char* component : components) table.columns.push_back(std::string("reynolds_") + component);
  for (const char* component : components)
    if (means) table.columns.push_back(std::string("dispersive_") + component);
  for (const ProfileRow& row : profiles.rows) {
    std::vector<Table::Cell>& cells = table.rows.emplace_back();
    for (const double value :
         {row.height, row.measure, row.velocity[0], row.velocity[1], row.velocity[2], row.pressure})
      cells.emplace_back(value);
    for (const double value : row.reynolds) cells.emplace_back(value);
    if (means)
      for (const double value : row.dispersive) cells.emplace_back(value);
  }
  return table;
}

std::vector<std::string> write_profile_plot(const std::string& base, const Profiles& profiles) {
  const Table table = profile_table(profiles);
  const std::string name = std::filesystem::path(base).filename().string(), data_name = gnuplot_quoted(name + ".dat");
  std::string data = "#";
  for (const std::string& column : table.columns) data += " " + column;
  for (const auto& row : table.rows)
    for (std::size_t c = 0; c < row.size(); ++c)
      data += log::format(c ? " %.17g" : "\n%.17g", std::get<double>(row[c]));
  const bool means = profiles.averaged_over > 0.0;
  std::string what = means ? log::format("means over %.6g to time %.6g", profiles.averaged_over, profiles.time)
                           : log::format("at time %.6g", profiles.time);
  std::string settings;
  if (profiles.canopy) {
    settings = log::format(
        "set arrow from graph 0, first %.9g to graph 1, first %.9g nohead dashtype 2 linewidth 1.5 "
        "linecolor rgb '#407040'\n",
        profiles.canopy->current, profiles.canopy->current);
    what += log::format("; dashed: canopy height %.4g", profiles.canopy->current);
  }
  std::vector<std::string> velocity, reynolds, dispersive;
  for (const char* axis : {"x", "y", "z"}) velocity.emplace_back(axis);
  for (const char* component : components) {
    reynolds.emplace_back(component);
    dispersive.emplace_back(component);
  }
  const int panels = means ? 3 : 2;
  std::string drawing = "set multiplot title " + gnuplot_quoted(profiles.run + ", " + what) +
                        " noenhanced\nset ylabel '" + "xyz"[profiles.axis] + "'\n";
  const auto panel = [&](int place, const std::string& title, const std::vector<std::string>& labels, int first) {
    const double left = (place + (place == 0 ? 0.17 : 0.12)) / panels, right = (place + 0.97) / panels;
    drawing += log::format("set lmargin at screen %.4f\nset rmargin at screen %.4f\nset title ", left, right) +
               gnuplot_quoted(title) + " noenhanced\n" +
               log::format("set key at screen %.4f, screen 0.155 center top maxrows 3\n", 0.5 * (left + right)) +
               curves(data_name, labels, static_cast<std::size_t>(first)) + "unset ylabel\n";
  };
  panel(0, "mean velocity", velocity, 3);
  panel(1, means ? "Reynolds: <v_i' v_j'> in time" : "covariance of the velocity in the plane", reynolds, 7);
  if (means) panel(2, "dispersive: covariance of the means in the plane", dispersive, 13);
  drawing += "unset multiplot\nset output\n";
  std::string script = "# Run it with: gnuplot " + name +
                       ".gp\nset encoding utf8\nset grid\nset xtics autofreq rotate by 40 right\nset tmargin at screen "
                       "0.87\nset bmargin at screen 0.26\n" +
                       settings + "set yrange [" +
                       log::format("%.9g:%.9g]\n", profiles.rows.front().height, profiles.rows.back().height);
  if (profiles.rows.size() < 2) script += "set yrange [*:*]\n";
  const double width = means ? 1.5 : 1.0;
  const auto draw = [&](const std::string& terminal, const std::string& ending) {
    script += "set terminal " + terminal + "\nset output " + gnuplot_quoted(name + ending) + "\n" + drawing;
  };
  draw(log::format("svg size %.0f,560 font 'sans,14' dynamic background 'white'", 900 * width), ".svg");
  draw(log::format("pngcairo size %.0f,840 font 'sans,15'", 1200 * width), ".png");
  draw(log::format("pdfcairo size %.0fcm,11.2cm font 'sans,11'", 18 * width), ".pdf");
  io::write_text_file(base + ".dat", data + "\n");
  io::write_text_file(base + ".gp", script);
  run_gnuplot(base + ".gp");
  return {base + ".dat", base + ".gp", base + ".svg", base + ".png", base + ".pdf"};
}

}  // namespace fbi::post
