#include "linalg/block_exchange.hpp"

#include <algorithm>

namespace fbi::linalg {
namespace {

constexpr int tag = 7301;

template <class Part, class Copy>
void for_runs(const Part& part, Copy copy) {
  std::size_t at = 0;
  for (Index i = 0; i < part.count[0]; ++i)
    for (Index j = 0; j < part.count[1]; ++j) {
      copy(part.first + i * part.step[0] + j * part.step[1], at);
      at += part.count[2];
    }
}

}  // namespace

template <class Real>
BlockExchange<Real>::BlockExchange(const Comm& comm, const BlockLayout& from, const BlockLayout& to)
    : comm_(comm.get()), rank_(comm.rank()) {
  from_parts_ = parts(from.blocks[rank_], from.order, to, to.order);
  to_parts_ = parts(to.blocks[rank_], to.order, from, to.order);
}

template <class Real>
std::vector<typename BlockExchange<Real>::Part> BlockExchange<Real>::parts(const IndexBlock& mine,
                                                                           const std::array<int, 3>& order,
                                                                           const BlockLayout& others,
                                                                           const std::array<int, 3>& message_order) {
  std::array<std::ptrdiff_t, 3> step{};
  step[order[2]] = 1;
  step[order[1]] = mine.extent(order[2]);
  step[order[0]] = step[order[1]] * mine.extent(order[1]);
  std::vector<Part> result;
  for (std::size_t r = 0; r < others.blocks.size(); ++r) {
    IndexBlock common;
    Part part{static_cast<int>(r), 0, {}, {}};
    for (int d = 0; d < 3; ++d) {
      common.begin[d] = std::max(mine.begin[d], others.blocks[r].begin[d]);
      common.end[d] = std::min(mine.end[d], others.blocks[r].end[d]);
    }
    if (common.size() == 0) continue;
    for (int d = 0; d < 3; ++d) part.first += (common.begin[d] - mine.begin[d]) * step[d];
    for (int k = 0; k < 3; ++k) {
      part.count[k] = common.extent(message_order[k]);
      part.step[k] = step[message_order[k]];
    }
    result.push_back(part);
  }
  return result;
}

template <class Real>
void BlockExchange<Real>::run(const std::vector<Part>& send, const Real* from, const std::vector<Part>& receive,
                              Real* to) {
  const MPI_Datatype type = sizeof(Real) == sizeof(double) ? MPI_DOUBLE : MPI_FLOAT;
  std::size_t total = 0;
  for (const Part& part : receive) total += part.size();
  received_.resize(std::max(received_.size(), total));
  total = 0;
  for (const Part& part : send) total += part.size();
  sent_.resize(std::max(sent_.size(), total));
  requests_.clear();
  std::size_t at = 0;
  for (const Part& part : receive) {
    if (part.rank != rank_) {
      requests_.emplace_back();
      MPI_Irecv(&received_[at], static_cast<int>(part.size()), type, part.rank, tag, comm_, &requests_.back());
    }
    at += part.size();
  }
  at = 0;
  const Real* own = nullptr;
  for (const Part& part : send) {
    for_runs(part, [&](std::size_t local, std::size_t in_message) {
      Real* out = &sent_[at + in_message];
      if (part.step[2] == 1)
        std::copy_n(from + local, part.count[2], out);
      else
        for (Index k = 0; k < part.count[2]; ++k) out[k] = from[local + k * part.step[2]];
    });
    if (part.rank == rank_) {
      own = &sent_[at];
    } else {
      requests_.emplace_back();
      MPI_Isend(&sent_[at], static_cast<int>(part.size()), type, part.rank, tag, comm_, &requests_.back());
    }
    at += part.size();
  }
  MPI_Waitall(static_cast<int>(requests_.size()), requests_.data(), MPI_STATUSES_IGNORE);
  at = 0;
  for (const Part& part : receive) {
    const Real* message = part.rank == rank_ ? own : &received_[at];
    for_runs(part, [&](std::size_t local, std::size_t in_message) {
      const Real* in = message + in_message;
      if (part.step[2] == 1)
        std::copy_n(in, part.count[2], to + local);
      else
        for (Index k = 0; k < part.count[2]; ++k) to[local + k * part.step[2]] = in[k];
    });
    at += part.size();
  }
}

template class BlockExchange<float>;
template class BlockExchange<double>;

}  // namespace fbi::linalg
