/// Checkpoints: everything a restart needs, in file order, so that any number of ranks can go on from it.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "base/comm.hpp"
#include "base/types.hpp"
#include "io/run_paths.hpp"
#include "mesh/fiber_mesh.hpp"
#include "mesh/hex_mesh.hpp"

namespace fbi::io {

/// What is the same on all ranks.
struct CheckpointHeader {
  GlobalIndex step = 0;
  double time = 0.0;
  std::string case_fingerprint;                        ///< fingerprint() of the JSON text
  std::map<std::string, double> numbers;               ///< scalars of the solvers, by name
  std::map<std::string, std::vector<double>> vectors;  ///< small arrays, the same on all ranks
};

/// A distributed array with `components` numbers per owned fluid node (or per fiber node).
struct StateArray {
  std::string name;
  int components = 1;
  std::vector<double>* values = nullptr;  ///< shape=(owned nodes,components) or (fiber nodes,components)
  bool images = false;  ///< of the fluid: rows of the images that this rank writes follow those of owned nodes
};

/// Writes the checkpoint of header.step, then removes all others but the newest before it. `fluid_mesh` and
/// `fiber_mesh` may be null when there are no such arrays. Throws Error(file), older checkpoints untouched. Collective.
void write_checkpoint(const Comm& comm, const RunPaths& paths, const CheckpointHeader& header,
                      const mesh::HexMesh* fluid_mesh, const std::vector<StateArray>& fluid,
                      const mesh::FiberMesh* fiber_mesh, const std::vector<StateArray>& fibers);

/// Step of the checkpoint that `which` names: "last" or a step number. Throws Error(usage) when `which` is neither and
/// Error(file) when there is no such checkpoint, with those that exist. Collective.
GlobalIndex find_checkpoint(const Comm& comm, const RunPaths& paths, const std::string& which);

/// Reads a checkpoint and fills the arrays bitwise as they were, on any number of ranks. Throws Error(file) also when
/// it belongs to another case than `case_fingerprint` or lacks an array. Collective.
CheckpointHeader read_checkpoint(const Comm& comm, const RunPaths& paths, GlobalIndex step,
                                 const std::string& case_fingerprint, const mesh::HexMesh* fluid_mesh,
                                 const std::vector<StateArray>& fluid, const mesh::FiberMesh* fiber_mesh,
                                 const std::vector<StateArray>& fibers);

}  // namespace fbi::io
