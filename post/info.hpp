/// What a file holds, in words.
#pragma once

#include <string>

namespace fbi::post {

/// Describes a case, result, step, mesh or checkpoint file: sizes, provenance, times. Throws Error(file).
std::string describe_file(const std::string& path);

}  // namespace fbi::post
