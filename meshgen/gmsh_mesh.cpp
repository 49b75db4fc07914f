#include "meshgen/gmsh_mesh.hpp"

#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <fstream>

#include "base/error.hpp"

#ifdef FBI_GMSH
#include <gmsh.h>
#endif

namespace fbi::meshgen {
namespace {

/// Refuses what is not a readable .msh file of format 2 or 4, before gmsh sees it.
void check_file(const std::string& path) {
  struct stat status;
  if (stat(path.c_str(), &status) == 0 && S_ISDIR(status.st_mode))
    throw Error(ExitCode::file, "mesh.file: \"" + path + "\" is a folder, not a mesh file");
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw Error(ExitCode::file, "mesh.file: \"" + path + "\" cannot be read: " + std::strerror(errno));
  const std::string remedy = "; make one by gmsh -3 NAME.geo -format msh41 -o NAME.msh";
  std::string word, version;
  stream >> word;
  while (word == "$Comments" && stream) {
    while (word != "$EndComments" && stream >> word) continue;
    stream >> word;
  }
  if (word != "$MeshFormat")
    throw Error(ExitCode::usage, "mesh.file: \"" + path + "\" is not a mesh file of gmsh (format 2 or 4)" + remedy);
  stream >> version;
  if (version[0] != '2' && version[0] != '4')
    throw Error(ExitCode::usage,
                "mesh.file: \"" + path + "\" has format " + version + "; formats 2 and 4 are read" + remedy);
}

}  // namespace

#ifdef FBI_GMSH

namespace {

constexpr int quadrangle4 = 3, hexahedron8 = 5;  // element types of gmsh

/// gmsh as long as it is needed.
class Session {
 public:
  Session() {
    gmsh::initialize(0, nullptr, false);
    gmsh::option::setNumber("General.Terminal", 0);
    gmsh::option::setNumber("General.Verbosity", 1);
  }
  ~Session() { gmsh::finalize(); }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
};

void append(std::vector<GlobalIndex>& to, const std::vector<std::size_t>& from) {
  to.insert(to.end(), from.begin(), from.end());
}

std::string element_name(int type) {
  std::string name;
  int dimension = 0, order = 0, nodes = 0, primary = 0;
  std::vector<double> coordinates;
  gmsh::model::mesh::getElementProperties(type, name, dimension, order, nodes, coordinates, primary);
  return name;
}

void read_cells(int tag, FileMesh& mesh) {
  std::vector<int> types;
  std::vector<std::vector<std::size_t>> elements, nodes;
  gmsh::model::mesh::getElements(types, elements, nodes, 3, tag);
  for (std::size_t i = 0; i < types.size(); ++i) {
    if (types[i] == hexahedron8) {
      append(mesh.cell_tags, elements[i]);
      append(mesh.cells, nodes[i]);
    } else {
      mesh.other_elements[element_name(types[i])] += static_cast<GlobalIndex>(elements[i].size());
    }
  }
}

void read_surface(int tag, FileMesh::Surface& surface) {
  std::vector<int> types;
  std::vector<std::vector<std::size_t>> elements, nodes;
  gmsh::model::mesh::getElements(types, elements, nodes, 2, tag);
  for (std::size_t i = 0; i < types.size(); ++i) {
    if (types[i] == quadrangle4)
      append(surface.quadrangles, nodes[i]);
    else
      surface.others += static_cast<GlobalIndex>(elements[i].size());
  }
}

}  // namespace

bool can_read_gmsh() { return true; }

FileMesh read_gmsh(const std::string& path) {
  check_file(path);
  FileMesh mesh;
  try {
    const Session session;
    gmsh::open(path);
    std::string problem;
    gmsh::logger::getLastError(problem);
    if (!problem.empty())
      throw Error(ExitCode::file, "mesh.file: \"" + path + "\" cannot be read: " + problem + "; mesh it again");
    std::vector<std::size_t> tags;
    std::vector<double> parameters;
    gmsh::model::mesh::getNodes(tags, mesh.nodes, parameters, -1, -1, false, false);
    append(mesh.node_tags, tags);
    gmsh::vectorpair groups, volumes;
    gmsh::model::getPhysicalGroups(groups, 3);
    if (groups.empty()) {
      gmsh::model::getEntities(volumes, 3);
      for (const auto& [dimension, tag] : volumes) read_cells(tag, mesh);
    }
    for (const auto& [dimension, group] : groups) {
      std::vector<int> entities;
      gmsh::model::getEntitiesForPhysicalGroup(dimension, group, entities);
      for (const int tag : entities) read_cells(tag, mesh);
    }
    gmsh::model::getPhysicalGroups(groups, 2);
    for (const auto& [dimension, group] : groups) {
      std::string name;
      gmsh::model::getPhysicalName(dimension, group, name);
      if (name.empty()) {
        ++mesh.unnamed_surfaces;
        continue;
      }
      std::vector<int> entities;
      gmsh::model::getEntitiesForPhysicalGroup(dimension, group, entities);
      for (const int tag : entities) read_surface(tag, mesh.surfaces[name]);
    }
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::string& problem) {
    throw Error(ExitCode::file, "mesh.file: \"" + path + "\" cannot be read: " + problem + "; mesh it again");
  } catch (...) {
    throw Error(ExitCode::file, "mesh.file: \"" + path + "\" cannot be read by gmsh; mesh it again");
  }
  return mesh;
}

#else

bool can_read_gmsh() { return false; }

FileMesh read_gmsh(const std::string& path) {
  check_file(path);
  throw Error(ExitCode::usage, "mesh.file: this program was built without gmsh and cannot read \"" + path +
                                   "\"; install libgmsh-dev (tools/install-packages) and configure with -DFBI_GMSH=ON");
}

#endif

}  // namespace fbi::meshgen
