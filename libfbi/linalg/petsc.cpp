#include "linalg/petsc.hpp"

#include "base/log.hpp"

namespace fbi::linalg {

void check(PetscErrorCode code, const char* call, const char* file, int line) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(code, &text, nullptr);
  throw Error(ExitCode::diverged,
              log::format("PETSc: %s (%s at %s:%d)", text != nullptr ? text : "unknown error", call, file, line));
}

void initialize_petsc() {
  PetscBool running = PETSC_FALSE;
  PetscInitialized(&running);
  if (running) return;
  // The program has its own signal handlers; PETSc's would hide them.
  PetscOptionsSetValue(nullptr, "-no_signal_handler", "true");
  FBI_PETSC(PetscInitializeNoArguments());
  PetscSetFPTrap(PETSC_FP_TRAP_OFF);
  PetscPushErrorHandler(PetscReturnErrorHandler, nullptr);
}

void finalize_petsc() {
  PetscBool running = PETSC_FALSE;
  PetscInitialized(&running);
  if (running) PetscFinalize();
}

}  // namespace fbi::linalg
