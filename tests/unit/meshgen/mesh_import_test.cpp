/// Import of mesh files: written here by hand in formats 2 and 4, with everything that may be wrong with them.
#include "meshgen/mesh_import.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cfenv>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include "base/error.hpp"
#include "fem/hex8.hpp"
#include "mesh/hex_mesh.hpp"
#include "meshgen/periodic.hpp"

using namespace fbi;

namespace {

mesh::HexMeshData box() { return mesh::make_box({{{0.0, 0.5, 2.0}, {0.0, 1.0}, {0.0, 0.25, 0.5, 1.0}}}, true); }

// What a file holds of a mesh: tags are numbers + 1, faces count from 1001.
meshgen::FileMesh file_of(const mesh::HexMeshData& mesh) {
  meshgen::FileMesh file;
  file.nodes = mesh.nodes;
  for (GlobalIndex n = 0; n < mesh.node_count(); ++n) file.node_tags.push_back(n + 1);
  for (GlobalIndex c = 0; c < mesh.cell_count(); ++c) file.cell_tags.push_back(c + 1);
  for (const GlobalIndex node : mesh.cells) file.cells.push_back(node + 1);
  for (const auto& [name, faces] : mesh.faces)
    for (const mesh::Face& face : faces)
      for (const int a : fem::hex8_faces[face.face])
        file.surfaces[name].quadrangles.push_back(mesh.cells[8 * face.cell + a] + 1);
  return file;
}

std::string refusal(const meshgen::FileMesh& file) {
  std::vector<std::string> warnings;
  try {
    meshgen::import_mesh(file, 1.0, warnings);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::geometry);
    return error.what();
  }
  return "none";
}

void expect_in(const std::string& part, const std::string& text) {
  EXPECT_NE(text.find(part), std::string::npos) << part << "\nis not in\n" << text;
}

std::string number(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", x);
  return text;
}

std::string format2(const meshgen::FileMesh& file) {
  std::string text =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n" + std::to_string(file.surfaces.size() + 1) + "\n";
  int group = 1;
  for (const auto& [name, surface] : file.surfaces) text += "2 " + std::to_string(group++) + " \"" + name + "\"\n";
  text += "3 99 \"fluid\"\n$EndPhysicalNames\n$Nodes\n" + std::to_string(file.node_tags.size()) + "\n";
  for (std::size_t n = 0; n < file.node_tags.size(); ++n)
    text += std::to_string(file.node_tags[n]) + " " + number(file.nodes[3 * n]) + " " + number(file.nodes[3 * n + 1]) +
            " " + number(file.nodes[3 * n + 2]) + "\n";
  std::string elements;
  int tag = 1000, count = 0;
  group = 1;
  for (const auto& [name, surface] : file.surfaces) {
    for (std::size_t q = 0; q < surface.quadrangles.size(); q += 4, ++count) {
      elements += std::to_string(++tag) + " 3 2 " + std::to_string(group) + " " + std::to_string(group);
      for (int a = 0; a < 4; ++a) elements += " " + std::to_string(surface.quadrangles[q + a]);
      elements += "\n";
    }
    ++group;
  }
  for (std::size_t c = 0; c < file.cell_tags.size(); ++c, ++count) {
    elements += std::to_string(file.cell_tags[c]) + " 5 2 99 1";
    for (int a = 0; a < 8; ++a) elements += " " + std::to_string(file.cells[8 * c + a]);
    elements += "\n";
  }
  return text + "$EndNodes\n$Elements\n" + std::to_string(count) + "\n" + elements + "$EndElements\n";
}

std::string format4(const meshgen::FileMesh& file) {
  const std::size_t sets = file.surfaces.size();
  std::string text = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$PhysicalNames\n" + std::to_string(sets + 1) + "\n";
  int group = 1;
  for (const auto& [name, surface] : file.surfaces) text += "2 " + std::to_string(group++) + " \"" + name + "\"\n";
  text += "3 99 \"fluid\"\n$EndPhysicalNames\n$Entities\n0 0 " + std::to_string(sets) + " 1\n";
  for (std::size_t s = 1; s <= sets; ++s) text += std::to_string(s) + " 0 0 0 1 1 1 1 " + std::to_string(s) + " 0\n";
  const std::string count = std::to_string(file.node_tags.size());
  text += "1 0 0 0 1 1 1 1 99 0\n$EndEntities\n$Nodes\n1 " + count + " 1 " + count + "\n3 1 0 " + count + "\n";
  for (const GlobalIndex tag : file.node_tags) text += std::to_string(tag) + "\n";
  for (std::size_t n = 0; n < file.node_tags.size(); ++n)
    text +=
        number(file.nodes[3 * n]) + " " + number(file.nodes[3 * n + 1]) + " " + number(file.nodes[3 * n + 2]) + "\n";
  std::string elements;
  std::size_t total = file.cell_tags.size();
  int tag = 1000;
  group = 1;
  for (const auto& [name, surface] : file.surfaces) {
    const std::size_t quadrangles = surface.quadrangles.size() / 4;
    total += quadrangles;
    elements += "2 " + std::to_string(group++) + " 3 " + std::to_string(quadrangles) + "\n";
    for (std::size_t q = 0; q < surface.quadrangles.size(); q += 4) {
      elements += std::to_string(++tag);
      for (int a = 0; a < 4; ++a) elements += " " + std::to_string(surface.quadrangles[q + a]);
      elements += "\n";
    }
  }
  elements += "3 1 5 " + std::to_string(file.cell_tags.size()) + "\n";
  for (std::size_t c = 0; c < file.cell_tags.size(); ++c) {
    elements += std::to_string(file.cell_tags[c]);
    for (int a = 0; a < 8; ++a) elements += " " + std::to_string(file.cells[8 * c + a]);
    elements += "\n";
  }
  return text + "$EndNodes\n$Elements\n" + std::to_string(sets + 1) + " " + std::to_string(total) + " 1 " +
         std::to_string(tag) + "\n" + elements + "$EndElements\n";
}

}  // namespace

