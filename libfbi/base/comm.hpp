/// A communicator and the few reductions that every room needs.
#pragma once

#include <mpi.h>

#include <string>

#include "base/types.hpp"

namespace fbi {

/// A borrowed MPI communicator with its rank and size. Copying it does not duplicate the communicator.
class Comm {
 public:
  explicit Comm(MPI_Comm comm = MPI_COMM_WORLD);
  MPI_Comm get() const { return comm_; }
  int rank() const { return rank_; }
  int size() const { return size_; }

  /// Sum, smallest, largest over all ranks. Collective.
  double sum(double value) const;
  GlobalIndex sum(GlobalIndex value) const;
  double max(double value) const;
  double min(double value) const;
  GlobalIndex max(GlobalIndex value) const;
  /// True when `value` is true on some rank. Collective.
  bool any(bool value) const;
  /// Sum of `value` over the ranks before this one (0 on rank 0). Collective.
  GlobalIndex sum_before(GlobalIndex value) const;
  /// In-place sum of `count` doubles over all ranks. Collective.
  void sum(double* values, int count) const;

 private:
  MPI_Comm comm_;
  int rank_ = 0;
  int size_ = 1;
};

enum class ExitCode : int;

/// Throws Error(code, text) on every rank when `text` is not empty on some rank; the text of the lowest such rank wins.
/// Collective.
void agree_on_error(const Comm& comm, ExitCode code, const std::string& text);

}  // namespace fbi
