#include "meshgen/scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <unordered_set>

#include "base/error.hpp"
#include "base/log.hpp"
#include "input/suggest.hpp"
#include "meshgen/channel.hpp"
#include "meshgen/cylinder.hpp"
#include "meshgen/gmsh_mesh.hpp"
#include "meshgen/hex_checks.hpp"
#include "meshgen/joints.hpp"
#include "meshgen/mesh_import.hpp"
#include "meshgen/patterns.hpp"
#include "meshgen/periodic.hpp"
#include "meshgen/quality.hpp"

namespace fbi::meshgen {
namespace {

constexpr std::size_t most_lines = 10;

mesh::Box box_of(const mesh::BoxParameters& parameters) {
  mesh::Box box;
  for (int a = 0; a < 3; ++a) {
    box.coordinates[a] =
        graded_line(parameters.origin[a], parameters.size[a], parameters.elements[a], parameters.grading[a]);
  }
  return box;
}

double smallest_cell(const std::vector<double>& x) {
  double smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i + 1 < x.size(); ++i) smallest = std::min(smallest, x[i + 1] - x[i]);
  return smallest;
}

double largest_cell(const std::vector<double>& x) {
  double largest = 0.0;
  for (std::size_t i = 0; i + 1 < x.size(); ++i) largest = std::max(largest, x[i + 1] - x[i]);
  return largest;
}

void check_channel(const mesh::Box& box, const mesh::HexMeshData& mesh, std::vector<std::string>& errors) {
  for (int a = 0; a < 3; ++a) {
    const std::vector<double>& x = box.coordinates[a];
    const double round_off = 1e-12 * std::max({std::abs(x.front()), std::abs(x.back()), x.back() - x.front()});
    if (smallest_cell(x) > round_off) continue;
    errors.push_back(log::format(
        "the channel has cells of no thickness along %c; use fewer elements or a ratio nearer to 1", "xyz"[a]));
  }
  if (errors.empty() && !(smallest_jacobian(mesh) > 1e-6)) {
    errors.push_back("the channel has cells without positive volume");
  }
}

/// What is done about fibers that reach out of the fluid.
struct OutsideRule {
  bool allow = false;     // a warning, not an error
  bool periodic = false;  // some faces are periodic
};

void check_fibers_inside(const mesh::FiberMeshData& fibers, const mesh::Box& box, const OutsideRule& rule,
                         std::vector<std::string>& errors, std::vector<std::string>& warnings) {
  const std::vector<OutsideFiber> outside = fibers_outside(fibers, box);
  std::vector<std::string>& lines = rule.allow ? warnings : errors;
  if (rule.allow && !outside.empty()) {
    warnings.push_back(std::to_string(outside.size()) + " of " + std::to_string(fibers.fiber_count()) +
                       " fibers reach out of the channel");
  }
  for (std::size_t i = 0; i < outside.size(); ++i) {
    if (i == most_lines) {
      lines.push_back("... and " + std::to_string(outside.size() - i) + " more fibers outside the channel");
      break;
    }
    const OutsideFiber& fiber = outside[i];
    std::string line = "fiber \"" + fibers.name[fiber.fiber] + "\" " +
                       (fiber.share >= 1.0 ? "lies outside the channel" : "reaches out of the channel") +
                       log::format(": %.6g beyond %s", fiber.distance, fiber.face.c_str());
    if (fiber.share < 1.0) line += log::format(", %.3g %% of its length", 100 * fiber.share);
    if (!rule.allow)
      line += std::string(rule.periodic ? "; fibers cannot go through periodic faces" : "") +
              "; move it inside, or set \"coupling\": { \"outside\": \"allow\" }";
    lines.push_back(line);
  }
}

void check_fibers_inside(const mesh::FiberMeshData& fibers, const mesh::HexMeshData& mesh, const OutsideRule& rule,
                         std::vector<std::string>& errors, std::vector<std::string>& warnings) {
  if (mesh.box) return check_fibers_inside(fibers, *mesh.box, rule, errors, warnings);
  const std::vector<OutsideFiber> outside = fibers_outside(fibers, mesh);
  std::vector<std::string>& lines = rule.allow ? warnings : errors;
  if (rule.allow && !outside.empty())
    warnings.push_back(std::to_string(outside.size()) + " of " + std::to_string(fibers.fiber_count()) +
                       " fibers reach out of the fluid");
  for (std::size_t i = 0; i < outside.size(); ++i) {
    if (i == most_lines) {
      lines.push_back("... and " + std::to_string(outside.size() - i) + " more fibers outside the fluid");
      break;
    }
    const OutsideFiber& fiber = outside[i];
    std::string line = "fiber \"" + fibers.name[fiber.fiber] + "\" " +
                       (fiber.share >= 1.0 ? "lies outside the fluid" : "reaches out of the fluid") +
                       log::format(": at (%.6g, %.6g, %.6g), about %.3g %% of its length", fiber.place[0],
                                   fiber.place[1], fiber.place[2], 100 * fiber.share);
    if (!rule.allow)
      line += std::string(rule.periodic ? "; fibers cannot go through periodic faces" : "") +
              "; move it inside, or set \"coupling\": { \"outside\": \"allow\" }";
    lines.push_back(line);
  }
}

/// Reads and checks the mesh file of a case; `folder` is that of the case file, with a slash at its end, or empty.
mesh::HexMeshData read_mesh_file(const cases::MeshFile& parameters, const std::string& folder,
                                 std::vector<std::string>& warnings) {
  const std::string& file = parameters.source.file;
  mesh::HexMeshData mesh =
      import_mesh(read_gmsh(file.front() == '/' ? file : folder + file), parameters.source.scale, warnings);
  std::vector<std::string> names;
  for (const auto& [name, condition] : parameters.boundaries) names.push_back(name);
  check_boundary_names(mesh, names);
  return mesh;
}

std::vector<double> radii(const cases::CaseParameters& parameters, const mesh::FiberMeshData& fibers) {
  std::vector<double> radius(fibers.name.size());
  for (std::size_t f = 0; f < radius.size(); ++f) {
    const beam::Section& section = parameters.fibers[fibers.group[f]].physics.section;
    radius[f] = section.radius > 0.0 ? section.radius : std::sqrt(section.area / std::numbers::pi);
  }
  return radius;
}

}  // namespace

