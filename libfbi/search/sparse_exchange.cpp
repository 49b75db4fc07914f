#include "search/sparse_exchange.hpp"

#include <limits>

#include "base/error.hpp"

namespace fbi::search {

namespace {

MPI_Comm duplicate(MPI_Comm comm) {
  MPI_Comm copy = MPI_COMM_NULL;
  MPI_Comm_dup(comm, &copy);
  return copy;
}

}  // namespace

SparseExchange::SparseExchange(const Comm& comm) : duplicate_(duplicate(comm.get())), comm_(duplicate_) {}

SparseExchange::~SparseExchange() {
  int finalized = 0;
  MPI_Finalized(&finalized);
  if (!finalized) MPI_Comm_free(&duplicate_);
}

std::map<int, std::vector<std::byte>> SparseExchange::exchange_bytes(const std::vector<Outgoing>& out) {
  // A message of 2 GiB or more does not fit MPI's counts; it would take tens of millions of fiber elements at one rank.
  std::string problem;
  for (const Outgoing& message : out)
    if (message.bytes > static_cast<std::size_t>(std::numeric_limits<int>::max()))
      problem = "a message between ranks exceeds 2 GiB: use more ranks";
  agree_on_error(comm_, ExitCode::geometry, problem);

  std::vector<MPI_Request> sends(out.size(), MPI_REQUEST_NULL);
  for (std::size_t i = 0; i < out.size(); ++i)
    MPI_Issend(out[i].data, static_cast<int>(out[i].bytes), MPI_BYTE, out[i].rank, tag_, comm_.get(), &sends[i]);
  std::map<int, std::vector<std::byte>> in;
  MPI_Request barrier = MPI_REQUEST_NULL;
  bool in_barrier = false;
  for (int done = 0; !done;) {
    int arrived = 0;
    MPI_Status status;
    MPI_Iprobe(MPI_ANY_SOURCE, tag_, comm_.get(), &arrived, &status);
    if (arrived) {
      int bytes = 0;
      MPI_Get_count(&status, MPI_BYTE, &bytes);
      std::vector<std::byte>& data = in[status.MPI_SOURCE];
      data.resize(static_cast<std::size_t>(bytes));
      MPI_Recv(data.data(), bytes, MPI_BYTE, status.MPI_SOURCE, tag_, comm_.get(), MPI_STATUS_IGNORE);
    }
    if (in_barrier) {
      MPI_Test(&barrier, &done, MPI_STATUS_IGNORE);
    } else {
      int sent = 0;
      MPI_Testall(static_cast<int>(sends.size()), sends.data(), &sent, MPI_STATUSES_IGNORE);
      if (sent) {
        MPI_Ibarrier(comm_.get(), &barrier);
        in_barrier = true;
      }
    }
  }
  tag_ = 1 - tag_;
  return in;
}

}  // namespace fbi::search
