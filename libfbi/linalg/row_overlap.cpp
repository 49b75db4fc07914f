#include "linalg/row_overlap.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "base/counters.hpp"
#include "mesh/exchange.hpp"

namespace fbi::linalg {
namespace {

constexpr int tag = 31;
constexpr Index most_rows = 256;  // of a dense block that leaves its rank

/// A column and a rank that has it.
struct Share {
  GlobalIndex name;
  int rank;
};

/// A block of S on its way: `numbers` of them follow in another list.
struct Head {
  Index rows;
  int dense;
};

/// An entry of M on its way, in the order of the rows of its blocks.
struct Entry {
  GlobalIndex name;
  Index row;  // of all rows that go the same way
  double value;
  double weight[3];
  double total;  // of the column over the rows of all ranks
};

Index row_of(const InterfaceBlock& block, Index i) { return block.index != nullptr ? block.index[i] : block.first + i; }

std::size_t numbers_of(Index rows, bool dense) {
  return dense ? 9 * static_cast<std::size_t>(rows) * rows : 9 * static_cast<std::size_t>(rows);
}

/// Sums of the columns over all rows.
std::vector<double> totals(const MultiplierRows& m) {
  std::vector<double> total = m.others;
  total.resize(m.columns(), 0.0);
  for (std::size_t k = 0; k < m.column.size(); ++k) total[m.column[k]] += m.value[k];
  return total;
}

}  // namespace

RowOverlap::Neighbor& RowOverlap::neighbor(int rank) {
  const auto at =
      std::lower_bound(neighbors_.begin(), neighbors_.end(), rank, [](const Neighbor& a, int r) { return a.rank < r; });
  if (at != neighbors_.end() && at->rank == rank) return *at;
  return *neighbors_.insert(at, Neighbor{rank, {}, 0, 0});
}

void RowOverlap::find_neighbors(const MultiplierRows& own, const std::vector<InterfaceBlock>& s,
                                const std::vector<GlobalIndex>& begins, std::vector<std::vector<Index>>& blocks_for) {
  // Who else has my columns? Those who keep the names know.
  std::vector<Share> mine;
  std::vector<int> keeper;
  for (Index c = 0; c < own.columns(); ++c) {
    if (own.others.empty() || own.others[c] == 0.0) continue;
    mine.push_back({own.name[c], comm_.rank()});
    keeper.push_back(mesh::chunk_rank(begins, own.name[c]));
  }
  mesh::RankLists<Share> kept = mesh::exchange(comm_, mesh::make_lists(comm_.size(), mine, keeper));
  std::stable_sort(kept.data.begin(), kept.data.end(), [](const Share& a, const Share& b) { return a.name < b.name; });
  std::vector<Share> answers;
  std::vector<int> to;
  for (std::size_t begin = 0; begin < kept.data.size();) {
    std::size_t end = begin;
    while (end < kept.data.size() && kept.data[end].name == kept.data[begin].name) ++end;
    for (std::size_t i = begin; i < end; ++i)
      for (std::size_t j = begin; j < end; ++j)
        if (i != j) {
          answers.push_back(kept.data[j]);
          to.push_back(kept.data[i].rank);
        }
    begin = end;
  }
  const mesh::RankLists<Share> shared = mesh::exchange(comm_, mesh::make_lists(comm_.size(), answers, to));
  std::unordered_map<GlobalIndex, std::vector<int>> ranks_of;
  for (const Share& share : shared.data) ranks_of[share.name].push_back(share.rank);
  blocks_for.assign(comm_.size(), {});
  for (std::size_t b = 0; b < s.size(); ++b) {
    if (s[b].dense != nullptr && s[b].rows > most_rows) {
      count_parts("large multiplier blocks known by sums", 1);
      continue;
    }
    for (Index i = 0; i < s[b].rows; ++i) {
      const Index p = row_of(s[b], i);
      for (Index k = own.begin[p]; k < own.begin[p + 1]; ++k) {
        if (own.others.empty() || own.others[own.column[k]] == 0.0) continue;
        const auto found = ranks_of.find(own.name[own.column[k]]);
        if (found == ranks_of.end()) continue;
        for (const int rank : found->second)
          if (blocks_for[rank].empty() || blocks_for[rank].back() != static_cast<Index>(b))
            blocks_for[rank].push_back(static_cast<Index>(b));
      }
    }
  }
}

RowOverlap::RowOverlap(const Comm& comm, const MultiplierRows& own, const std::vector<InterfaceBlock>& s,
                       const std::vector<GlobalIndex>& begins)
    : comm_(comm), own_rows_(own.rows()), rows_(own), blocks_(s) {
  std::vector<std::vector<Index>> blocks_for;
  find_neighbors(own, s, begins, blocks_for);
  const std::vector<double> total = totals(own);
  mesh::RankLists<Head> heads;
  mesh::RankLists<Entry> entries;
  mesh::RankLists<double> numbers;
  const auto begin_list = [&] {
    heads.first.push_back(static_cast<int>(heads.data.size()));
    entries.first.push_back(static_cast<int>(entries.data.size()));
    numbers.first.push_back(static_cast<int>(numbers.data.size()));
  };
  for (int rank = 0; rank < comm_.size(); ++rank) {
    begin_list();
    if (blocks_for[rank].empty()) continue;
    Neighbor& there = neighbor(rank);
    for (const Index b : blocks_for[rank]) {
      const InterfaceBlock& block = s[b];
      heads.data.push_back({block.rows, block.dense != nullptr ? 1 : 0});
      const double* from = block.dense != nullptr ? block.dense : block.local;
      numbers.data.insert(numbers.data.end(), from, from + numbers_of(block.rows, block.dense != nullptr));
      for (Index i = 0; i < block.rows; ++i) {
        const Index p = row_of(block, i);
        for (Index k = own.begin[p]; k < own.begin[p + 1]; ++k) {
          const std::size_t c = own.column[k];
          const double* w = &own.weight[3 * c];
          entries.data.push_back(
              {own.name[c], static_cast<Index>(there.leaving.size()), own.value[k], {w[0], w[1], w[2]}, total[c]});
        }
        there.leaving.push_back(p);
      }
    }
  }
  begin_list();
  const mesh::RankLists<Head> new_heads = mesh::exchange(comm_, heads);
  const mesh::RankLists<Entry> new_entries = mesh::exchange(comm_, entries);
  numbers_ = mesh::exchange(comm_, numbers).data;

  std::unordered_map<GlobalIndex, Index> column;
  for (Index c = 0; c < own.columns(); ++c) column.emplace(own.name[c], c);
  std::vector<double> left = total;  // of the columns, without the rows that are here
  for (std::size_t k = 0; k < own.column.size(); ++k) left[own.column[k]] -= own.value[k];
  std::vector<double> all = total;
  std::size_t number = 0;
  for (int rank = 0; rank < comm_.size(); ++rank) {
    const Index first = rows_.rows();
    for (int h = new_heads.first[rank]; h < new_heads.first[rank + 1]; ++h) {
      const Head& head = new_heads.data[h];
      InterfaceBlock& block = blocks_.emplace_back();
      block.first =
          h > new_heads.first[rank] ? blocks_[blocks_.size() - 2].first + blocks_[blocks_.size() - 2].rows : first;
      block.rows = head.rows;
      (head.dense != 0 ? block.dense : block.local) = numbers_.data() + number;
      number += numbers_of(head.rows, head.dense != 0);
    }
    if (new_heads.first[rank] == new_heads.first[rank + 1]) continue;
    Neighbor& there = neighbor(rank);
    there.first = first;
    there.arriving = blocks_.back().first + blocks_.back().rows - first;
    int k = new_entries.first[rank];
    for (Index p = 0; p < there.arriving; ++p) {
      for (; k < new_entries.first[rank + 1] && new_entries.data[k].row == p; ++k) {
        const Entry& entry = new_entries.data[k];
        const auto [at, is_new] = column.emplace(entry.name, rows_.columns());
        if (is_new) {
          rows_.weight.insert(rows_.weight.end(), entry.weight, entry.weight + 3);
          rows_.name.push_back(entry.name);
          left.push_back(entry.total);
          all.push_back(entry.total);
        }
        rows_.column.push_back(at->second);
        rows_.value.push_back(entry.value);
        left[at->second] -= entry.value;
      }
      rows_.begin.push_back(static_cast<Index>(rows_.column.size()));
    }
  }
  // Round-off of columns all of whose rows are here is nothing.
  for (std::size_t c = 0; c < left.size(); ++c)
    if (std::abs(left[c]) < 1e-12 * std::abs(all[c])) left[c] = 0.0;
  rows_.others = std::move(left);
  sent_.resize(neighbors_.size());
}

void RowOverlap::release() {
  rows_ = MultiplierRows{};
  std::vector<InterfaceBlock>().swap(blocks_);
  std::vector<double>().swap(numbers_);
}

std::vector<double>& RowOverlap::bring(const double* own) {
  std::size_t size = static_cast<std::size_t>(own_rows_);
  for (const Neighbor& there : neighbors_) size += static_cast<std::size_t>(there.arriving);
  values_.resize(3 * size);
  std::copy_n(own, 3 * static_cast<std::size_t>(own_rows_), values_.data());
  std::vector<MPI_Request> requests;
  for (const Neighbor& there : neighbors_)
    if (there.arriving > 0)
      MPI_Irecv(&values_[3 * static_cast<std::size_t>(there.first)], 3 * there.arriving, MPI_DOUBLE, there.rank, tag,
                comm_.get(), &requests.emplace_back());
  for (std::size_t i = 0; i < neighbors_.size(); ++i) {
    const Neighbor& there = neighbors_[i];
    if (there.leaving.empty()) continue;
    sent_[i].clear();
    for (const Index p : there.leaving)
      sent_[i].insert(sent_[i].end(), own + 3 * static_cast<std::size_t>(p), own + 3 * static_cast<std::size_t>(p) + 3);
    MPI_Isend(sent_[i].data(), static_cast<int>(sent_[i].size()), MPI_DOUBLE, there.rank, tag, comm_.get(),
              &requests.emplace_back());
  }
  MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE);
  return values_;
}

}  // namespace fbi::linalg