Scene make_scene(const cases::CaseParameters& parameters, std::vector<std::string>& warnings,
                 const std::string& folder) {
  Scene scene;
  std::vector<std::string> errors;
  for (std::size_t group = 0; group < parameters.fibers.size(); ++group) {
    try {
      add_group(parameters.fibers[group], static_cast<Index>(group), scene.fibers, warnings);
    } catch (const Error& error) {
      errors.push_back(error.what());
    }
  }
  OutsideRule rule{parameters.coupling.outside == coupling::Outside::allow, false};
  if (parameters.mesh || parameters.channel)
    for (const auto& [name, condition] : parameters.boundaries())
      rule.periodic = rule.periodic || condition.type == fluid::BoundaryType::periodic;
  if (parameters.mesh) {
    scene.fluid = read_mesh_file(*parameters.mesh, folder, warnings);
    check_fibers_inside(scene.fibers, scene.fluid, rule, errors, warnings);
  } else if (parameters.channel && parameters.channel->cylinder) {
    scene.fluid = make_cylinder_channel(parameters.channel->box, *parameters.channel->cylinder);
    if (!(quality_of(scene.fluid).scaled_jacobian > 1e-3))
      errors.push_back("the channel with its cylinder has folded cells; use more cells around the cylinder");
    check_fibers_inside(scene.fibers, scene.fluid, rule, errors, warnings);
  } else if (parameters.channel) {
    const mesh::BoxParameters& box_parameters = parameters.channel->box;
    double cells = 1.0;
    for (int a = 0; a < 3; ++a) cells *= box_parameters.elements[a];
    if (cells > 2e9) throw Error(ExitCode::geometry, "the channel has more than 2e9 cells; use fewer elements");
    const mesh::Box box = box_of(box_parameters);
    scene.fluid = make_channel(box_parameters);
    check_channel(box, scene.fluid, errors);
    check_fibers_inside(scene.fibers, box, rule, errors, warnings);
  }
  if (errors.empty() && scene.fluid.cell_count() > 0) {
    std::map<std::string, std::string> partner;
    for (const auto& [name, condition] : parameters.boundaries())
      if (condition.type == fluid::BoundaryType::periodic) partner[name] = condition.with;
    match_periodic(partner, scene.fluid);
  }
  if (!errors.empty()) {
    std::string all;
    for (const std::string& line : errors) all += (all.empty() ? "" : "\n") + line;
    throw Error(ExitCode::geometry, all);
  }
  add_joints(parameters.joints, scene.fibers);
  if (scene.fibers.fiber_count() > 1) {
    const Crossings crossings = crossing_fibers(scene.fibers, radii(parameters, scene.fibers));
    if (crossings.pairs + crossings.coincident > 0) {
      std::string line = std::to_string(crossings.pairs) + (crossings.pairs == 1 ? " pair of fibers touches or crosses"
                                                                                 : " pairs of fibers touch or cross");
      if (crossings.coincident > 0) line += ", " + std::to_string(crossings.coincident) + " coincide";
      line += " (for example \"" + scene.fibers.name[crossings.example[0]] + "\" and \"" +
              scene.fibers.name[crossings.example[1]] + "\"); there is no contact: they pass through each other";
      warnings.push_back(line);
    }
  }
  return scene;
}

