/// Local arrays of PETSc vectors, given back at the end of a scope.
#pragma once

#include "linalg/petsc.hpp"

namespace fbi::linalg {

/// Local entries of a vector for reading.
class Read {
 public:
  explicit Read(Vec v) : v_(v) { FBI_PETSC(VecGetArrayRead(v_, &data_)); }
  ~Read() { VecRestoreArrayRead(v_, &data_); }
  Read(const Read&) = delete;
  Read& operator=(const Read&) = delete;
  const double* get() const { return data_; }

 private:
  Vec v_;
  const double* data_ = nullptr;
};

/// Local entries of a vector for writing.
class Write {
 public:
  explicit Write(Vec v) : v_(v) { FBI_PETSC(VecGetArray(v_, &data_)); }
  ~Write() { VecRestoreArray(v_, &data_); }
  Write(const Write&) = delete;
  Write& operator=(const Write&) = delete;
  double* get() const { return data_; }

 private:
  Vec v_;
  double* data_ = nullptr;
};

/// Ghosted form of a vector: owned entries, then ghosts.
class GhostedForm {
 public:
  explicit GhostedForm(Vec v) : v_(v) { FBI_PETSC(VecGhostGetLocalForm(v_, &local_)); }
  ~GhostedForm() { VecGhostRestoreLocalForm(v_, &local_); }
  GhostedForm(const GhostedForm&) = delete;
  GhostedForm& operator=(const GhostedForm&) = delete;
  Vec get() const { return local_; }

 private:
  Vec v_;
  Vec local_ = nullptr;
};

}  // namespace fbi::linalg
