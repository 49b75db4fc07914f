/// Newton's method on r(x) = H(x) - x with a Jacobian known by its products alone.
#pragma once

#include <functional>
#include <vector>

#include "fsi/acceleration.hpp"

namespace fbi::fsi {

/// What a solve on the interface reports.
struct InterfaceSolve {
  int iterations = 0;
  bool evaluated = true;  ///< false on all ranks: a product could not be evaluated
};

/// GMRES without restarts for distributed vectors: x of J x = b from x = 0 until |b - J x| <= tolerance |b| or
/// `maximum` products were made. `product(y, out)` sets out = J y and returns false when it cannot. Collective.
InterfaceSolve interface_gmres(const Comm& comm,
                               const std::function<bool(const std::vector<double>&, std::vector<double>&)>& product,
                               const std::vector<double>& b, double tolerance, int maximum, std::vector<double>& x);

/// x_{k+1} = x_k + dx with J dx = -r, J = dr/dx applied by differences: J y = (H(x + delta y) - (x + delta y) -
/// r)/delta with delta = gamma (gamma + |x|/|y|) (Knoll and Keyes 2004; Hagemeyer, Mayr, Popp 2024, eqs. 15 to 17).
class NewtonKrylov : public Acceleration {
 public:
  /// `tolerance`: |J dx + r| over |r|; `maximum`: dimension of the Krylov space.
  NewtonKrylov(const Comm& comm, double gamma, double tolerance, Index maximum)
      : comm_(comm), gamma_(gamma), tolerance_(tolerance), maximum_(maximum) {}

  void begin_step() override {}
  bool advance(std::vector<double>& x, const std::vector<double>& r, const NearbyMap& nearby) override;
  double relaxation() const override { return 1.0; }
  int krylov_iterations() const override { return iterations_; }

 private:
  Comm comm_;
  double gamma_, tolerance_;
  Index maximum_;
  int iterations_ = 0;
};

}  // namespace fbi::fsi
