#include "linalg/petsc.hpp"

#include <dlfcn.h>

#include <cstdlib>

#include "base/log.hpp"

namespace fbi::linalg {

void check(PetscErrorCode code, const char* call, const char* file, int line) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw Error(ExitCode::diverged,
              log::format("PETSc: %s (%s at %s:%d)", text != nullptr ? text : "unknown error", call, file, line));
}

namespace {

/// One BLAS thread a rank, unless the environment asks for another number: ranks are what fills the cores, and threads
/// that wait busily for each other in small factorisations cost several times the work.
void limit_blas_threads() {
  if (std::getenv("OPENBLAS_NUM_THREADS") != nullptr || std::getenv("OMP_NUM_THREADS") != nullptr) return;
  using SetThreads = void (*)(int);
  const auto set = reinterpret_cast<SetThreads>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
  if (set != nullptr) set(1);
}

}  // namespace

void initialize_petsc() {
  PetscBool running = PETSC_FALSE;
  PetscInitialized(&running);
  if (running) return;
  // The program has its own signal handlers; PETSc's would hide them.
  PetscOptionsSetValue(nullptr, "-no_signal_handler", "true");
  FBI_PETSC(PetscInitializeNoArguments());
  limit_blas_threads();
  PetscSetFPTrap(PETSC_FP_TRAP_OFF);
  PetscPushErrorHandler(PetscReturnErrorHandler, nullptr);
}

void finalize_petsc() {
  PetscBool running = PETSC_FALSE;
  PetscInitialized(&running);
  if (running) PetscFinalize();
}

}  // namespace fbi::linalg
