#include "meshgen/mesh_import.hpp"

#include <algorithm>
#include <numeric>
#include <tuple>
#include <unordered_map>

#include "base/error.hpp"
#include "base/log.hpp"
#include "fem/hex8.hpp"
#include "input/suggest.hpp"
#include "meshgen/hex_checks.hpp"

namespace fbi::meshgen {
namespace {

constexpr std::size_t most_examples = 5;

using Key = std::array<GlobalIndex, 4>;

std::string count_text(GlobalIndex count, const std::string& one, const std::string& many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

void check_elements(const FileMesh& file, std::vector<std::string>& errors) {
  for (const auto& [name, count] : file.other_elements) {
    const bool hexahedron = name.find("Hexahedron") != std::string::npos;
    errors.push_back(
        "the mesh has " + count_text(count, "element", "elements") + " of type \"" + name +
        "\", but only hexahedra with 8 nodes are computed on; " +
        (hexahedron
             ? "set Mesh.ElementOrder = 1 in gmsh and mesh again"
             : "in gmsh, extrude with Layers and Recombine, or use Transfinite Surface and Volume with Recombine "
               "Surface, or Mesh.SubdivisionAlgorithm = 2, and mesh again"));
  }
  if (file.cells.empty() && errors.empty())
    errors.push_back("the mesh has no volume elements; make them with gmsh -3, and name the fluid by Physical Volume");
  if (file.surfaces.empty())
    errors.push_back(
        std::string("the mesh has no named surfaces") + (file.unnamed_surfaces > 0 ? ", only numbered ones" : "") +
        "; add for example Physical Surface(\"inlet\") = {1}; and Physical Volume(\"fluid\") = {1}; in gmsh");
}

/// Nodes in the order of their tags, without those of no cell; cells in the order of theirs.
mesh::HexMeshData number_anew(const FileMesh& file, double scale, std::unordered_map<GlobalIndex, GlobalIndex>& number,
                              std::vector<GlobalIndex>& cell_tags, GlobalIndex& twice) {
  mesh::HexMeshData mesh;
  std::vector<std::size_t> order(file.cell_tags.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return file.cell_tags[a] < file.cell_tags[b]; });
  std::vector<std::size_t> kept;
  for (const std::size_t cell : order) {
    if (!kept.empty() && file.cell_tags[kept.back()] == file.cell_tags[cell])
      ++twice;  // of two physical volumes
    else
      kept.push_back(cell);
  }
  for (const std::size_t cell : kept)
    for (int a = 0; a < 8; ++a) number.emplace(file.cells[8 * cell + a], -1);
  std::vector<std::size_t> nodes(file.node_tags.size());
  std::iota(nodes.begin(), nodes.end(), std::size_t{0});
  std::sort(nodes.begin(), nodes.end(),
            [&](std::size_t a, std::size_t b) { return file.node_tags[a] < file.node_tags[b]; });
  GlobalIndex next = 0;
  for (const std::size_t node : nodes) {
    const auto found = number.find(file.node_tags[node]);
    if (found == number.end() || found->second >= 0) continue;
    found->second = next++;
    for (int d = 0; d < 3; ++d) mesh.nodes.push_back(scale * file.nodes[3 * node + d]);
  }
  for (const std::size_t cell : kept) {
    cell_tags.push_back(file.cell_tags[cell]);
    for (int a = 0; a < 8; ++a) mesh.cells.push_back(number.at(file.cells[8 * cell + a]));
  }
  return mesh;
}

std::string examples(const mesh::HexMeshData& mesh, const std::vector<GlobalIndex>& cells,
                     const std::vector<GlobalIndex>& cell_tags) {
  std::string text;
  for (std::size_t i = 0; i < cells.size() && i < most_examples; ++i)
    text += (i > 0 ? ", " : "") + std::string("element ") + std::to_string(cell_tags[cells[i]]) + " at " +
            place_of(mesh, cells[i]);
  return text + (cells.size() > most_examples ? ", ..." : "");
}

void check_shape(const mesh::HexMeshData& mesh, const std::vector<GlobalIndex>& cell_tags,
                 std::vector<std::string>& errors) {
  const Quality quality = quality_of(mesh);
  if (!quality.inverted.empty())
    errors.push_back(count_text(static_cast<GlobalIndex>(quality.inverted.size()), "cell is", "cells are") +
                     " folded (the Jacobian is not positive at a corner or a Gauss point): " +
                     examples(mesh, quality.inverted, cell_tags) +
                     "; mesh again with smoother or more even blocks (in gmsh: Mesh.Smoothing, other Transfinite "
                     "progressions)");
  const std::vector<std::array<GlobalIndex, 2>> twins = coincident_nodes(mesh, quality.smallest_edge);
  if (!twins.empty()) {
    const double* x = &mesh.nodes[3 * twins.front()[0]];
    errors.push_back(log::format(
        "%s at the place of another node, the first at (%.6g, %.6g, %.6g): blocks that touch do "
        "not share their nodes; use Coherence (or BooleanFragments) before meshing, or Coherence "
        "Mesh after it",
        count_text(static_cast<GlobalIndex>(twins.size()), "node lies", "nodes lie").c_str(), x[0], x[1], x[2]));
  }
  const std::vector<GlobalIndex> parts = connected_parts(mesh);
  if (parts.size() > 1 && twins.empty())
    errors.push_back("the mesh consists of " + std::to_string(parts.size()) + " parts that do not touch: " +
                     examples(mesh, parts, cell_tags) + "; join them, or compute them one by one");
}

void name_faces(const FileMesh& file, const std::unordered_map<GlobalIndex, GlobalIndex>& number,
                mesh::HexMeshData& mesh, std::vector<std::string>& errors) {
  struct Side {
    Key nodes;
    mesh::Face face;
    const std::string* name;
  };
  std::vector<Side> sides;
  for (const mesh::Face& face : boundary_faces(mesh)) {
    Side side{{}, face, nullptr};
    for (int a = 0; a < 4; ++a) side.nodes[a] = mesh.cells[8 * face.cell + fem::hex8_faces[face.face][a]];
    std::sort(side.nodes.begin(), side.nodes.end());
    sides.push_back(side);
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.nodes < b.nodes; });
  for (const auto& [name, surface] : file.surfaces) {
    mesh.faces[name];
    GlobalIndex strange = 0, shared = 0;
    const std::string* other = nullptr;
    std::string where;
    for (std::size_t q = 0; q + 3 < surface.quadrangles.size(); q += 4) {
      Key key{};
      for (int a = 0; a < 4; ++a) {
        const auto found = number.find(surface.quadrangles[q + a]);
        key[a] = found == number.end() ? -1 : found->second;
      }
      std::sort(key.begin(), key.end());
      const auto side =
          std::lower_bound(sides.begin(), sides.end(), key, [](const Side& s, const Key& k) { return s.nodes < k; });
      if (side == sides.end() || side->nodes != key) {
        if (strange++ == 0 && key[0] >= 0) {
          const double* x = &mesh.nodes[3 * key[0]];
          where = log::format(", the first at (%.6g, %.6g, %.6g)", x[0], x[1], x[2]);
        }
      } else if (side->name != nullptr && *side->name != name) {
        ++shared;
        other = side->name;
      } else if (side->name == nullptr) {
        side->name = &name;
      }
    }
    strange += surface.others;
    if (strange > 0)
      errors.push_back("surface \"" + name + "\": " + count_text(strange, "face is", "faces are") +
                       " not on the boundary of the fluid" + where +
                       "; name boundary surfaces only, and mesh volumes and surfaces in one go (gmsh -3)");
    if (shared > 0)
      errors.push_back("surface \"" + name + "\": " + count_text(shared, "face belongs", "faces belong") + " to \"" +
                       *other + "\" too; give every surface one name");
  }
  GlobalIndex nameless = 0;
  std::string where;
  std::vector<const Side*> named;
  for (const Side& side : sides) {
    if (side.name != nullptr) {
      named.push_back(&side);
      continue;
    }
    if (nameless++ < static_cast<GlobalIndex>(most_examples)) {
      Vec3 center = Vec3::Zero();
      for (const GlobalIndex node : side.nodes) center += 0.25 * Eigen::Map<const Vec3>(&mesh.nodes[3 * node]);
      where += (where.empty() ? "" : ", ") + log::format("(%.6g, %.6g, %.6g)", center[0], center[1], center[2]);
    }
  }
  if (nameless > 0)
    errors.push_back(count_text(nameless, "boundary face has", "boundary faces have") + " no name: around " + where +
                     (nameless > static_cast<GlobalIndex>(most_examples) ? ", ..." : "") +
                     "; add their surfaces to a Physical Surface(\"NAME\") in gmsh");
  for (const Side* side : named) mesh.faces[*side->name].push_back(side->face);
  for (auto& [name, faces] : mesh.faces)
    std::sort(faces.begin(), faces.end(), [](const mesh::Face& a, const mesh::Face& b) {
      return std::tie(a.cell, a.face) < std::tie(b.cell, b.face);
    });
}

void throw_all(const std::vector<std::string>& errors) {
  if (errors.empty()) return;
  std::string all;
  for (const std::string& line : errors) all += (all.empty() ? "" : "\n") + line;
  throw Error(ExitCode::geometry, all);
}

}  // namespace

