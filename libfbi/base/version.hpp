/// What `--version` prints.
#pragma once

#include <string>

namespace fbi {

/// Git revision of the sources, "-dirty" where they were changed; "unknown" outside a git checkout.
std::string revision();

/// Name and version of a program, git revision, build type, compiler and the libraries it is built with; several lines.
std::string version_text(const char* program);

}  // namespace fbi