TEST(MeshImport, ReadsFormats2And4) {
  if (!meshgen::can_read_gmsh()) GTEST_SKIP() << "built without gmsh";
  mesh::HexMeshData wanted = box();
  wanted.nodes[3 * 4 + 0] += 0.1;  // no box any more
  const meshgen::FileMesh written = file_of(wanted);
  const std::string path =
      (std::filesystem::temp_directory_path() / ("import_" + std::to_string(getpid()) + ".msh")).string();
  for (const std::string& text : {format2(written), format4(written)}) {
    std::ofstream(path) << text;
    fedisableexcept(FE_ALL_EXCEPT);
    const meshgen::FileMesh file = meshgen::read_gmsh(path);
    std::vector<std::string> warnings;
    const mesh::HexMeshData mesh = meshgen::import_mesh(file, 2.0, warnings);
    EXPECT_TRUE(warnings.empty());
    ASSERT_EQ(mesh.nodes.size(), wanted.nodes.size());
    for (std::size_t k = 0; k < mesh.nodes.size(); ++k) EXPECT_EQ(mesh.nodes[k], 2.0 * wanted.nodes[k]);
    EXPECT_EQ(mesh.cells, wanted.cells);
    ASSERT_EQ(mesh.faces.size(), 6u);
    for (const auto& [name, faces] : wanted.faces) {
      ASSERT_EQ(mesh.faces.at(name).size(), faces.size()) << name;
      for (std::size_t i = 0; i < faces.size(); ++i) {
        EXPECT_EQ(mesh.faces.at(name)[i].cell, faces[i].cell);
        EXPECT_EQ(mesh.faces.at(name)[i].face, faces[i].face);
      }
    }
    EXPECT_FALSE(mesh.box.has_value());
  }
  std::ofstream(path) << "Point(1) = {0, 0, 0};\n";
  EXPECT_THROW(meshgen::read_gmsh(path), Error);
  std::ofstream(path) << "$MeshFormat\n3 0 8\n$EndMeshFormat\n";
  EXPECT_THROW(meshgen::read_gmsh(path), Error);
  std::filesystem::remove(path);
  EXPECT_THROW(meshgen::read_gmsh(path), Error);
}

TEST(MeshImport, RecognisesABoxAndDropsUnusedNodes) {
  meshgen::FileMesh file = file_of(box());
  file.node_tags.push_back(500);
  file.nodes.insert(file.nodes.end(), {9.0, 9.0, 9.0});
  std::vector<std::string> warnings;
  const mesh::HexMeshData mesh = meshgen::import_mesh(file, 1.0, warnings);
  ASSERT_TRUE(mesh.box.has_value());
  EXPECT_EQ(mesh.nodes, box().nodes);
  EXPECT_EQ(mesh.cells, box().cells);
}

TEST(MeshImport, TurnsLeftHandedCellsOver) {
  meshgen::FileMesh file = file_of(box());
  for (std::size_t c = 0; c < 3; ++c)
    for (int a = 0; a < 4; ++a) std::swap(file.cells[8 * c + a], file.cells[8 * c + 4 + a]);
  std::vector<std::string> warnings;
  const mesh::HexMeshData mesh = meshgen::import_mesh(file, 1.0, warnings);
  ASSERT_EQ(warnings.size(), 1u);
  expect_in("3 cells were left-handed", warnings[0]);
  EXPECT_EQ(mesh.cells, box().cells);
}

