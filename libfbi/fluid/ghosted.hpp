/// Ghosted PETSc vectors in the node numbering of a mesh, and access to their local arrays.
#pragma once

#include "linalg/petsc.hpp"
#include "mesh/hex_mesh.hpp"

namespace fbi::fluid {

/// A zero vector with four unknowns a node: owned nodes first, then ghosts, in the order of the mesh's local nodes.
/// Collective.
linalg::VecHandle create_ghosted(const mesh::HexMesh& mesh);

/// Ghosts = values of their owners. Collective.
void update_ghosts(Vec vector);
/// Owners += values of their ghosts. Collective.
void add_ghosts(Vec vector);

/// The local array (owned and ghost entries) of a ghosted vector while this object lives.
class LocalArray {
 public:
  explicit LocalArray(Vec vector) : vector_(vector) {
    FBI_PETSC(VecGhostGetLocalForm(vector_, &local_));
    FBI_PETSC(VecGetArray(local_, &array_));
  }
  ~LocalArray() {
    VecRestoreArray(local_, &array_);
    VecGhostRestoreLocalForm(vector_, &local_);
  }
  LocalArray(const LocalArray&) = delete;
  LocalArray& operator=(const LocalArray&) = delete;
  double* data() { return array_; }
  double& operator[](std::size_t i) { return array_[i]; }

 private:
  Vec vector_;
  Vec local_ = nullptr;
  PetscScalar* array_ = nullptr;
};

}  // namespace fbi::fluid
