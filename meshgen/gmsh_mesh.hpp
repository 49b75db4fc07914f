/// Reads mesh files of gmsh. The only place that knows gmsh; a build without it refuses mesh files.
#pragma once

#include <array>
#include <map>
#include <string>
#include <vector>

#include "base/types.hpp"

namespace fbi::meshgen {

/// What a file holds of use here, in the numbers of the file.
struct FileMesh {
  std::vector<GlobalIndex> node_tags;  ///< shape=(nodes)
  std::vector<double> nodes;           ///< shape=(nodes,3) [length]
  std::vector<GlobalIndex> cell_tags;  ///< shape=(cells): hexahedra with 8 nodes of the fluid
  std::vector<GlobalIndex> cells;      ///< node tags, shape=(cells,8), VTK order
  std::map<std::string, GlobalIndex>
      other_elements;  ///< volume elements that are none of these, by what gmsh calls them
  struct Surface {
    std::vector<GlobalIndex> quadrangles;  ///< node tags, shape=(quadrangles,4)
    GlobalIndex others = 0;                ///< surface elements that are not quadrangles with 4 nodes
  };
  std::map<std::string, Surface> surfaces;  ///< physical surfaces by name
  GlobalIndex unnamed_surfaces = 0;         ///< physical surfaces with a number only
};

/// True when this build can read mesh files.
bool can_read_gmsh();

/// Reads a .msh file (format 2 or 4, text or binary). The fluid is the physical volumes, or all volumes when there are
/// none. Throws Error(file) when the file cannot be read, Error(usage) when it is no such file or this build lacks
/// gmsh.
FileMesh read_gmsh(const std::string& path);

}  // namespace fbi::meshgen
