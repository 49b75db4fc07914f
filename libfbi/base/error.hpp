/// Errors and the exit codes they end a program with.
#pragma once

#include <stdexcept>
#include <string>

namespace fbi {

/// Exit codes of all three programs: a contract with scripts and Makefiles.
enum class ExitCode : int {
  ok = 0,
  usage = 1,        ///< command line or input file
  geometry = 2,     ///< geometry or mesh check
  stopped = 3,      ///< stopped early by a signal or the wall-time limit, with a checkpoint
  diverged = 4,     ///< a solver did not converge or met a non-finite number
  expectation = 5,  ///< expected values missed
  file = 6          ///< a file could not be read or written
};

/// An error a user meets. The text says what is wrong, where, and what to do about it.
///
/// Collective code throws it on every rank or on none (see `base/comm.hpp`: `agree_on_error`).
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& text) : std::runtime_error(text), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

}  // namespace fbi
