/// The XDMF description of a run, for ParaView and its like.
#pragma once

#include <string>
#include <vector>

#include "base/types.hpp"

namespace fbi::io {

/// One field of the step files: dataset /fluid/NAME or /fibers/NAME.
struct XdmfField {
  std::string name;
  int components = 1;  ///< 1, 3, or 6: a symmetric tensor xx, xy, xz, yy, yz, zz
};

/// Sizes of a run; a part without cells (fibers) is left out.
struct XdmfContent {
  std::string folder;  ///< NAME.run, relative to the XDMF file
  GlobalIndex nodes = 0, cells = 0;
  GlobalIndex fibers = 0, points = 0;
  int integer_bytes = 4;  ///< of the topology arrays
};

/// One output step.
struct StepTime {
  GlobalIndex step = 0;
  double time = 0.0;
};

/// An output step with the fields in its file.
struct XdmfStep : StepTime {
  std::vector<XdmfField> fluid, fiber;
};

/// A temporal collection of spatial collections {fluid, fibers}; heavy data stay in FOLDER/mesh.h5 and FOLDER/STEP.h5.
std::string xdmf_text(const XdmfContent& content, const std::vector<XdmfStep>& steps);

}  // namespace fbi::io
