/// Messages from every rank to every rank, and the even split of numbered things into contiguous chunks.
#pragma once

#include <type_traits>
#include <vector>

#include "base/comm.hpp"
#include "base/types.hpp"

namespace fbi::mesh {

/// One list for (or from) each rank, concatenated: list r is data[first[r] ... first[r+1]).
template <class T>
struct RankLists {
  std::vector<T> data;
  std::vector<int> first;  ///< shape=(ranks+1)
};

/// Sorts items into lists: item i goes to list `rank[i]`; within a list the order of the items is kept.
template <class T>
RankLists<T> make_lists(int ranks, const std::vector<T>& items, const std::vector<int>& rank) {
  RankLists<T> lists;
  lists.first.assign(static_cast<std::size_t>(ranks) + 1, 0);
  for (const int r : rank) ++lists.first[r + 1];
  for (int r = 0; r < ranks; ++r) lists.first[r + 1] += lists.first[r];
  std::vector<int> next(lists.first.begin(), lists.first.end() - 1);
  lists.data.resize(items.size());
  for (std::size_t i = 0; i < items.size(); ++i) lists.data[next[rank[i]]++] = items[i];
  return lists;
}

/// Sends list r to rank r; list r of the result came from rank r. Messages are ordered by rank, never by arrival.
/// Collective.
template <class T>
RankLists<T> exchange(const Comm& comm, const RankLists<T>& send) {
  static_assert(std::is_trivially_copyable_v<T>);
  const int ranks = comm.size();
  std::vector<int> send_count(ranks), receive_count(ranks);
  for (int r = 0; r < ranks; ++r) send_count[r] = send.first[r + 1] - send.first[r];
  MPI_Alltoall(send_count.data(), 1, MPI_INT, receive_count.data(), 1, MPI_INT, comm.get());
  RankLists<T> received;
  received.first.assign(static_cast<std::size_t>(ranks) + 1, 0);
  for (int r = 0; r < ranks; ++r) received.first[r + 1] = received.first[r] + receive_count[r];
  received.data.resize(received.first[ranks]);
  MPI_Datatype type;
  MPI_Type_contiguous(sizeof(T), MPI_BYTE, &type);
  MPI_Type_commit(&type);
  MPI_Alltoallv(send.data.data(), send_count.data(), send.first.data(), type, received.data.data(),
                receive_count.data(), received.first.data(), type, comm.get());
  MPI_Type_free(&type);
  return received;
}

/// First of the things that part `part` of `parts` holds when `count` things are split evenly in order.
inline GlobalIndex even_begin(GlobalIndex count, int part, int parts) {
  return count / parts * part + count % parts * part / parts;
}

/// Begins of the ranks' chunks, shape=(ranks+1), from the first number and the length of this rank's chunk. Collective.
inline std::vector<GlobalIndex> chunk_begins(const Comm& comm, GlobalIndex begin, GlobalIndex total) {
  std::vector<GlobalIndex> begins(static_cast<std::size_t>(comm.size()) + 1, total);
  MPI_Allgather(&begin, 1, MPI_INT64_T, begins.data(), 1, MPI_INT64_T, comm.get());
  return begins;
}

/// Rank whose chunk [begins[r], begins[r+1]) holds `number`.
inline int chunk_rank(const std::vector<GlobalIndex>& begins, GlobalIndex number) {
  int low = 0, high = static_cast<int>(begins.size()) - 1;
  while (high - low > 1) {
    const int middle = (low + high) / 2;
    (begins[middle] <= number ? low : high) = middle;
  }
  return low;
}

}  // namespace fbi::mesh
