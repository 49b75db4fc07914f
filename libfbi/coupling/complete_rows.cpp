#include "coupling/complete_rows.hpp"

#include <algorithm>

#include "base/timer.hpp"
#include "mesh/exchange.hpp"

namespace fbi::coupling {
namespace {

/// One entry of M on its way to the rank of its row.
struct Entry {
  GlobalIndex row;
  GlobalIndex node;  // solver number
  double value;
  double weight[3];
};

}  // namespace

linalg::MultiplierRows complete_rows(const mesh::HexMesh& fluid, const Coupling& coupling,
                                     const std::vector<double>& weight) {
  Timed timed("complete rows");
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
                         {weight[3 * node], weight[3 * node + 1], weight[3 * node + 2]}});
      owner.push_back(rank);
    }
  }
  entries = mesh::exchange(comm, mesh::make_lists(comm.size(), entries, owner)).data;
  // They came in rank order; a stable sort keeps that order within an entry, so sums do not depend on arrival.
  std::stable_sort(entries.begin(), entries.end(),
                   [](const Entry& a, const Entry& b) { return a.row != b.row ? a.row < b.row : a.node < b.node; });
  std::vector<GlobalIndex> nodes;
  nodes.reserve(entries.size());
  for (const Entry& entry : entries) nodes.push_back(entry.node);
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());

  linalg::MultiplierRows rows;
  rows.begin.assign(static_cast<std::size_t>(coupling.rows()) + 1, 0);
  rows.weight.assign(3 * nodes.size(), 0.0);
  for (std::size_t k = 0; k < entries.size(); ++k) {
    const Entry& entry = entries[k];
    if (k > 0 && entries[k - 1].row == entry.row && entries[k - 1].node == entry.node) {
      rows.value.back() += entry.value;
      continue;
    }
    const std::size_t column = std::lower_bound(nodes.begin(), nodes.end(), entry.node) - nodes.begin();
    rows.column.push_back(static_cast<Index>(column));
    rows.value.push_back(entry.value);
    for (int i = 0; i < 3; ++i) rows.weight[3 * column + i] = entry.weight[i];
    ++rows.begin[entry.row - first + 1];
  }
  for (Index p = 0; p < coupling.rows(); ++p) rows.begin[p + 1] += rows.begin[p];
  return rows;
}

}  // namespace fbi::coupling
