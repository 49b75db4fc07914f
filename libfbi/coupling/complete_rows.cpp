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

/// A number 0, 1, ... for the node of each entry, ascending with the solver number.
std::vector<Index> numbered_nodes(const std::vector<Entry>& entries) {
  std::vector<Index> number(entries.size());
  if (entries.empty()) return number;
  const auto [low, high] = std::minmax_element(entries.begin(), entries.end(),
                                               [](const Entry& a, const Entry& b) { return a.node < b.node; });
  const GlobalIndex first = low->node, span = high->node - first + 1;
  if (span <= 16 * static_cast<GlobalIndex>(entries.size())) {
    // Nodes of one neighborhood: a table of all numbers between.
    std::vector<Index> table(static_cast<std::size_t>(span), 0);
    for (const Entry& entry : entries) table[entry.node - first] = 1;
    Index next = 0;
    for (Index& mark : table) mark = mark != 0 ? next++ : -1;
    for (std::size_t k = 0; k < entries.size(); ++k) number[k] = table[entries[k].node - first];
    return number;
  }
  std::vector<GlobalIndex> nodes;
  nodes.reserve(entries.size());
  for (const Entry& entry : entries) nodes.push_back(entry.node);
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  for (std::size_t k = 0; k < entries.size(); ++k)
    number[k] = static_cast<Index>(std::lower_bound(nodes.begin(), nodes.end(), entries[k].node) - nodes.begin());
  return number;
}

}  // namespace

linalg::MultiplierRows complete_rows(const mesh::HexMesh& fluid, const Coupling& coupling,
                                     const std::vector<double>& weight, const std::vector<double>& sums) {
  const Comm& comm = fluid.comm;
  const LocalM& m = coupling.local_m();
  // First row of every rank: one number a rank.
  const GlobalIndex first = coupling.first_row();
  std::vector<GlobalIndex> first_row(comm.size());
  MPI_Allgather(&first, 1, MPI_INT64_T, first_row.data(), 1, MPI_INT64_T, comm.get());

  std::vector<Entry> entries;
  std::vector<int> owner;
  entries.reserve(m.value.size());
  owner.reserve(m.value.size());
  for (std::size_t i = 0; i < m.row.size(); ++i) {
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
  if (comm.size() > 1) entries = mesh::exchange(comm, mesh::make_lists(comm.size(), entries, owner)).data;
  // Entries of a row in the order of ranks (each rank sends every node of a row once), then by node: sums do not depend
  // on arrival.
  linalg::MultiplierRows rows;
  const std::size_t count = entries.size();
  std::vector<Index> begin(static_cast<std::size_t>(coupling.rows()) + 1, 0), order(count);
  for (const Entry& entry : entries) ++begin[entry.row - first + 1];
  for (Index p = 0; p < coupling.rows(); ++p) begin[p + 1] += begin[p];
  {
    std::vector<Index> next(begin.begin(), begin.end() - 1);
    for (std::size_t k = 0; k < count; ++k) order[next[entries[k].row - first]++] = static_cast<Index>(k);
  }
  const std::vector<Index> column = numbered_nodes(entries);
  rows.begin.assign(static_cast<std::size_t>(coupling.rows()) + 1, 0);
  rows.weight.assign(3 * static_cast<std::size_t>(count > 0 ? *std::max_element(column.begin(), column.end()) + 1 : 0),
                     0.0);
  if (!sums.empty()) rows.others.assign(rows.weight.size() / 3, 0.0);
  for (Index p = 0; p < coupling.rows(); ++p) {
    std::stable_sort(order.begin() + begin[p], order.begin() + begin[p + 1],
                     [&](Index a, Index b) { return column[a] < column[b]; });
    for (Index k = begin[p]; k < begin[p + 1]; ++k) {
      const Entry& entry = entries[order[k]];
      const Index node = column[order[k]];
      if (k > begin[p] && rows.column.back() == node) {
        rows.value.back() += entry.value;
        continue;
      }
      rows.column.push_back(node);
      rows.value.push_back(entry.value);
      for (int i = 0; i < 3; ++i) rows.weight[3 * static_cast<std::size_t>(node) + i] = entry.weight[i];
      if (!sums.empty()) rows.others[node] = entry.sum;
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
