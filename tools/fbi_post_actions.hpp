/// What the commands of fbi-post do with what was given on the command line.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/types.hpp"
#include "post/render.hpp"

namespace fbi::tools {

/// Options of all commands.
struct Arguments {
  std::vector<std::string> files;
  std::vector<std::string> fibers;
  std::string format = "text";
  std::string directory;
  bool no_plot = false;
  bool quiet = false;
  std::optional<GlobalIndex> step;
  // differences
  std::vector<std::string> fields;
  std::vector<std::string> norms = {"l2"};
  std::optional<double> time;
  std::string on = "fine";
  bool remove_mean = false;
  int points = 3;
  double uncovered = 0.01;
  std::string exact, exact_pressure, reference;
  std::string against_name = "h";
  // histories
  std::vector<std::string> quantities;
  std::optional<double> reference_value, from, length, speed;
  std::string reduce = "last";
  // parts of the flow
  std::vector<double> from_corner, to_corner;
  std::string axis = "y";
  std::optional<Index> bins;
  bool instantaneous = false;
  // three dimensions
  post::View view;
  std::vector<double> camera, range, fiber_range;
  std::string up = "y", quantity = "speed", fiber_quantity = "displacement";
  std::vector<std::string> slices;
  double opacity = 1.0;
  std::optional<double> radius;
  std::vector<int> size;
  bool single = false;
  // maps
  std::vector<std::string> shown;
  // verification
  std::string page = "docs/verification.md";
  // work and precision: a name and its runs
  std::vector<std::vector<std::string>> series;
  std::vector<std::pair<std::string, std::string>> other_references;
};

// Each prints its table and writes its files. Errors: fbi::Error with the exit code.
void tip(const Arguments& arguments);
void picture(const Arguments& arguments);
void info(const Arguments& arguments);
void l2(const Arguments& arguments);
void convergence(const Arguments& arguments);
void energy(const Arguments& arguments);
void forces(const Arguments& arguments);
void iterations(const Arguments& arguments);
void profiles(const Arguments& arguments);
void render(const Arguments& arguments);
void export_vtk(const Arguments& arguments);
void precision(const Arguments& arguments);
void map(const Arguments& arguments);
void verification(const Arguments& arguments);

}  // namespace fbi::tools
