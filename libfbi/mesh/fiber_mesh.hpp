/// Fibers distributed over ranks: each fiber lives whole on one rank.
#pragma once

#include <string>
#include <vector>

#include "base/comm.hpp"
#include "base/types.hpp"
#include "mesh/hex_mesh.hpp"
#include "mesh/mesh_data.hpp"

namespace fbi::mesh {

/// The fibers of this rank. Fiber f has nodes [first_node[f], first_node[f+1]) and elements
/// [first_node[f] - f, first_node[f+1] - f - 1): element e of it joins its nodes e and e+1.
struct FiberMesh {
  Comm comm;
  GlobalIndex global_fibers = 0;
  GlobalIndex global_nodes = 0;
  GlobalIndex global_elements = 0;
  std::vector<GlobalIndex> fiber_id;      ///< file number of each fiber, ascending
  std::vector<std::string> name;
  std::vector<Index> group;               ///< index into "fibers" of the case
  std::vector<Index> first_node;          ///< shape=(fibers+1)
  std::vector<GlobalIndex> first_node_id; ///< file number of each fiber's first node; its others follow
  std::vector<double> position;           ///< reference, shape=(nodes,3) [length]
  std::vector<double> tangent;            ///< reference unit tangents, shape=(nodes,3)
  std::vector<double> element_length;     ///< shape=(elements) [length]

  /// Two joined nodes of this rank.
  struct LocalJoint {
    Index a = 0, b = 0;
    JointType type = JointType::position;
  };
  std::vector<LocalJoint> joints;          ///< in file order, all of one group of joined fibers on one rank
  std::vector<std::vector<Index>> joined;  ///< fibers that hang together by joints, ascending; single fibers are left out
  std::vector<Index> joined_group;         ///< shape=(fibers): index into `joined`, -1 for fibers without joints

  bool is_joined(Index fiber) const { return !joined_group.empty() && joined_group[fiber] >= 0; }
  Index fibers() const { return static_cast<Index>(fiber_id.size()); }
  Index nodes() const { return static_cast<Index>(position.size() / 3); }
  Index elements() const { return static_cast<Index>(element_length.size()); }
  Index first_element(Index fiber) const { return first_node[fiber] - fiber; }
  /// Reference DoFs (x, y, z, tx, ty, tz) of every node, shape=(nodes,6).
  std::vector<double> reference_dofs() const;
};

/// Places fibers near the fluid they touch: a fiber goes to the rank whose box of cells holds (or is nearest to) the middle of
/// its reference curve, the lowest such rank on ties; without a fluid mesh fibers are spread evenly in file order. Fibers that
/// joints hold together go to the rank of the middle of them all. Every rank
/// passes a contiguous chunk of the fibers, `first_fiber` being the file number of its first one, and `first_node_id` the file
/// number of that fiber's first node. Collective.
FiberMesh distribute(const Comm& comm, const FiberMeshData& chunk, GlobalIndex first_fiber, GlobalIndex first_node_id,
                     const HexMesh* fluid);

/// The fibers [first, last) of a set that every rank holds as a whole, such that the ranks' chunks follow each other.
FiberMeshData chunk_of(const Comm& comm, const FiberMeshData& fibers, GlobalIndex& first_fiber, GlobalIndex& first_node_id);

}  // namespace fbi::mesh
