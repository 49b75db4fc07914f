#include "post/picture.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "base/error.hpp"
#include "base/log.hpp"
#include "io/format.hpp"
#include "io/pending_file.hpp"
#include "post/outputs.hpp"
#include "post/plot.hpp"

namespace fbi::post {
namespace {

using io::File;

// Lines "x y speed" of the plane z = middle, a blank line after each row of nodes; sets the largest speed.
std::string slice(const File& fields, const std::array<std::vector<double>, 3>& box, double& largest) {
  const std::vector<double>&x = box[0], &y = box[1], &z = box[2];
  const double middle = 0.5 * (z.front() + z.back());
  const std::size_t above = std::clamp<std::size_t>(
      static_cast<std::size_t>(std::upper_bound(z.begin(), z.end(), middle) - z.begin()), 1, z.size() - 1);
  const double share = (middle - z[above - 1]) / (z[above] - z[above - 1]);
  const GlobalIndex plane = static_cast<GlobalIndex>(x.size() * y.size());
  const std::vector<double> two =
      fields.read_rows<double>("/fluid/velocity", static_cast<GlobalIndex>(above - 1) * plane, 2 * plane);
  largest = 0.0;
  std::string text = "# x y speed\n";
  for (std::size_t j = 0; j < y.size(); ++j) {
    for (std::size_t i = 0; i < x.size(); ++i) {
      const std::size_t node = 3 * (i + j * x.size()), over = node + 3 * static_cast<std::size_t>(plane);
      double square = 0.0;
      for (int d = 0; d < 3; ++d) {
        const double v = (1 - share) * two[node + d] + share * two[over + d];
        square += v * v;
      }
      largest = std::max(largest, std::sqrt(square));
      text += log::format("%.9g %.9g %.9g\n", x[i], y[j], std::sqrt(square));
    }
    text += "\n";
  }
  return text;
}

// Lines "x y" of the center lines whose first points are nearest to the plane; two blank lines between them, because
// gnuplot would join lines with one blank line between them to a net.
std::string center_lines(const File& mesh, const File& fields, double middle) {
  std::string text = "# x y\n";
  if (!mesh.has("/fibers") || !fields.has("/fibers/position")) return text;
  const std::vector<double> points = fields.read<double>("/fibers/position"),
                            reference = mesh.read<double>("/fibers/reference_dofs");
  const std::vector<GlobalIndex> first_node = mesh.read<GlobalIndex>("/fibers/first_node");
  std::vector<GlobalIndex> first = mesh.read<GlobalIndex>("/fibers/first_point");
  first.push_back(static_cast<GlobalIndex>(points.size() / 3));
  std::vector<double> distance;
  for (const GlobalIndex node : first_node)
    distance.push_back(std::abs(reference[6 * static_cast<std::size_t>(node) + 2] - middle));
  const double nearest = *std::min_element(distance.begin(), distance.end());
  for (std::size_t f = 0; f < distance.size(); ++f) {
    if (distance[f] > nearest + 1e-9 * (1.0 + std::abs(middle))) continue;
    for (GlobalIndex p = first[f]; p < first[f + 1]; ++p)
      text += log::format("%.9g %.9g\n", points[3 * static_cast<std::size_t>(p)],
                          points[3 * static_cast<std::size_t>(p) + 1]);
    text += "\n\n";
  }
  return text;
}

}  // namespace

std::vector<std::string> write_picture(const std::string& base, const Run& run, std::optional<GlobalIndex> step) {
  const io::StepTime output = choose_output(run, {step, std::nullopt});
  const File mesh = io::open_kind(run.paths.mesh(), io::FileKind::mesh);
  const File fields = io::open_kind(run.paths.step(output.step), io::FileKind::step);
  if (!mesh.has("/fluid/box") || !fields.has("/fluid/velocity"))
    throw Error(ExitCode::file, "\"" + run.paths.index + "\" has no velocity in a box; open \"" + run.paths.xdmf +
                                    "\" in ParaView instead");
  const std::array<std::vector<double>, 3> box = {mesh.read<double>("/fluid/box/x"), mesh.read<double>("/fluid/box/y"),
                                                  mesh.read<double>("/fluid/box/z")};
  const double middle = 0.5 * (box[2].front() + box[2].back());
  const double width = box[0].back() - box[0].front(), height = box[1].back() - box[1].front();
  const double flat = std::min(1.0, height / width);  // a flat channel makes a flat picture
  const int pixels = static_cast<int>(1350.0 * std::max(height / width, 0.08)) + 200;
  const std::string name = std::filesystem::path(base).filename().string();
  std::string script = "# Run it with: gnuplot " + name + ".gp\nset encoding utf8\nset title ";
  script +=
      gnuplot_quoted(log::format("%s: speed in the plane z = %g at time %g", run.name.c_str(), middle, output.time));
  script +=
      " noenhanced\nset view map\nset size ratio -1\nunset key\nset xlabel 'x'\nset ylabel 'y'\nset tics "
      "scale 0.4\n";
  script +=
      "set lmargin at screen 0.10\nset rmargin at screen 0.87\nset tmargin at screen 0.85\nset bmargin at screen "
      "0.25\n";
  script += log::format("set xrange [%.9g:%.9g]\nset yrange [%.9g:%.9g]\n", box[0].front(), box[0].back(),
                        box[1].front(), box[1].back());
  if (flat < 0.3) script += log::format("set ytics %.9g\nset format cb '%%.3g'\n", 0.5 * height);
  double largest = 0.0;
  const std::string speeds = slice(fields, box, largest);
  if (largest == 0.0) largest = 1.0;
  script += log::format("set cbrange [0:%.9g]\n", largest);
  if (flat < 0.3) script += log::format("set cbtics %.9g\n", 0.5 * largest);
  script += "set palette defined (0 '#ffffff', 1 '#b5d4e9', 2 '#60a6d1', 3 '#2070b4', 4 '#08306b')\n";
  script += log::format("set terminal pngcairo size 1600,%d font 'sans,16'\nset output ", pixels) +
            gnuplot_quoted(name + ".png") + "\n";
  script += "splot " + gnuplot_quoted(name + ".dat") + " using 1:2:3 with pm3d, \\\n      " +
            gnuplot_quoted(name + ".fibers.dat") + " using 1:2:(0) with lines linewidth 1.5 linecolor rgb '#d94801'\n";
  script += log::format("set terminal svg size 1600,%d font 'sans,16' background 'white'\nset output ", pixels) +
            gnuplot_quoted(name + ".svg") + "\nreplot\nset output\n";
  io::write_text_file(base + ".dat", speeds);
  io::write_text_file(base + ".fibers.dat", center_lines(mesh, fields, middle));
  io::write_text_file(base + ".gp", script);
  run_gnuplot(base + ".gp");
  return {base + ".dat", base + ".fibers.dat", base + ".gp", base + ".png", base + ".svg"};
}

}  // namespace fbi::post