mesh::HexMeshData import_mesh(const FileMesh& file, double scale, std::vector<std::string>& warnings) {
  std::vector<std::string> errors;
  for (const auto& [name, surface] : file.surfaces)
    if (name.find('/') != std::string::npos || name == "." || name == "..")
      errors.push_back("surface \"" + name + "\": this name cannot be used; choose one without \"/\"");
  check_elements(file, errors);
  throw_all(errors);
  std::unordered_map<GlobalIndex, GlobalIndex> number;
  std::vector<GlobalIndex> cell_tags;
  GlobalIndex twice = 0;
  mesh::HexMeshData mesh = number_anew(file, scale, number, cell_tags, twice);
  if (static_cast<GlobalIndex>(number.size()) != mesh.node_count())
    throw Error(ExitCode::geometry, "some cells name nodes that the file does not have; mesh again");
  if (twice > 0)
    warnings.push_back(count_text(twice, "cell belongs", "cells belong") + " to two physical volumes; taken once");
  if (const GlobalIndex flipped = flip_left_handed(mesh); flipped > 0)
    warnings.push_back(count_text(flipped, "cell was", "cells were") + " left-handed and turned over");
  check_shape(mesh, cell_tags, errors);
  name_faces(file, number, mesh, errors);
  throw_all(errors);
  recognise_box(mesh);
  return mesh;
}

void check_boundary_names(const mesh::HexMeshData& mesh, const std::vector<std::string>& names) {
  std::vector<std::string> known;
  for (const auto& [name, faces] : mesh.faces) known.push_back(name);
  std::string all;
  const auto line = [&](const std::string& text) { all += (all.empty() ? "" : "\n") + text; };
  std::vector<std::string> misspelt;
  for (const std::string& name : names) {
    if (std::find(known.begin(), known.end(), name) != known.end()) continue;
    std::string hint = input::did_you_mean(name, known);
    misspelt.push_back(input::nearest_word(name, known));
    if (hint.empty()) hint = "; it has " + input::list_text(known);
    line("mesh.boundaries: the mesh has no surface \"" + name + "\"" + hint);
  }
  for (const std::string& name : known) {
    if (std::find(names.begin(), names.end(), name) != names.end()) continue;
    if (std::find(misspelt.begin(), misspelt.end(), name) != misspelt.end()) continue;
    line("mesh.boundaries: surface \"" + name + "\" of the mesh has no condition; add for example \"" + name +
         "\": { \"type\": \"no_slip\" }");
  }
  if (!all.empty()) throw Error(ExitCode::usage, all);
}

}  // namespace fbi::meshgen
