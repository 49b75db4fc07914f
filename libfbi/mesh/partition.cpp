#include "mesh/partition.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>

namespace fbi::mesh {

BoxPartition::BoxPartition(const std::array<Index, 3>& cells, int ranks) : cells_(cells) {
  cut({0, 0, 0}, cells, 0, ranks);
}

int BoxPartition::cut(std::array<Index, 3> begin, std::array<Index, 3> end, int first_rank, int ranks) {
  const int here = static_cast<int>(cuts_.size());
  cuts_.push_back({});
  cuts_[here].rank = first_rank;
  if (ranks == 1) return here;
  int axis = 0;
  for (int a = 1; a < 3; ++a)
    if (end[a] - begin[a] > end[axis] - begin[axis]) axis = a;
  const int low_ranks = ranks / 2;
  const GlobalIndex layers = end[axis] - begin[axis];
  const Index layer = begin[axis] + static_cast<Index>((2 * layers * low_ranks + ranks) / (2 * ranks));
  std::array<Index, 3> low_end = end, high_begin = begin;
  low_end[axis] = high_begin[axis] = layer;
  const int low = cut(begin, low_end, first_rank, low_ranks);
  const int high = cut(high_begin, end, first_rank + low_ranks, ranks - low_ranks);
  cuts_[here] = {axis, layer, first_rank, low, high};
  return here;
}

int BoxPartition::rank(GlobalIndex cell) const {
  const GlobalIndex row = cells_[0];
  const std::array<Index, 3> index = {static_cast<Index>(cell % row), static_cast<Index>(cell / row % cells_[1]),
                                      static_cast<Index>(cell / row / cells_[1])};
  int at = 0;
  while (cuts_[at].axis >= 0) at = index[cuts_[at].axis] < cuts_[at].layer ? cuts_[at].low : cuts_[at].high;
  return cuts_[at].rank;
}

namespace {

// An unsigned number that orders as the double does (-0 is made +0 first).
std::uint64_t ordered_bits(double value) {
  value += 0.0;
  std::uint64_t bits;
  std::memcpy(&bits, &value, sizeof bits);
  return bits >> 63 ? ~bits : bits | (std::uint64_t{1} << 63);
}

// A set of cells that goes to the ranks [first_rank, first_rank + ranks); this rank's part of it is order[begin, end).
struct CellSet {
  int first_rank, ranks;
  std::size_t begin, end;
};

struct Key {
  std::uint64_t coordinate, id;
  bool operator<(const Key& other) const {
    return coordinate != other.coordinate ? coordinate < other.coordinate : id < other.id;
  }
};

// For each set the smallest value v with count(set, v) >= target[set], the counts summed over the ranks; 64 reductions.
template <class Count>
std::vector<std::uint64_t> select(const Comm& comm, std::size_t sets, const std::vector<GlobalIndex>& target,
                                  Count count) {
  std::vector<std::uint64_t> low(sets, 0), high(sets, std::numeric_limits<std::uint64_t>::max()), middle(sets);
  std::vector<GlobalIndex> counts(sets);
  for (int bit = 0; bit < 64; ++bit) {
    for (std::size_t s = 0; s < sets; ++s) {
      middle[s] = low[s] + (high[s] - low[s]) / 2;
      counts[s] = count(s, middle[s]);
    }
    MPI_Allreduce(MPI_IN_PLACE, counts.data(), static_cast<int>(sets), MPI_INT64_T, MPI_SUM, comm.get());
    for (std::size_t s = 0; s < sets; ++s) {
      if (counts[s] >= target[s])
        high[s] = middle[s];
      else if (low[s] < high[s])
        low[s] = middle[s] + 1;
    }
  }
  return high;
}

}  // namespace

std::vector<int> bisect_centers(const Comm& comm, const std::vector<double>& centers,
                                const std::vector<GlobalIndex>& ids) {
  std::vector<std::size_t> order(ids.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::vector<Key> keys(ids.size());  // of order[i]
  std::vector<CellSet> done, sets = {{0, comm.size(), 0, ids.size()}};
  while (!sets.empty()) {
    std::vector<CellSet> divisible;
    for (const CellSet& set : sets) (set.ranks == 1 ? done : divisible).push_back(set);
    if (divisible.empty()) break;
    const std::size_t n = divisible.size();
    std::vector<double> extent(6 * n, -std::numeric_limits<double>::max());  // per set: max of -x, -y, -z, x, y, z
    std::vector<GlobalIndex> target(n);
    for (std::size_t s = 0; s < n; ++s) {
      target[s] = static_cast<GlobalIndex>(divisible[s].end - divisible[s].begin);
      for (std::size_t i = divisible[s].begin; i < divisible[s].end; ++i)
        for (int a = 0; a < 3; ++a) {
          const double x = centers[3 * order[i] + a];
          extent[6 * s + a] = std::max(extent[6 * s + a], -x);
          extent[6 * s + 3 + a] = std::max(extent[6 * s + 3 + a], x);
        }
    }
    MPI_Allreduce(MPI_IN_PLACE, extent.data(), static_cast<int>(6 * n), MPI_DOUBLE, MPI_MAX, comm.get());
    MPI_Allreduce(MPI_IN_PLACE, target.data(), static_cast<int>(n), MPI_INT64_T, MPI_SUM, comm.get());
    for (std::size_t s = 0; s < n; ++s) {
      const CellSet& set = divisible[s];
      int axis = 0;
      if (target[s] > 0)
        for (int a = 1; a < 3; ++a)
          if (extent[6 * s + 3 + a] + extent[6 * s + a] > extent[6 * s + 3 + axis] + extent[6 * s + axis]) axis = a;
      const GlobalIndex low_ranks = set.ranks / 2;
      target[s] = (2 * target[s] * low_ranks + set.ranks) / (2 * set.ranks);
      const auto key = [&](std::size_t cell) {
        return Key{ordered_bits(centers[3 * cell + axis]), static_cast<std::uint64_t>(ids[cell])};
      };
      std::sort(order.begin() + set.begin, order.begin() + set.end,
                [&](std::size_t a, std::size_t b) { return key(a) < key(b); });
      for (std::size_t i = set.begin; i < set.end; ++i) keys[i] = key(order[i]);
    }
    const auto count_to = [&](std::size_t s, const Key& last) {
      const auto begin = keys.begin() + divisible[s].begin;
      return std::upper_bound(begin, keys.begin() + divisible[s].end, last) - begin;
    };
    // First the coordinate at which the wanted number of cells is reached, then the id among equal coordinates.
    const std::vector<std::uint64_t> coordinate = select(comm, n, target, [&](std::size_t s, std::uint64_t value) {
      return count_to(s, {value, std::numeric_limits<std::uint64_t>::max()});
    });
    const std::vector<std::uint64_t> id = select(comm, n, target, [&](std::size_t s, std::uint64_t value) {
      return count_to(s, {coordinate[s], value});
    });
    sets.clear();
    for (std::size_t s = 0; s < n; ++s) {
      const CellSet& set = divisible[s];
      const std::size_t cut =
          set.begin + (target[s] == 0 ? 0 : static_cast<std::size_t>(count_to(s, {coordinate[s], id[s]})));
      sets.push_back({set.first_rank, set.ranks / 2, set.begin, cut});
      sets.push_back({set.first_rank + set.ranks / 2, set.ranks - set.ranks / 2, cut, set.end});
    }
  }
  for (const CellSet& set : sets) done.push_back(set);
  std::vector<int> rank(ids.size());
  for (const CellSet& set : done)
    for (std::size_t i = set.begin; i < set.end; ++i) rank[order[i]] = set.first_rank;
  return rank;
}

}  // namespace fbi::mesh
