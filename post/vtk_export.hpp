/// VTK XML files that need nothing besides: no HDF5, no XDMF reader.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "post/outputs.hpp"
#include "post/reader.hpp"

namespace fbi::post {

/// What is exported.
struct VtkOptions {
  OutputChoice at;      ///< nothing chosen: all outputs
  bool single = false;  ///< values as 4-byte numbers (coordinates too); half the size
};

/// Writes BASE.vtk/000050.fluid.vtu (hexahedra with all fields of the nodes; tensors in VTK's order xx, yy, zz, xy, yz,
/// xz) and BASE.vtk/000050.fibers.vtp (a polyline for each fiber, with displacement and the fields of its points, and
/// as cell data fiber, group and radius) for each output, and BASE.pvd, the series with its times: part 0 the fluid,
/// part 1 the fibers. Arrays are raw appended data; every file holds its mesh. Returns the files' paths, the series
/// first. Throws Error(usage) for an output that is not there, Error(file).
std::vector<std::string> write_vtk(const std::string& base, const Run& run, const VtkOptions& options);

}  // namespace fbi::post