TEST(MeshImport, RefusesWithARemedy) {
  meshgen::FileMesh file = file_of(box());
  file.other_elements = {{"Tetrahedron 4", 7}, {"Hexahedron 27", 1}};
  expect_in("7 elements of type \"Tetrahedron 4\"", refusal(file));
  expect_in("Recombine", refusal(file));
  expect_in("1 element of type \"Hexahedron 27\"", refusal(file));
  expect_in("Mesh.ElementOrder = 1", refusal(file));

  file = file_of(box());
  file.surfaces.clear();
  expect_in("no named surfaces", refusal(file));

  file = file_of(box());
  file.surfaces.erase("ymax");
  expect_in("6 boundary faces have no name: around (0.25, 1, 0.125)", refusal(file));

  file = file_of(box());
  file.surfaces["other"].quadrangles.assign(file.surfaces["xmin"].quadrangles.begin(),
                                            file.surfaces["xmin"].quadrangles.begin() + 4);
  expect_in("surface \"xmin\": 1 face belongs to \"other\" too", refusal(file));

  file = file_of(box());
  const mesh::HexMeshData mesh = box();
  for (const int a : fem::hex8_faces[1]) file.surfaces["xmin"].quadrangles.push_back(mesh.cells[a] + 1);
  expect_in("surface \"xmin\": 1 face is not on the boundary", refusal(file));

  file = file_of(box());
  std::swap(file.cells[8], file.cells[9]);
  expect_in("1 cell is folded", refusal(file));
  expect_in("element 2 at (1.25, 0.5, 0.125)", refusal(file));

  // The last cells get nodes of their own at the same places.
  file = file_of(box());
  for (int a = 0; a < 4; ++a) {
    const std::size_t shared = 8 * 4 + a;
    const GlobalIndex old = file.cells[shared];
    file.node_tags.push_back(600 + a);
    for (int d = 0; d < 3; ++d) file.nodes.push_back(file.nodes[3 * (old - 1) + d]);
    file.cells[shared] = 600 + a;
  }
  expect_in("4 nodes lie at the place of another node", refusal(file));
  expect_in("Coherence", refusal(file));

  // Two cells with a gap between them.
  mesh::HexMeshData parts = mesh::make_box({{{0.0, 1.0, 2.0, 3.0}, {0.0, 1.0}, {0.0, 1.0}}}, true);
  parts.cells.erase(parts.cells.begin() + 8, parts.cells.begin() + 16);
  parts.faces = {{"wall", {}}};
  expect_in("the mesh consists of 2 parts", refusal(file_of(parts)) + refusal([&] {
                                              meshgen::FileMesh two = file_of(parts);
                                              two.surfaces["wall"];
                                              return two;
                                            }()));
}

TEST(MeshImport, NamesOfConditionsAndSurfacesAgree) {
  const mesh::HexMeshData mesh = box();
  EXPECT_NO_THROW(meshgen::check_boundary_names(mesh, {"xmax", "xmin", "ymax", "ymin", "zmax", "zmin"}));
  try {
    meshgen::check_boundary_names(mesh, {"xmaxx", "xmin", "ymax", "ymin", "zmax"});
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::usage);
    EXPECT_STREQ(
        error.what(),
        "mesh.boundaries: the mesh has no surface \"xmaxx\"; did you mean \"xmax\"?\n"
        "mesh.boundaries: surface \"zmin\" of the mesh has no condition; add for example \"zmin\": { \"type\": "
        "\"no_slip\" }");
  }
}

TEST(Periodic, PairsOfABoxHaveOneMasterEach) {
  mesh::HexMeshData mesh = box();
  meshgen::match_periodic({{"xmin", "xmax"}, {"xmax", "xmin"}, {"zmin", "zmax"}, {"zmax", "zmin"}}, mesh);
  EXPECT_EQ(mesh.periodic.size(), 24u - 2 * 2 * 3);
  for (const auto& [image, master] : mesh.periodic) {
    EXPECT_LT(master, image);
    for (const auto& pair : mesh.periodic) EXPECT_NE(pair[0], master);
    EXPECT_EQ(std::fmod(mesh.nodes[3 * image] - mesh.nodes[3 * master], 2.0), 0.0);
    EXPECT_EQ(mesh.nodes[3 * image + 1], mesh.nodes[3 * master + 1]);
    EXPECT_EQ(std::fmod(mesh.nodes[3 * image + 2] - mesh.nodes[3 * master + 2], 1.0), 0.0);
  }
  // A node of xmax that moved in its face.
  mesh = box();
  mesh.nodes[3 * 8 + 2] += 0.01;
  try {
    meshgen::match_periodic({{"xmin", "xmax"}, {"xmax", "xmin"}}, mesh);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::geometry);
    expect_in("periodic faces \"xmax\" and \"xmin\" do not match: the node at (2, 0, 0.26)", error.what());
    expect_in("has no partner at (0, 0, 0.26), the nearest is 0.01 away", error.what());
  }
}
