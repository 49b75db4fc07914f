#include "fluid/ghosted.hpp"

#include <vector>

namespace fbi::fluid {

linalg::VecHandle create_ghosted(const mesh::HexMesh& mesh) {
  const std::vector<PetscInt> ghosts(mesh.node_number.begin() + mesh.owned_nodes, mesh.node_number.end());
  linalg::VecHandle vector;
  FBI_PETSC(VecCreateGhostBlock(mesh.comm.get(), 4, 4 * mesh.owned_nodes, PETSC_DETERMINE,
                                static_cast<PetscInt>(ghosts.size()), ghosts.data(), vector.out()));
  Vec local = nullptr;
  FBI_PETSC(VecGhostGetLocalForm(vector, &local));
  FBI_PETSC(VecSet(local, 0.0));
  FBI_PETSC(VecGhostRestoreLocalForm(vector, &local));
  return vector;
}

void update_ghosts(Vec vector) {
  FBI_PETSC(VecGhostUpdateBegin(vector, INSERT_VALUES, SCATTER_FORWARD));
  FBI_PETSC(VecGhostUpdateEnd(vector, INSERT_VALUES, SCATTER_FORWARD));
}

void add_ghosts(Vec vector) {
  FBI_PETSC(VecGhostUpdateBegin(vector, ADD_VALUES, SCATTER_REVERSE));
  FBI_PETSC(VecGhostUpdateEnd(vector, ADD_VALUES, SCATTER_REVERSE));
}

}  // namespace fbi::fluid
