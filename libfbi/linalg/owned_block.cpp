#include "linalg/owned_block.hpp"

#include <algorithm>

namespace fbi::linalg {

std::array<Index, 3> box_nodes(const mesh::HexMesh& mesh) {
  std::array<Index, 3> n{};
  for (int d = 0; d < 3; ++d) n[d] = static_cast<Index>(mesh.box->coordinates[d].size());
  return n;
}

IndexBlock owned_range(const mesh::HexMesh& mesh) {
  const std::array<Index, 3> n = box_nodes(mesh);
  IndexBlock block;
  if (mesh.owned_nodes == 0) return block;
  block.begin = n;
  for (Index a = 0; a < mesh.owned_nodes; ++a) {
    const GlobalIndex id = mesh.node_id[a];
    const GlobalIndex index[3] = {id % n[0], id / n[0] % n[1], id / n[0] / n[1]};
    for (int d = 0; d < 3; ++d) {
      block.begin[d] = std::min(block.begin[d], static_cast<Index>(index[d]));
      block.end[d] = std::max(block.end[d], static_cast<Index>(index[d]) + 1);
    }
  }
  return block;
}

}  // namespace fbi::linalg
