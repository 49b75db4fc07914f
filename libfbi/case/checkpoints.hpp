/// Saves and restores the whole state of a case, on any number of ranks.
#pragma once

#include "case/setup.hpp"
#include "io/run_paths.hpp"

namespace fbi::cases {

/// Writes a checkpoint of the accepted state after `step`, then drops every cache of the running program, so that going
/// on and restarting compute the same. Throws Error(file). Collective.
void save_checkpoint(Setup& setup, const io::RunPaths& paths, const std::string& json, GlobalIndex step, double time);

/// Restores the state of the checkpoint that `which` names ("last" or a step); returns its step. Throws Error.
/// Collective.
GlobalIndex load_checkpoint(Setup& setup, const io::RunPaths& paths, const std::string& json, const std::string& which);

}  // namespace fbi::cases
