#include "coupling/local_m.hpp"

#include <algorithm>
#include <cmath>

namespace fbi::coupling {

namespace {

struct Entry {
  Index node;
  double value;
};

struct ElementEntry {
  Index node;
  std::array<double, rows_per_element> value;
};

void append_row(GlobalIndex row, std::vector<Entry>& entries, LocalM& m) {
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.node < b.node; });
  m.row.push_back(row);
  for (const Entry& entry : entries) {
    if (static_cast<Index>(m.node.size()) > m.begin.back() && m.node.back() == entry.node) {
      m.value.back() += entry.value;  // two elements meet at most: the order of the sum does not matter
    } else {
      m.node.push_back(entry.node);
      m.value.push_back(entry.value);
    }
  }
  m.begin.push_back(static_cast<Index>(m.node.size()));
}

}  // namespace

Index assemble_m(const mesh::HexMesh& mesh, const Pieces& pieces, const fem::QuadratureRule& rule, LocalM& m) {
  m.row.clear();
  m.begin.assign(1, 0);
  m.node.clear();
  m.value.clear();
  Index failed = 0;
  std::vector<Entry> current, following;  // rows `row` and `row`+1 of the element at hand
  std::vector<ElementEntry> element;
  GlobalIndex following_row = -1;
  const std::vector<Piece>& list = pieces.pieces;
  for (std::size_t begin = 0; begin < list.size();) {
    const ElementGeometry& geometry = pieces.geometries[list[begin].geometry];
    element.clear();
    std::size_t end = begin;
    for (; end < list.size() && pieces.geometries[list[end].geometry].row == geometry.row; ++end) {
      const Piece& piece = list[end];
      std::array<std::array<double, 8>, rows_per_element> values{};
      if (!integrate_fluid(geometry.curve, geometry.measure, make_cell(mesh, piece.cell), rule, piece.begin, piece.end,
                           values))
        ++failed;
      for (int a = 0; a < 8; ++a) {
        const Index node = mesh.cells[8 * static_cast<std::size_t>(piece.cell) + a];
        auto entry =
            std::find_if(element.begin(), element.end(), [&](const ElementEntry& e) { return e.node == node; });
        if (entry == element.end()) entry = element.insert(entry, {node, {}});
        for (int p = 0; p < rows_per_element; ++p) entry->value[p] += values[p][a];
      }
    }
    if (following_row >= 0 && following_row != geometry.row) {
      append_row(following_row, following, m);
      following.clear();
    }
    current.swap(following);
    following.clear();
    for (const ElementEntry& entry : element) {
      current.push_back({entry.node, entry.value[0]});
      following.push_back({entry.node, entry.value[1]});
    }
    append_row(geometry.row, current, m);
    current.clear();
    following_row = geometry.row + 1;
    begin = end;
  }
  if (following_row >= 0) append_row(following_row, following, m);
  return failed;
}

}  // namespace fbi::coupling
