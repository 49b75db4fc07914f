#include "io/case_file.hpp"

#include <limits>

#include "base/error.hpp"
#include "base/log.hpp"
#include "io/format.hpp"
#include "mesh/exchange.hpp"

namespace fbi::io {
namespace {

constexpr const char* axis_names[3] = {"x", "y", "z"};

void write_mesh(File& file, const mesh::HexMeshData& mesh) {
  file.write("/mesh/nodes", mesh.nodes, 3);
  write_numbers(file, "/mesh/cells", mesh.cells, 8, 0, mesh.cell_count(), mesh.node_count());
  file.make_group("/mesh/faces");
  for (const auto& [name, faces] : mesh.faces) {
    std::vector<GlobalIndex> rows;
    rows.reserve(2 * faces.size());
    for (const mesh::Face& face : faces) rows.insert(rows.end(), {face.cell, face.face});
    write_numbers(file, "/mesh/faces/" + name, rows, 2, 0, static_cast<GlobalIndex>(faces.size()), mesh.cell_count());
  }
  if (!mesh.periodic.empty()) {
    std::vector<GlobalIndex> rows;
    for (const std::array<GlobalIndex, 2>& pair : mesh.periodic) rows.insert(rows.end(), pair.begin(), pair.end());
    write_numbers(file, "/mesh/periodic", rows, 2, 0, static_cast<GlobalIndex>(mesh.periodic.size()),
                  mesh.node_count());
  }
  if (mesh.box)
    for (int a = 0; a < 3; ++a) file.write(std::string("/mesh/box/") + axis_names[a], mesh.box->coordinates[a]);
}

void write_fibers(File& file, const mesh::FiberMeshData& fibers) {
  file.write_strings("/fibers/names", fibers.name, 0, fibers.fiber_count());
  file.write("/fibers/group", fibers.group);
  file.write("/fibers/first_node", fibers.first_node);
  file.write("/fibers/position", fibers.position, 3);
  file.write("/fibers/tangent", fibers.tangent, 3);
  file.write("/fibers/element_length", fibers.element_length);
  if (fibers.joints.empty()) return;
  std::vector<GlobalIndex> rows;
  for (const mesh::Joint& joint : fibers.joints)
    rows.insert(rows.end(), {joint.a, joint.b, static_cast<GlobalIndex>(joint.type)});
  file.write("/fibers/joints/nodes", rows, 3);  // node, node, 0 for position or 1 for rigid
  file.write("/fibers/joints/first", fibers.first_joint);
  file.write("/fibers/joints/body", fibers.body);
  file.write("/fibers/joints/anchor", fibers.anchor, 3);
}

void broadcast(const Comm& comm, std::string& text) {
  int length = static_cast<int>(text.size());
  MPI_Bcast(&length, 1, MPI_INT, 0, comm.get());
  text.resize(static_cast<std::size_t>(length));
  MPI_Bcast(text.data(), length, MPI_CHAR, 0, comm.get());
}

CaseHeader read_header(const std::string& path) {
  const File file = open_kind(path, FileKind::case_input);
  CaseHeader header;
  header.json = file.read_text("/input");
  header.json_name = file.text_attribute("/input", "name");
  if (file.has("/mesh")) {
    header.nodes = file.shape("/mesh/nodes")[0];
    header.cells = file.shape("/mesh/cells")[0];
    header.box = file.has("/mesh/box");
  }
  if (file.has("/fibers")) {
    header.fibers = file.shape("/fibers/names")[0];
    header.fiber_nodes = file.shape("/fibers/position")[0];
    header.fiber_elements = file.shape("/fibers/element_length")[0];
  }
  return header;
}

struct Range {
  GlobalIndex begin, count;
};
Range even_range(const Comm& comm, GlobalIndex count) {
  const GlobalIndex begin = mesh::even_begin(count, comm.rank(), comm.size());
  return {begin, mesh::even_begin(count, comm.rank() + 1, comm.size()) - begin};
}

}  // namespace

void write_numbers(File& file, const std::string& name, const std::vector<GlobalIndex>& data, int columns,
                   GlobalIndex begin, GlobalIndex total, GlobalIndex largest) {
  if (largest > std::numeric_limits<std::int32_t>::max())
    file.write_rows(name, data, columns, begin, total);
  else
    file.write_rows(name, std::vector<std::int32_t>(data.begin(), data.end()), columns, begin, total);
}

void write_case_file(const std::string& path, const CaseFile& content) {
  const std::size_t bytes = content.json.size() + 8 * content.mesh.nodes.size() + 4 * content.mesh.cells.size() +
                            56 * content.fibers.position.size() / 3 + 65536;
  File file = File::create(path, static_cast<GlobalIndex>(bytes));
  write_format(file, FileKind::case_input);
  file.write_text("/input", content.json);
  file.write_attribute("/input", "name", content.json_name);
  if (content.mesh.cell_count() > 0) write_mesh(file, content.mesh);
  if (content.fibers.fiber_count() > 0) write_fibers(file, content.fibers);
  file.commit();
}

CaseHeader read_case_header(const Comm& comm, const std::string& path) {
  CaseHeader header;
  std::string text;
  if (comm.rank() == 0) try {
      header = read_header(path);
    } catch (const Error& error) {
      text = error.what();
    }
  agree_on_error(comm, ExitCode::file, text);
  broadcast(comm, header.json);
  broadcast(comm, header.json_name);
  GlobalIndex sizes[6] = {header.nodes,       header.cells,          header.fibers,
                          header.fiber_nodes, header.fiber_elements, header.box};
  MPI_Bcast(sizes, 6, MPI_INT64_T, 0, comm.get());
  header.nodes = sizes[0];
  header.cells = sizes[1];
  header.fibers = sizes[2];
  header.fiber_nodes = sizes[3];
  header.fiber_elements = sizes[4];
  header.box = sizes[5] != 0;
  return header;
}

mesh::HexMeshChunk read_mesh_chunk(const Comm& comm, const std::string& path) {
  mesh::HexMeshChunk chunk;
  {
    const File file = open_kind(comm, path, FileKind::case_input);
    if (!file.has("/mesh"))
      throw Error(ExitCode::file,
                  "\"" + path + "\" holds no fluid mesh; make it again from a JSON file with \"channel\" or \"mesh\"");
    chunk.global_nodes = file.shape("/mesh/nodes")[0];
    chunk.global_cells = file.shape("/mesh/cells")[0];
    const Range nodes = even_range(comm, chunk.global_nodes), cells = even_range(comm, chunk.global_cells);
    chunk.first_node = nodes.begin;
    chunk.first_cell = cells.begin;
    chunk.nodes = file.read_rows<double>("/mesh/nodes", nodes.begin, nodes.count);
    chunk.cells = file.read_rows<GlobalIndex>("/mesh/cells", cells.begin, cells.count);
    for (const std::string& name : file.children("/mesh/faces")) {
      const std::string dataset = "/mesh/faces/" + name;
      const Range faces = even_range(comm, file.shape(dataset)[0]);
      const std::vector<GlobalIndex> rows = file.read_rows<GlobalIndex>(dataset, faces.begin, faces.count);
      std::vector<mesh::Face>& list = chunk.faces[name];
      for (std::size_t i = 0; i + 1 < rows.size(); i += 2) list.push_back({rows[i], static_cast<Index>(rows[i + 1])});
    }
    if (file.has("/mesh/periodic")) {
      const Range pairs = even_range(comm, file.shape("/mesh/periodic")[0]);
      const std::vector<GlobalIndex> rows = file.read_rows<GlobalIndex>("/mesh/periodic", pairs.begin, pairs.count);
      for (std::size_t i = 0; i + 1 < rows.size(); i += 2) chunk.periodic.push_back({rows[i], rows[i + 1]});
    }
    if (file.has("/mesh/box")) {
      chunk.box.emplace();
      for (int a = 0; a < 3; ++a)
        chunk.box->coordinates[a] = file.read<double>(std::string("/mesh/box/") + axis_names[a]);
    }
  }
  return chunk;
}

mesh::HexMesh read_mesh(const Comm& comm, const std::string& path) {
  return distribute(comm, read_mesh_chunk(comm, path));
}

mesh::FiberMesh read_fibers(const Comm& comm, const std::string& path, const mesh::HexMesh* fluid) {
  mesh::FiberMeshData chunk;
  GlobalIndex first_fiber = 0, first_node = 0;
  {
    const File file = open_kind(comm, path, FileKind::case_input);
    if (file.has("/fibers")) {
      const Range fibers = even_range(comm, file.shape("/fibers/names")[0]);
      first_fiber = fibers.begin;
      chunk.name = file.read_strings("/fibers/names", fibers.begin, fibers.count);
      chunk.group = file.read_rows<Index>("/fibers/group", fibers.begin, fibers.count);
      chunk.first_node = file.read_rows<GlobalIndex>("/fibers/first_node", fibers.begin, fibers.count + 1);
      first_node = chunk.first_node.front();
      const GlobalIndex nodes = chunk.first_node.back() - first_node;
      chunk.position = file.read_rows<double>("/fibers/position", first_node, nodes);
      chunk.tangent = file.read_rows<double>("/fibers/tangent", first_node, nodes);
      chunk.element_length =
          file.read_rows<double>("/fibers/element_length", first_node - first_fiber, nodes - fibers.count);
      for (GlobalIndex& node : chunk.first_node) node -= first_node;
      if (file.has("/fibers/joints")) {
        chunk.first_joint = file.read_rows<GlobalIndex>("/fibers/joints/first", fibers.begin, fibers.count + 1);
        chunk.body = file.read_rows<GlobalIndex>("/fibers/joints/body", fibers.begin, fibers.count);
        chunk.anchor = file.read_rows<double>("/fibers/joints/anchor", fibers.begin, fibers.count);
        const GlobalIndex first_joint = chunk.first_joint.front();
        const std::vector<GlobalIndex> rows = file.read_rows<GlobalIndex>("/fibers/joints/nodes", first_joint,
                                                                          chunk.first_joint.back() - first_joint);
        for (std::size_t i = 0; i + 2 < rows.size(); i += 3)
          chunk.joints.push_back({rows[i], rows[i + 1], static_cast<mesh::JointType>(rows[i + 2])});
      }
    }
  }
  return distribute(comm, chunk, first_fiber, first_node, fluid);
}

std::string fingerprint(const std::string& text) {
  std::uint64_t hash = 14695981039346656037ull;
  for (const char c : text) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ull;
  return log::format("%016llx", static_cast<unsigned long long>(hash));
}

}  // namespace fbi::io
