/// Acceleration of a fixed-point iteration x = H(x): a scheme only turns (x_k, r_k = H(x_k) - x_k) into x_{k+1}.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/comm.hpp"
#include "fsi/parameters.hpp"

namespace fbi::fsi {

/// h = H(x) for an x near x_k, for differences; false on all ranks when it could not be evaluated. Collective.
using NearbyMap = std::function<bool(const std::vector<double>& x, std::vector<double>& h)>;

class Acceleration {
 public:
  virtual ~Acceleration() = default;
  /// Starts the iteration of a new step; what a scheme keeps from earlier steps stays.
  virtual void begin_step() = 0;
  /// x <- x_{k+1}. `x` and `r` hold this rank's part of the vectors. Schemes that difference H ask `nearby`, all others
  /// leave it alone. False on all ranks when `nearby` failed. Collective.
  virtual bool advance(std::vector<double>& x, const std::vector<double>& r, const NearbyMap& nearby) = 0;
  /// Relaxation factor of the last advance, for reports; 1 where there is none.
  virtual double relaxation() const = 0;
  /// Krylov iterations of the last advance.
  virtual int krylov_iterations() const { return 0; }
  /// What a restart needs: plain numbers that are the same on every rank, and distributed vectors like x, which
  /// set_history makes room for.
  virtual std::vector<double> history() const { return {}; }
  virtual void set_history(const std::vector<double>& /*values*/) {}
  virtual std::vector<std::pair<std::string, std::vector<double>*>> state() { return {}; }
};

/// The scheme named in the parameters. Throws Error(usage) for a scheme that is not a partitioned one.
std::unique_ptr<Acceleration> make_acceleration(const Comm& comm, const SchemeParameters& parameters);

/// a.b over all ranks. Collective.
double dot(const Comm& comm, const std::vector<double>& a, const std::vector<double>& b);

}  // namespace fbi::fsi
