#include "coupling/complete_rows.hpp"

#include <algorithm>
#include <cmath>

#include "mesh/exchange.hpp"

namespace fbi::coupling {
namespace {

/// One entry of M on its way to the rank of its row.
struct Entry {
  GlobalIndex row;
  GlobalIndex node;  // solver number
  double value;
  double weight[3];
  double sum;  // of the column over the rows of all ranks
};

/// Numbers 0, 1, ... for nodes, ascending with the solver number.
class Numbering {
 public:
  explicit Numbering(std::vector<GlobalIndex> nodes) {
    if (nodes.empty()) return;
    const auto [low, high] = std::minmax_element(nodes.begin(), nodes.end());
    first_ = *low;
    const GlobalIndex span = *high - first_ + 1;
    if (span <= 16 * static_cast<GlobalIndex>(nodes.size())) {
      // Nodes of one neighborhood: a table of all numbers between.
      table_.assign(static_cast<std::size_t>(span), 0);
      for (const GlobalIndex node : nodes) table_[node - first_] = 1;
      for (Index& mark : table_) mark = mark != 0 ? count_++ : -1;
      return;
    }
    std::sort(nodes.begin(), nodes.end());
    nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
    count_ = static_cast<Index>(nodes.size());
    sorted_ = std::move(nodes);
  }
  Index operator[](GlobalIndex node) const {
    if (!table_.empty()) return table_[node - first_];
    return static_cast<Index>(std::lower_bound(sorted_.begin(), sorted_.end(), node) - sorted_.begin());
  }
  Index count() const { return count_; }

 private:
  GlobalIndex first_ = 0;
  Index count_ = 0;
  std::vector<Index> table_;
  std::vector<GlobalIndex> sorted_;
};

}  // namespace

linalg::MultiplierRows complete_rows(const mesh::HexMesh& fluid, const Coupling& coupling,
                                     const std::vector<double>& weight, const std::vector<double>& sums) {
  const Comm& comm = fluid.comm;
  const LocalM& m = coupling.local_m();
  // First row of every rank: one number a rank.
  const GlobalIndex first = coupling.first_row();
  std::vector<GlobalIndex> first_row(comm.size());
  MPI_Allgather(&first, 1, MPI_INT64_T, first_row.data(), 1, MPI_INT64_T, comm.get());

  // Entries of rows of other ranks go there, own ones stay.
  const GlobalIndex last = first + coupling.rows();
  const auto is_own = [&](GlobalIndex row) { return row >= first && row < last; };
  std::vector<Entry> entries;
  std::vector<int> owner;
  std::vector<GlobalIndex> nodes;
  nodes.reserve(m.value.size());
  for (std::size_t i = 0; i < m.row.size(); ++i) {
    if (is_own(m.row[i])) {
      for (Index k = m.begin[i]; k < m.begin[i + 1]; ++k) nodes.push_back(fluid.node_number[m.node[k]]);
      continue;
    }
    const int rank =
        static_cast<int>(std::upper_bound(first_row.begin(), first_row.end(), m.row[i]) - first_row.begin()) - 1;
    for (Index k = m.begin[i]; k < m.begin[i + 1]; ++k) {
      const std::size_t node = m.node[k];
      entries.push_back({m.row[i],
                         fluid.node_number[node],
                         m.value[k],
                         {weight[3 * node], weight[3 * node + 1], weight[3 * node + 2]},
                         sums.empty() ? 0.0 : sums[node]});
      owner.push_back(rank);
    }
  }
  mesh::RankLists<Entry> arrived;
  if (comm.size() > 1) arrived = mesh::exchange(comm, mesh::make_lists(comm.size(), entries, owner));
  for (const Entry& entry : arrived.data) nodes.push_back(entry.node);
  const Numbering column(std::move(nodes));

  linalg::MultiplierRows rows;
  rows.weight.assign(3 * static_cast<std::size_t>(column.count()), 0.0);
  if (!sums.empty()) rows.others.assign(column.count(), 0.0);
  if (comm.size() > 1) rows.name.assign(column.count(), 0);
  // Entries of a row in the order of ranks (each rank has every node of a row once): sums do not depend on arrival.
  struct Part {
    Index column;
    double value;
  };
  std::vector<Index> begin(static_cast<std::size_t>(coupling.rows()) + 1, 0);
  for (std::size_t i = 0; i < m.row.size(); ++i)
    if (is_own(m.row[i])) begin[m.row[i] - first + 1] += m.begin[i + 1] - m.begin[i];
  for (const Entry& entry : arrived.data) ++begin[entry.row - first + 1];
  for (Index p = 0; p < coupling.rows(); ++p) begin[p + 1] += begin[p];
  std::vector<Part> parts(begin.back());
  {
    std::vector<Index> next(begin.begin(), begin.end() - 1);
    const auto add = [&](GlobalIndex row, GlobalIndex node, double value, const double* w, double sum) {
      const std::size_t c = column[node];
      parts[next[row - first]++] = {static_cast<Index>(c), value};
      for (int i = 0; i < 3; ++i) rows.weight[3 * c + i] = w[i];
      if (!sums.empty()) rows.others[c] = sum;
      if (!rows.name.empty()) rows.name[c] = node;
    };
    const auto add_arrived = [&](int from, int to) {
      if (arrived.data.empty()) return;
      for (int k = arrived.first[from]; k < arrived.first[to]; ++k) {
        const Entry& entry = arrived.data[k];
        add(entry.row, entry.node, entry.value, entry.weight, entry.sum);
      }
    };
    add_arrived(0, comm.rank());
    for (std::size_t i = 0; i < m.row.size(); ++i) {
      if (!is_own(m.row[i])) continue;
      for (Index k = m.begin[i]; k < m.begin[i + 1]; ++k) {
        const std::size_t node = m.node[k];
        add(m.row[i], fluid.node_number[node], m.value[k], &weight[3 * node], sums.empty() ? 0.0 : sums[node]);
      }
    }
    add_arrived(comm.rank(), comm.size());
  }
  rows.begin.assign(static_cast<std::size_t>(coupling.rows()) + 1, 0);
  rows.column.reserve(parts.size());
  rows.value.reserve(parts.size());
  for (Index p = 0; p < coupling.rows(); ++p) {
    const auto from = parts.begin() + begin[p], to = parts.begin() + begin[p + 1];
    const auto before = [](const Part& a, const Part& b) { return a.column < b.column; };
    if (!std::is_sorted(from, to, before)) std::stable_sort(from, to, before);
    for (auto part = from; part != to; ++part) {
      if (part != from && rows.column.back() == part->column) {
        rows.value.back() += part->value;
        continue;
      }
      rows.column.push_back(part->column);
      rows.value.push_back(part->value);
    }
    rows.begin[p + 1] = static_cast<Index>(rows.column.size());
  }
  // What is left of the sums without the rows of this rank; round-off of columns that are its own alone is none.
  if (!sums.empty()) {
    const std::vector<double> all = rows.others;
    for (std::size_t k = 0; k < rows.column.size(); ++k) rows.others[rows.column[k]] -= rows.value[k];
    for (std::size_t c = 0; c < all.size(); ++c)
      if (std::abs(rows.others[c]) < 1e-12 * std::abs(all[c])) rows.others[c] = 0.0;
  }
  return rows;
}

}  // namespace fbi::coupling
