/// Move-only handles for PETSc objects and the check that turns a PETSc error into an Error.
#pragma once

#include <petscksp.h>
#include <petscsf.h>

#include <utility>

#include "base/error.hpp"
#include "base/types.hpp"

namespace fbi::linalg {

/// Throws Error(diverged) with the PETSc call site when `code` is not 0.
void check(PetscErrorCode code, const char* call, const char* file, int line);
#define FBI_PETSC(call) ::fbi::linalg::check((call), #call, __FILE__, __LINE__)

/// Starts PETSc (after MPI_Init) unless it runs; leaves signal handlers and floating-point traps to the program.
/// Collective.
void initialize_petsc();
/// Ends PETSc; call before MPI_Finalize. Collective.
void finalize_petsc();

/// Owns one PETSc object and destroys it with `Destroy`.
template <class T, PetscErrorCode (*Destroy)(T*)>
class Handle {
 public:
  Handle() = default;
  explicit Handle(T object) : object_(object) {}
  Handle(Handle&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(object_, other.object_);
    return *this;
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() { reset(); }
  void reset() {
    if (object_ != nullptr) Destroy(&object_);
    object_ = nullptr;
  }
  T get() const { return object_; }
  operator T() const { return object_; }
  /// Address for PETSc's create functions; destroys what was held.
  T* out() {
    reset();
    return &object_;
  }
  explicit operator bool() const { return object_ != nullptr; }

 private:
  T object_ = nullptr;
};

using VecHandle = Handle<Vec, VecDestroy>;
using MatHandle = Handle<Mat, MatDestroy>;
using KspHandle = Handle<KSP, KSPDestroy>;
using IsHandle = Handle<IS, ISDestroy>;
using ScatterHandle = Handle<VecScatter, VecScatterDestroy>;
using SfHandle = Handle<PetscSF, PetscSFDestroy>;

}  // namespace fbi::linalg
