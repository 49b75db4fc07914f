/// Whole meshes as flat arrays, as the generator makes them and the case file holds them.
#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/types.hpp"

namespace fbi::mesh {

/// Face of a hexahedron. Local face numbers: 0 xi=-1, 1 xi=+1, 2 eta=-1, 3 eta=+1, 4 zeta=-1, 5 zeta=+1.
struct Face {
  GlobalIndex cell = 0;
  Index face = 0;
};

/// Node coordinates of a tensor-product box along x, y, z; nodes and cells are numbered x fastest, then y, then z.
struct Box {
  std::array<std::vector<double>, 3> coordinates;
  std::array<Index, 3> cells() const {
    return {static_cast<Index>(coordinates[0].size()) - 1, static_cast<Index>(coordinates[1].size()) - 1,
            static_cast<Index>(coordinates[2].size()) - 1};
  }
};

/// A hexahedral mesh. Node order of a hex8: (-,-,-) (+,-,-) (+,+,-) (-,+,-) then the same with zeta = +1 (VTK order).
struct HexMeshData {
  std::vector<double> nodes;                       ///< shape=(nodes,3), row-major [length]
  std::vector<GlobalIndex> cells;                  ///< shape=(cells,8), row-major, node numbers
  std::map<std::string, std::vector<Face>> faces;  ///< named face sets
  /// Node pairs (image, master): the image carries the unknowns of its master, which is no image itself; ascending.
  std::vector<std::array<GlobalIndex, 2>> periodic;
  std::optional<Box> box;  ///< set when the mesh is a tensor-product box in the numbering above
  GlobalIndex node_count() const { return static_cast<GlobalIndex>(nodes.size()) / 3; }
  GlobalIndex cell_count() const { return static_cast<GlobalIndex>(cells.size()) / 8; }
};

/// What two joined nodes share.
enum class JointType {
  position,  ///< the place: a hinge
  rigid      ///< the place, and the directions of the tangents turn together
};

/// Two joined nodes, of two fibers or of one.
struct Joint {
  GlobalIndex a = 0, b = 0;  ///< node numbers
  JointType type = JointType::position;
};

/// Fibers, each a chain of Hermite elements: element e of a fiber joins its nodes e and e+1.
struct FiberMeshData {
  std::vector<std::string> name;           ///< shape=(fibers): "patch/3/0", ...
  std::vector<Index> group;                ///< shape=(fibers): index into "fibers" of the case file
  std::vector<GlobalIndex> first_node;     ///< shape=(fibers+1)
  std::vector<double> position;            ///< reference node positions, shape=(nodes,3) [length]
  std::vector<double> tangent;             ///< reference node tangents dr/ds, shape=(nodes,3), unit vectors
  std::vector<double> element_length;      ///< l_ele, arc-length consistent, shape=(elements) [length];
                                           ///< element e of fiber f has number first_node[f] - f + e
  // Joints; all of this is empty without them.
  std::vector<Joint> joints;             ///< ordered by the fiber of node a
  std::vector<GlobalIndex> first_joint;  ///< shape=(fibers+1): joints whose node a lies on the fiber
  std::vector<GlobalIndex> body;         ///< shape=(fibers): lowest number of the fibers that hang together with it
  std::vector<double> anchor;            ///< shape=(fibers,3): middle of those fibers, the same for all of them [length]
  GlobalIndex fiber_count() const { return static_cast<GlobalIndex>(name.size()); }
};

}  // namespace fbi::mesh
