/// Translation between two faces of a periodic pair.
#pragma once

#include <string>

#include "mesh/hex_mesh.hpp"

namespace fbi::mesh {

/// The vector by which the face set `from` must be moved to lie on the face set `to` [length]: the difference of the
/// means of their face corners, which match one by one. Collective.
Vec3 face_translation(const HexMesh& mesh, const std::string& from, const std::string& to);

}  // namespace fbi::mesh
