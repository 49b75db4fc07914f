#include "base/comm.hpp"

#include "base/error.hpp"

namespace fbi {
namespace {

template <class T>
T reduce(T value, MPI_Datatype type, MPI_Op operation, MPI_Comm comm) {
  T result{};
  MPI_Allreduce(&value, &result, 1, type, operation, comm);
  return result;
}

}  // namespace

Comm::Comm(MPI_Comm comm) : comm_(comm) {
  MPI_Comm_rank(comm_, &rank_);
  MPI_Comm_size(comm_, &size_);
}

double Comm::sum(double value) const { return reduce(value, MPI_DOUBLE, MPI_SUM, comm_); }
GlobalIndex Comm::sum(GlobalIndex value) const { return reduce(value, MPI_INT64_T, MPI_SUM, comm_); }
double Comm::max(double value) const { return reduce(value, MPI_DOUBLE, MPI_MAX, comm_); }
double Comm::min(double value) const { return reduce(value, MPI_DOUBLE, MPI_MIN, comm_); }
GlobalIndex Comm::max(GlobalIndex value) const { return reduce(value, MPI_INT64_T, MPI_MAX, comm_); }
bool Comm::any(bool value) const { return reduce(value ? 1 : 0, MPI_INT, MPI_MAX, comm_) != 0; }

GlobalIndex Comm::sum_before(GlobalIndex value) const {
  GlobalIndex result = 0;
  MPI_Exscan(&value, &result, 1, MPI_INT64_T, MPI_SUM, comm_);
  return rank_ == 0 ? 0 : result;
}

void Comm::sum(double* values, int count) const {
  MPI_Allreduce(MPI_IN_PLACE, values, count, MPI_DOUBLE, MPI_SUM, comm_);
}

void agree_on_error(const Comm& comm, ExitCode code, const std::string& text) {
  const int mine = text.empty() ? comm.size() : comm.rank();
  int first = 0;
  MPI_Allreduce(&mine, &first, 1, MPI_INT, MPI_MIN, comm.get());
  if (first == comm.size()) return;
  int message[2] = {static_cast<int>(text.size()), static_cast<int>(code)};
  MPI_Bcast(message, 2, MPI_INT, first, comm.get());
  std::string agreed = text;
  agreed.resize(message[0]);
  MPI_Bcast(agreed.data(), message[0], MPI_CHAR, first, comm.get());
  throw Error(static_cast<ExitCode>(message[1]), agreed);
}

}  // namespace fbi
