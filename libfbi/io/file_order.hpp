/// From the ranks' own order to the order of the file and back.
#pragma once

#include <vector>

#include "base/comm.hpp"
#include "base/types.hpp"
#include "mesh/exchange.hpp"
#include "mesh/fiber_mesh.hpp"
#include "mesh/hex_mesh.hpp"

namespace fbi::io {

/// Rows that ranks own in any order, moved to contiguous chunks [begin, begin + count) of the file order.
///
/// The numbers of all ranks together are 0 ... total-1, each once. Nothing is gathered on one rank.
class FileOrder {
 public:
  /// `numbers`: file number of each row of this rank. Collective.
  FileOrder(const Comm& comm, const std::vector<GlobalIndex>& numbers, GlobalIndex total)
      : comm_(comm),
        total_(total),
        begin_(mesh::even_begin(total, comm.rank(), comm.size())),
        count_(mesh::even_begin(total, comm.rank() + 1, comm.size()) - begin_) {
    std::vector<GlobalIndex> begins(static_cast<std::size_t>(comm.size()) + 1);
    for (int r = 0; r <= comm.size(); ++r) begins[r] = mesh::even_begin(total, r, comm.size());
    rank_.reserve(numbers.size());
    for (const GlobalIndex number : numbers) rank_.push_back(mesh::chunk_rank(begins, number));
    const mesh::RankLists<GlobalIndex> mine = mesh::make_lists(comm.size(), numbers, rank_);
    first_ = mine.first;
    const mesh::RankLists<GlobalIndex> theirs = mesh::exchange(comm, mine);
    file_first_ = theirs.first;
    for (const GlobalIndex number : theirs.data) file_row_.push_back(static_cast<Index>(number - begin_));
  }

  GlobalIndex total() const { return total_; }
  GlobalIndex begin() const { return begin_; }
  GlobalIndex count() const { return count_; }

  /// Rows of this rank's chunk of the file, shape=(count,components); row i of this rank starts at
  /// values[i * stride + offset]. Collective.
  template <class T>
  std::vector<T> to_file(const T* values, int components, int stride, int offset) const {
    mesh::RankLists<T> send = lists<T>(first_, components);
    std::vector<int> next(first_.begin(), first_.end() - 1);
    for (std::size_t i = 0; i < rank_.size(); ++i) {
      T* row = &send.data[static_cast<std::size_t>(next[rank_[i]]++) * components];
      for (int c = 0; c < components; ++c) row[c] = values[i * stride + offset + c];
    }
    const mesh::RankLists<T> received = mesh::exchange(comm_, send);
    std::vector<T> rows(static_cast<std::size_t>(count_) * components);
    for (std::size_t i = 0; i < file_row_.size(); ++i)
      for (int c = 0; c < components; ++c)
        rows[static_cast<std::size_t>(file_row_[i]) * components + c] = received.data[i * components + c];
    return rows;
  }
  template <class T>
  std::vector<T> to_file(const std::vector<T>& values, int components) const {
    return to_file(values.data(), components, components, 0);
  }

  /// The reverse: this rank's rows, shape=(rows,components), from its chunk of the file. Collective.
  template <class T>
  std::vector<T> from_file(const std::vector<T>& rows, int components) const {
    mesh::RankLists<T> send = lists<T>(file_first_, components);
    for (std::size_t i = 0; i < file_row_.size(); ++i)
      for (int c = 0; c < components; ++c)
        send.data[i * components + c] = rows[static_cast<std::size_t>(file_row_[i]) * components + c];
    const mesh::RankLists<T> received = mesh::exchange(comm_, send);
    std::vector<int> next(first_.begin(), first_.end() - 1);
    std::vector<T> values(rank_.size() * components);
    for (std::size_t i = 0; i < rank_.size(); ++i) {
      const T* row = &received.data[static_cast<std::size_t>(next[rank_[i]]++) * components];
      for (int c = 0; c < components; ++c) values[i * components + c] = row[c];
    }
    return values;
  }

 private:
  template <class T>
  static mesh::RankLists<T> lists(const std::vector<int>& first, int components) {
    mesh::RankLists<T> lists;
    for (const int f : first) lists.first.push_back(f * components);
    lists.data.resize(static_cast<std::size_t>(lists.first.back()));
    return lists;
  }

  Comm comm_;
  GlobalIndex total_, begin_, count_;
  std::vector<int> rank_;        // rank of the chunk of each own row
  std::vector<int> first_;       // own rows sorted by that rank: begins
  std::vector<int> file_first_;  // rows received from each rank: begins
  std::vector<Index> file_row_;  // place of each received row in the chunk
};

/// File order of the owned nodes of a mesh; rows of images are zero in a file. Collective.
FileOrder node_order(const mesh::HexMesh& mesh);
/// File order of the owned nodes and of the images that this rank writes (the local nodes right after the owned ones).
/// Collective.
FileOrder output_order(const mesh::HexMesh& mesh);
/// File order of the nodes of the fibers. Collective.
FileOrder fiber_node_order(const mesh::FiberMesh& fibers);

}  // namespace fbi::io
