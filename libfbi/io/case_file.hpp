/// The case file: everything a run needs, as fbi-gen writes it and fbi-run reads it.
///
///     /input                     text of the JSON file; attribute "name"
///     /mesh/nodes, cells         shape=(nodes,3) and (cells,8); /mesh/faces/NAME: (faces,2) = cell, local face
///     /mesh/periodic             shape=(pairs,2): image and master node; only with periodic faces
///     /mesh/box/x, y, z          only when the mesh is a tensor-product box
///     /fibers/names, group, first_node, position, tangent, element_length
#pragma once

#include <string>

#include "base/comm.hpp"
#include "io/hdf5.hpp"
#include "mesh/fiber_mesh.hpp"
#include "mesh/hex_mesh.hpp"
#include "mesh/mesh_data.hpp"

namespace fbi::io {

/// A whole case: the text of its JSON file, the mesh (no cells = no fluid) and the fibers (none = no fibers).
struct CaseFile {
  std::string json;
  std::string json_name;
  mesh::HexMeshData mesh;
  mesh::FiberMeshData fibers;
};

/// Writes a case file from one process; it replaces an older one only when it is complete. Throws Error(file).
void write_case_file(const std::string& path, const CaseFile& content);

/// Text and sizes of a case.
struct CaseHeader {
  std::string json;
  std::string json_name;
  GlobalIndex nodes = 0, cells = 0;
  GlobalIndex fibers = 0, fiber_nodes = 0, fiber_elements = 0;
  bool box = false;
  bool has_mesh() const { return cells > 0; }
  bool has_fibers() const { return fibers > 0; }
};

/// Reads text and sizes; rank 0 reads. Throws Error(file). Collective.
CaseHeader read_case_header(const Comm& comm, const std::string& path);

/// Reads each rank's chunk of the mesh. Throws Error(file) also when the case has no mesh. Collective.
mesh::HexMeshChunk read_mesh_chunk(const Comm& comm, const std::string& path);

/// Reads and distributes the mesh; each rank reads its part only. Throws Error(file) also when the case has no mesh.
/// Collective.
mesh::HexMesh read_mesh(const Comm& comm, const std::string& path);

/// Reads and distributes the fibers (an empty set when the case has none), near their fluid when it is given.
/// Collective.
mesh::FiberMesh read_fibers(const Comm& comm, const std::string& path, const mesh::HexMesh* fluid);

/// A fingerprint of a text (64-bit FNV-1a, 16 hexadecimal digits), to tell the checkpoints of different cases apart.
std::string fingerprint(const std::string& text);

/// Writes rows of numbers as int32 where `largest` allows it, else as int64. Collective for a parallel file.
void write_numbers(File& file, const std::string& name, const std::vector<GlobalIndex>& data, int columns,
                   GlobalIndex begin, GlobalIndex total, GlobalIndex largest);

}  // namespace fbi::io
