/// Acceleration of a fixed-point iteration x = H(x): a scheme only turns (x_k, r_k = H(x_k) - x_k) into x_{k+1}.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/comm.hpp"
#include "fsi/parameters.hpp"

namespace fbi::fsi {

class Acceleration {
 public:
  virtual ~Acceleration() = default;
  /// Starts the iteration of a new step; what a scheme keeps from earlier steps stays.
  virtual void begin_step() = 0;
  /// x <- x_{k+1}. `x` and `r` hold this rank's part of the vectors. Collective.
  virtual void advance(std::vector<double>& x, const std::vector<double>& r) = 0;
  /// Relaxation factor of the last advance, for reports.
  virtual double relaxation() const = 0;
  /// What a restart needs, as plain numbers that are the same on every rank.
  virtual std::vector<double> history() const = 0;
  virtual void set_history(const std::vector<double>& values) = 0;
};

/// The scheme named in the parameters. Throws Error(usage) for a scheme that is not a partitioned one.
std::unique_ptr<Acceleration> make_acceleration(const Comm& comm, const SchemeParameters& parameters);

}  // namespace fbi::fsi
