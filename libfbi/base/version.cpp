#include "base/version.hpp"

#include <mpi.h>

#include <Eigen/Core>

#include "revision.hpp"

namespace fbi {

std::string revision() { return FBI_REVISION; }

std::string version_text(const char* program) {
  char library[MPI_MAX_LIBRARY_VERSION_STRING] = "";
  int length = 0;
  MPI_Get_library_version(library, &length);
  std::string mpi(library, length);
  mpi = mpi.substr(0, mpi.find_first_of(",\n"));
  const std::string eigen = std::to_string(EIGEN_WORLD_VERSION) + "." + std::to_string(EIGEN_MAJOR_VERSION) + "." +
                            std::to_string(EIGEN_MINOR_VERSION);
  return std::string(program) + " " + FBI_VERSION + "\nrevision  " + FBI_REVISION + "\nbuild     " + FBI_BUILD_TYPE +
         ", " + FBI_COMPILER + "\nlibraries " + mpi + ", Eigen " + eigen + ", " + FBI_LIBRARIES;
}

}  // namespace fbi
