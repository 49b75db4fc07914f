#include "io/file_order.hpp"

namespace fbi::io {

FileOrder node_order(const mesh::HexMesh& mesh) {
  return FileOrder(mesh.comm, {mesh.node_id.begin(), mesh.node_id.begin() + mesh.owned_nodes}, mesh.global_nodes);
}

FileOrder output_order(const mesh::HexMesh& mesh) {
  const Index count = mesh.owned_nodes + mesh.written_images;
  return FileOrder(mesh.comm, {mesh.node_id.begin(), mesh.node_id.begin() + count}, mesh.global_nodes);
}

FileOrder fiber_node_order(const mesh::FiberMesh& fibers) {
  std::vector<GlobalIndex> numbers;
  for (Index f = 0; f < fibers.fibers(); ++f)
    for (Index n = 0; n < fibers.first_node[f + 1] - fibers.first_node[f]; ++n)
      numbers.push_back(fibers.first_node_id[f] + n);
  return FileOrder(fibers.comm, numbers, fibers.global_nodes);
}

}  // namespace fbi::io
