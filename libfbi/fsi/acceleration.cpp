#include "fsi/acceleration.hpp"

#include "base/error.hpp"
#include "fsi/aitken.hpp"

namespace fbi::fsi {

std::unique_ptr<Acceleration> make_acceleration(const Comm& comm, const SchemeParameters& parameters) {
  switch (parameters.scheme) {
    case Scheme::aitken:
      return std::make_unique<Aitken>(comm, parameters.relaxation);
    case Scheme::monolithic:
      break;
  }
  throw Error(ExitCode::usage, "coupling.scheme is not a partitioned scheme");
}

}  // namespace fbi::fsi
