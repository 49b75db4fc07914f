/// Interface quasi-Newton by least squares.
#pragma once

#include <deque>
#include <vector>

#include "fsi/acceleration.hpp"

namespace fbi::fsi {

/// x_{k+1} = x_k + r_k + W a with a = argmin |V a + r_k|: the columns of V are differences of r, those of W the
/// differences of H(x) that belong to them, of this step and of `reuse` steps before (Degroote, Bathe, Vierendeels
/// 2009). Columns whose part orthogonal to newer ones is less than `filter` of them are dropped (Haelterman et al.
/// 2016). Without any column x_{k+1} = x_k + omega r_k.
class IqnIls : public Acceleration {
 public:
  IqnIls(const Comm& comm, double omega, Index reuse, double filter)
      : comm_(comm), omega_(omega), filter_(filter), reuse_(reuse) {}

  void begin_step() override;
  bool advance(std::vector<double>& x, const std::vector<double>& r, const NearbyMap& nearby) override;
  double relaxation() const override { return relaxed_ ? omega_ : 1.0; }
  /// The age of every column in steps, newest column first.
  std::vector<double> history() const override;
  void set_history(const std::vector<double>& values) override;
  std::vector<std::pair<std::string, std::vector<double>*>> state() override;
  std::size_t columns() const { return columns_.size(); }

 private:
  struct Column {
    std::vector<double> residual, image;  // differences of r and of H(x)
    Index age = 0;                        // in steps
  };
  void add_column(const std::vector<double>& x, const std::vector<double>& r);

  Comm comm_;
  double omega_, filter_;
  Index reuse_;
  bool relaxed_ = false, has_last_ = false;
  std::deque<Column> columns_;  // newest first
  std::vector<double> last_residual_, last_image_;
};

}  // namespace fbi::fsi
