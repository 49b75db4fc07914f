/// Products of one small dense matrix with many lines of a field.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "base/types.hpp"

namespace fbi::linalg {

/// The change of basis y_m = sum_j q_jm x_j and back x_j = sum_m q_jm y_m along one direction of a field. Where all
/// modes are even or odd about the middle of the line, sums and differences of mirrored entries halve the work.
///
/// Fields have shape=(outer,size,inner), row-major; flops a line: 2 size^2 (size^2 when mirrored).
template <class Real>
class LineTransform {
 public:
  using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  LineTransform() = default;
  /// `q` has shape=(size,size), one mode a column. `mirrored`: the first (size+1)/2 modes are even, the others odd.
  LineTransform(const Matrix& q, bool mirrored);

  Index size() const { return size_; }
  /// `out` may be `in`.
  void forward(Index outer, Index inner, const Real* in, Real* out) const;
  void backward(Index outer, Index inner, const Real* in, Real* out) const;

 private:
  Index size_ = 0;
  bool mirrored_ = false;
  // Row k holds what entry k of the right-hand side is multiplied by; even and odd parts one after the other.
  std::vector<Real> forward_, backward_;
  mutable std::vector<Real> work_;
};

extern template class LineTransform<float>;
extern template class LineTransform<double>;

}  // namespace fbi::linalg
