/// Messages between the few ranks that have something to say to each other.
#pragma once

#include <cstddef>
#include <cstring>
#include <map>
#include <type_traits>
#include <vector>

#include "base/comm.hpp"

namespace fbi::search {

/// Sends arrays to chosen ranks; nobody needs to know beforehand who will send (non-blocking consensus: synchronous
/// sends followed by a non-blocking barrier). Works on a private copy of the communicator.
class SparseExchange {
 public:
  /// Duplicates the communicator. Collective.
  explicit SparseExchange(const Comm& comm);
  ~SparseExchange();
  SparseExchange(const SparseExchange&) = delete;
  SparseExchange& operator=(const SparseExchange&) = delete;

  /// The private communicator, for messages with tags from 10 on.
  const Comm& comm() const { return comm_; }

  /// Delivers out[r] to rank r and returns what arrived here by sender, ascending; empty arrays are not sent. T is
  /// trivially copyable. Cost: the messages, one reduction and one barrier; nothing on one rank. Throws Error(geometry)
  /// on all ranks when a message exceeds 2 GiB. Collective.
  template <class T>
  std::map<int, std::vector<T>> exchange(std::map<int, std::vector<T>> out) {
    static_assert(std::is_trivially_copyable_v<T>);
    std::map<int, std::vector<T>> in;
    const auto own = out.find(comm_.rank());
    if (own != out.end()) {
      if (!own->second.empty()) in[own->first] = std::move(own->second);
      out.erase(own);
    }
    if (comm_.size() == 1) return in;
    std::vector<Outgoing> messages;
    for (const auto& [rank, data] : out)
      if (!data.empty()) messages.push_back({rank, data.data(), data.size() * sizeof(T)});
    for (auto& [rank, bytes] : exchange_bytes(messages)) {
      std::vector<T>& data = in[rank];
      data.resize(bytes.size() / sizeof(T));
      std::memcpy(static_cast<void*>(data.data()), bytes.data(), bytes.size());
    }
    return in;
  }

 private:
  struct Outgoing {
    int rank;
    const void* data;
    std::size_t bytes;
  };
  std::map<int, std::vector<std::byte>> exchange_bytes(const std::vector<Outgoing>& out);

  MPI_Comm duplicate_ = MPI_COMM_NULL;
  Comm comm_;
  int tag_ = 0;  ///< alternates 0, 1: a fast rank can be at most one exchange ahead of a slow one
};

}  // namespace fbi::search
