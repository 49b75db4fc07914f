#include "fsi/acceleration.hpp"

#include "base/error.hpp"
#include "fsi/aitken.hpp"
#include "fsi/constant_relaxation.hpp"
#include "fsi/iqn_ils.hpp"
#include "fsi/newton_krylov.hpp"

namespace fbi::fsi {

std::unique_ptr<Acceleration> make_acceleration(const Comm& comm, const SchemeParameters& parameters) {
  switch (parameters.scheme) {
    case Scheme::constant:
      return std::make_unique<ConstantRelaxation>(parameters.relaxation);
    case Scheme::aitken:
      return std::make_unique<Aitken>(comm, parameters.relaxation);
    case Scheme::newton_krylov:
      return std::make_unique<NewtonKrylov>(comm, parameters.gamma, parameters.krylov_tolerance,
                                            parameters.krylov_iterations);
    case Scheme::iqn_ils:
      return std::make_unique<IqnIls>(comm, parameters.relaxation, parameters.reuse, parameters.filter);
    case Scheme::monolithic:
      break;
  }
  throw Error(ExitCode::usage, "coupling.scheme is not a partitioned scheme");
}

double dot(const Comm& comm, const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return comm.sum(sum);
}

}  // namespace fbi::fsi