void check_probes(const cases::Output& output, const mesh::FiberMeshData& fibers) {
  const std::unordered_set<std::string> names(fibers.name.begin(), fibers.name.end());
  std::string all;
  for (std::size_t i = 0; i < output.probes.size(); ++i) {
    const std::string& name = output.probes[i].fiber;
    if (name.empty() || names.count(name) > 0) continue;
    std::string hint = input::did_you_mean(name, fibers.name);
    if (hint.empty()) hint = "; the fibers are \"" + fibers.name.front() + "\" to \"" + fibers.name.back() + "\"";
    if (!all.empty()) all += "\n";
    all.append("output.probes[")
        .append(std::to_string(i))
        .append("].fiber: there is no fiber \"")
        .append(name)
        .append("\"");
    all += hint;
  }
  if (!all.empty()) throw Error(ExitCode::usage, all);
}

std::string summary(const cases::CaseParameters& parameters, const Scene& scene) {
  std::string text;
  const auto line = [&](const std::string& more) { text += (text.empty() ? "" : "\n") + more; };
  double largest_h = 0.0;
  if (scene.fluid.cell_count() > 0 && !scene.fluid.box && (parameters.mesh || parameters.channel->cylinder)) {
    const Quality quality = quality_of(scene.fluid);
    largest_h = quality.largest_edge;
    line(log::format("fluid   %lld nodes, %lld cells, %lld unknowns", static_cast<long long>(scene.fluid.node_count()),
                     static_cast<long long>(scene.fluid.cell_count()),
                     static_cast<long long>(4 * scene.fluid.node_count())));
    line(log::format("cells   edges %.4g...%.4g, volume %.6g, smallest scaled Jacobian %.3g", quality.smallest_edge,
                     quality.largest_edge, quality.volume, quality.scaled_jacobian));
    std::string sets;
    for (const auto& [name, faces] : scene.fluid.faces)
      sets += (sets.empty() ? "" : ", ") + name + " " + std::to_string(faces.size());
    line("faces   " + sets);
  } else if (scene.fluid.cell_count() > 0) {
    const mesh::Box box = scene.fluid.box ? *scene.fluid.box : box_of(parameters.channel->box);
    const std::array<Index, 3> cells = box.cells();
    line(log::format("fluid   %lld nodes, %lld cells (%d x %d x %d), %lld unknowns",
                     static_cast<long long>(scene.fluid.node_count()), static_cast<long long>(scene.fluid.cell_count()),
                     cells[0], cells[1], cells[2], static_cast<long long>(4 * scene.fluid.node_count())));
    std::string sizes = "cells   h =";
    for (int a = 0; a < 3; ++a) {
      const double low = smallest_cell(box.coordinates[a]), high = largest_cell(box.coordinates[a]);
      largest_h = std::max(largest_h, high);
      sizes += (a > 0 ? " x " : " ") +
               (high - low < 1e-9 * high ? log::format("%.4g", high) : log::format("%.4g...%.4g", low, high));
    }
    line(sizes);
  }
  if (!scene.fluid.periodic.empty())
    line(log::format("faces   periodic: %lld nodes carry the unknowns of others",
                     static_cast<long long>(scene.fluid.periodic.size())));
  const GlobalIndex fibers = scene.fibers.fiber_count();
  if (fibers > 0) {
    const long long nodes = scene.fibers.first_node.back();
    line(log::format("fibers  %lld, %lld elements, %lld unknowns", static_cast<long long>(fibers),
                     static_cast<long long>(scene.fibers.element_length.size()), 6 * nodes));
    double thinnest = std::numeric_limits<double>::infinity(), thickest = 0.0;  // of those with a section
    for (const double radius : radii(parameters, scene.fibers)) {
      if (radius > 0.0) thinnest = std::min(thinnest, radius);
      thickest = std::max(thickest, radius);
    }
    if (thickest > 0.0) {
      const std::string diameters = thickest - thinnest < 1e-9 * thickest
                                        ? log::format("diameter %.4g", 2 * thickest)
                                        : log::format("diameters %.4g to %.4g", 2 * thinnest, 2 * thickest);
      line("        " + diameters +
           (largest_h > 0.0 ? log::format(", largest h / diameter = %.3g", largest_h / (2 * thinnest)) : ""));
    }
  }
  return text;
}

}  // namespace fbi::meshgen
