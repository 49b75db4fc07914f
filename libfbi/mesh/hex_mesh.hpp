/// A hexahedral mesh distributed over ranks.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "base/comm.hpp"
#include "base/types.hpp"
#include "mesh/mesh_data.hpp"

namespace fbi::mesh {

/// One rank's part of a distributed mesh: every cell is on exactly one rank, nodes of its cells are owned or ghosts.
///
/// Local nodes [0, owned_nodes) are owned, the rest are ghosts; both parts are sorted by file id. The *solver number*
/// of an owned node is first_node + its local number, so that each rank owns a contiguous range.
///
/// With periodic faces some nodes are *images*: they have coordinates of their own but the solver number of their
/// master, and are ghosts on every rank, also on the one that owns the master. Nodal sums over owned nodes count each
/// unknown once; what is written by file id needs the images too: local nodes [0, owned_nodes + written_images) of all
/// ranks are all nodes of the file, each once.
struct HexMesh {
  Comm comm;
  GlobalIndex global_nodes = 0;
  GlobalIndex global_cells = 0;
  GlobalIndex independent_nodes = 0;  ///< nodes that are no images: rows of nodal systems
  Index owned_nodes = 0;
  Index written_images = 0;  ///< of the first ghosts, sorted by file id
  GlobalIndex first_node = 0;
  std::vector<double> coordinates;       ///< shape=(local_nodes,3) [length]
  std::vector<GlobalIndex> node_id;      ///< file id of each local node
  std::vector<GlobalIndex> node_number;  ///< solver number of each local node
  std::vector<Index> cells;              ///< shape=(local_cells,8), local node numbers
  std::vector<GlobalIndex> cell_id;      ///< file id of each local cell, ascending
  struct LocalFace {
    Index cell = 0;  ///< local cell number
    Index face = 0;  ///< as in mesh::Face
  };
  std::map<std::string, std::vector<LocalFace>> faces;  ///< every name on every rank; lists may be empty
  std::optional<Box> box;  ///< the whole box (three coordinate arrays, small) when the mesh is a tensor-product box

  Index local_nodes() const { return static_cast<Index>(node_id.size()); }
  bool has_images() const { return independent_nodes < global_nodes; }
  Index local_cells() const { return static_cast<Index>(cell_id.size()); }
  const double* node(Index local) const { return &coordinates[3 * static_cast<std::size_t>(local)]; }
};

/// Distributes a mesh that every rank holds as a contiguous chunk of the file: rank r passes the nodes and cells
/// [begin_r, end_r) of the file (`cells` holds global node ids) and its chunk of each face set. Cells are placed by
/// recursive coordinate bisection of their centers (boxes: blocks of whole cell layers where that divides evenly),
/// shared nodes belong to the lowest rank that has a cell at them. The result is independent of the chunking.
/// Collective.
struct HexMeshChunk {
  GlobalIndex global_nodes = 0, global_cells = 0;
  GlobalIndex first_node = 0, first_cell = 0;
  std::vector<double> nodes;
  std::vector<GlobalIndex> cells;
  std::map<std::string, std::vector<Face>> faces;
  std::vector<std::array<GlobalIndex, 2>> periodic;  ///< (image, master), in any split over the ranks
  std::optional<Box> box;
};
HexMesh distribute(const Comm& comm, HexMeshChunk chunk);
/// The same with the rank of each cell of the chunk given.
HexMesh distribute(const Comm& comm, HexMeshChunk chunk, const std::vector<int>& rank_of_cell);

/// The chunk of rank comm.rank() of a mesh that every rank holds as a whole: for tests and small meshes.
HexMeshChunk chunk_of(const Comm& comm, const HexMeshData& mesh);

/// A tensor-product box with faces xmin ... zmax. `general` leaves `box` empty (same nodes and cells).
HexMeshData make_box(const std::array<std::vector<double>, 3>& coordinates, bool general = false);

}  // namespace fbi::mesh
