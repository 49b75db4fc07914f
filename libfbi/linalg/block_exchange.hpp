/// Fields on index blocks that move from one distribution over the ranks to another.
#pragma once

#include <array>
#include <vector>

#include "base/comm.hpp"
#include "base/types.hpp"

namespace fbi::linalg {

/// Ranges of indices [begin, end) along three directions.
struct IndexBlock {
  std::array<Index, 3> begin = {0, 0, 0}, end = {0, 0, 0};
  Index extent(int d) const { return end[d] > begin[d] ? end[d] - begin[d] : 0; }
  std::size_t size() const { return static_cast<std::size_t>(extent(0)) * extent(1) * extent(2); }
  bool operator==(const IndexBlock& other) const = default;
};

/// Which rank holds which block, and how a rank stores its own: directions from the slowest to the fastest.
struct BlockLayout {
  std::vector<IndexBlock> blocks;  ///< shape=(ranks), disjoint
  std::array<int, 3> order = {2, 1, 0};
  bool operator==(const BlockLayout& other) const = default;
};

/// Sends a field from one layout to another; one message to every rank whose blocks intersect, none to others.
template <class Real>
class BlockExchange {
 public:
  BlockExchange() = default;
  /// The layouts are the same on all ranks; only the intersections with this rank's blocks are kept.
  BlockExchange(const Comm& comm, const BlockLayout& from, const BlockLayout& to);
  /// Collective.
  void forward(const Real* from, Real* to) { run(from_parts_, from, to_parts_, to); }
  /// The other way round. Collective.
  void backward(const Real* to, Real* from) { run(to_parts_, to, from_parts_, from); }

 private:
  struct Part {  // of this rank's block that a rank holds in the other layout
    int rank;
    std::size_t first;                   // entry of the local storage
    std::array<Index, 3> count;          // from the slowest to the fastest of the message
    std::array<std::ptrdiff_t, 3> step;  // in the local storage
    std::size_t size() const { return static_cast<std::size_t>(count[0]) * count[1] * count[2]; }
  };
  void run(const std::vector<Part>& send, const Real* from, const std::vector<Part>& receive, Real* to);
  static std::vector<Part> parts(const IndexBlock& mine, const std::array<int, 3>& order, const BlockLayout& others,
                                 const std::array<int, 3>& message_order);

  MPI_Comm comm_ = MPI_COMM_NULL;
  int rank_ = 0;
  std::vector<Part> from_parts_, to_parts_;
  std::vector<Real> sent_, received_;
  std::vector<MPI_Request> requests_;
};

extern template class BlockExchange<float>;
extern template class BlockExchange<double>;

}  // namespace fbi::linalg
