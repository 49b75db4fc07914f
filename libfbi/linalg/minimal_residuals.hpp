/// Minimal residuals for short iterations on small vectors that ranks share out.
#pragma once

#include <vector>

#include "base/comm.hpp"

namespace fbi::linalg {

/// T x = b by minimal residuals over directions z_0, z_1, ... that the caller chooses and multiplies (GCR: Eisenstat,
/// Elman, Schultz 1983). x is the caller's to put together, since directions may be known in more than one form. One
/// reduction a step: a residual has nothing of earlier products, and what is left of a new one follows from its parts.
class MinimalResiduals {
 public:
  enum class State { goes_on, enough, nothing_new, not_finite };

  /// Forgets the directions; their room is kept.
  void start() { used_ = 0; }
  /// For T z of the next direction.
  std::vector<double>& product();
  /// Takes product() along: rest, the residual before, becomes that after. `enough` once it is below `tolerance` times
  /// that of the first step; a product that earlier ones hold, or numbers that are not finite, are left out. The same
  /// on all ranks. Collective.
  State step(const Comm& comm, std::vector<double>& rest, double tolerance);
  /// c of x = sum_i c_i z_i over the directions that were taken along, in their order.
  std::vector<double> coefficients() const;

 private:
  struct Column {
    std::vector<double> product;  // orthogonal to earlier ones
    double squared_norm = 0.0, coefficient = 0.0;
    std::vector<double> parts;  // what T z had of earlier products
  };
  std::vector<Column> columns_;
  int used_ = 0;
  double first_ = 0.0;  // squared residual before the first step
};

}  // namespace fbi::linalg
