/// From the parameters of a case to its meshes.
#pragma once

#include <string>
#include <vector>

#include "case/schema.hpp"
#include "mesh/mesh_data.hpp"

namespace fbi::meshgen {

/// Everything the generator makes of a case.
struct Scene {
  mesh::HexMeshData fluid;     ///< empty without fluid
  mesh::FiberMeshData fibers;  ///< empty without fibers
};

/// Meshes the channel (or reads the mesh file) and the fibers of a case. Errors are Error(geometry): cells without
/// volume, fibers without length, fibers outside the channel (unless "outside" is "allow"), all at once, one a line.
/// What is odd but possible (crossing fibers, fibers outside that are allowed) is appended to `warnings`, one line
/// each. A mesh file is looked for relative to `folder` (with a slash at its end; empty: here).
Scene make_scene(const cases::CaseParameters& parameters, std::vector<std::string>& warnings,
                 const std::string& folder = "");

/// Throws Error(usage) when a probe names a fiber that the scene does not have, with the nearest name.
void check_probes(const cases::Output& output, const mesh::FiberMeshData& fibers);

/// A few lines about the size of the scene: nodes, cells, unknowns, fibers, cell size against fiber diameter.
std::string summary(const cases::CaseParameters& parameters, const Scene& scene);

}  // namespace fbi::meshgen
