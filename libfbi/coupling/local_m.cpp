#include "coupling/local_m.hpp"

#include <algorithm>

#include "coupling/ring.hpp"
#include "fem/hex8.hpp"

namespace fbi::coupling {

RowAssembly::RowAssembly(LocalM& m) : m_(m) {
  m.row.clear();
  m.begin.assign(1, 0);
  m.node.clear();
  m.value.clear();
}

void RowAssembly::begin_group(GlobalIndex first, Index count) {
  if (first == first_ && count == count_) return;
  end_group();
  first_ = first;
  count_ = count;
}

void RowAssembly::add(Index p, Index node, double value) { entries_.push_back({p, node, value}); }

void RowAssembly::finish() {
  end_group();
  first_ = -1;
  count_ = 0;
}

void RowAssembly::write_row(GlobalIndex row, std::size_t begin, std::size_t end) {
  if (begin == end) return;
  if (!m_.row.empty() && m_.row.back() == row) {
    // The row that two elements share: merge two lists sorted by node.
    const std::size_t old = m_.begin[m_.begin.size() - 2];
    std::vector<std::pair<Index, double>> merged;
    std::size_t k = old;
    for (std::size_t i = begin; i < end; ++i) {
      for (; k < m_.node.size() && m_.node[k] < entries_[i].node; ++k) merged.emplace_back(m_.node[k], m_.value[k]);
      double value = entries_[i].value;
      if (k < m_.node.size() && m_.node[k] == entries_[i].node) value += m_.value[k++];
      merged.emplace_back(entries_[i].node, value);
    }
    for (; k < m_.node.size(); ++k) merged.emplace_back(m_.node[k], m_.value[k]);
    m_.node.resize(old);
    m_.value.resize(old);
    for (const auto& [node, value] : merged) {
      m_.node.push_back(node);
      m_.value.push_back(value);
    }
    m_.begin.back() = static_cast<Index>(m_.node.size());
    return;
  }
  m_.row.push_back(row);
  for (std::size_t i = begin; i < end; ++i) {
    m_.node.push_back(entries_[i].node);
    m_.value.push_back(entries_[i].value);
  }
  m_.begin.push_back(static_cast<Index>(m_.node.size()));
}

void RowAssembly::end_group() {
  std::stable_sort(entries_.begin(), entries_.end(),
                   [](const Entry& a, const Entry& b) { return a.row < b.row || (a.row == b.row && a.node < b.node); });
  std::size_t kept = 0;
  for (std::size_t i = 0; i < entries_.size(); ++i) {
    if (kept > 0 && entries_[kept - 1].row == entries_[i].row && entries_[kept - 1].node == entries_[i].node)
      entries_[kept - 1].value += entries_[i].value;
    else
      entries_[kept++] = entries_[i];
  }
  entries_.resize(kept);
  for (std::size_t begin = 0; begin < entries_.size();) {
    std::size_t end = begin;
    while (end < entries_.size() && entries_[end].row == entries_[begin].row) ++end;
    write_row(first_ + entries_[begin].row, begin, end);
    begin = end;
  }
  entries_.clear();
}

Index assemble_m(const mesh::HexMesh& mesh, const Pieces& pieces, const fem::QuadratureRule& rule, const Basis& basis,
                 LocalM& m) {
  RowAssembly assembly(m);
  Index failed = 0;
  std::vector<IntegrationPoint> points, single(1);
  std::vector<std::array<double, 8>> sums;
  for (const Piece& piece : pieces.pieces) {
    const ElementGeometry& geometry = pieces.geometries[piece.geometry];
    const Cell cell = make_cell(mesh, piece.cell);
    const Index* nodes = &mesh.cells[8 * static_cast<std::size_t>(piece.cell)];
    points.clear();
    integration_points(geometry.measure, rule, piece.segment, points);
    const auto add = [&](GlobalIndex first, Index rows, const std::vector<IntegrationPoint>& some) {
      sums.assign(rows, {});
      failed += !integrate_fluid(basis, geometry.curve, cell, some, sums);
      assembly.begin_group(first, rows);
      for (Index p = 0; p < rows; ++p)
        for (int a = 0; a < 8; ++a) assembly.add(p, nodes[a], sums[p][a]);
    };
    if (basis.is_lagrange()) {
      add(geometry.row, basis.order() + 1, points);
      continue;
    }
    for (const IntegrationPoint& point : points) {
      single[0] = point;
      single[0].number = 0;
      add(geometry.row + point.number, 1, single);
    }
  }
  assembly.finish();
  return failed;
}

namespace {

/// A point of a ring on its way to the rank of its cell. Trivially copyable.
struct Sample {
  GlobalIndex first_row;  ///< of its group
  GlobalIndex cell;
  double order;  ///< x of the integration point
  double point[3];
  double value[most_rows];  ///< Phi_p ds / (points of the ring inside)
  Index rows;               ///< of its group
  Index number;             ///< on the ring
};

/// The samples of all rings of this rank's pieces, those outside the fluid dropped. Collective.
std::vector<std::pair<Sample, int>> ring_samples(const mesh::HexMesh& mesh, const Pieces& pieces,
                                                 const fem::QuadratureRule& rule, const Basis& basis,
                                                 PointLocation& location) {
  std::vector<Place> places;
  std::vector<Sample> samples;
  std::vector<Index> first(1, 0);  // of the samples of each ring
  std::vector<Place> centers;
  const auto visit = [&](const Piece& piece, const ElementGeometry& geometry, const Cell& cell,
                         const IntegrationPoint& point) {
    const Vec3 center = geometry.curve.point(point.x);
    const Vec3 tangent = geometry.curve.slope(point.x).normalized();
    const Ring ring = make_ring(geometry.radius, size_across(cell, tangent), tangent);
    const BasisValues phi = basis.at(point.x, point.number);
    Sample sample{};
    sample.first_row = geometry.row + phi.first;
    sample.rows = phi.count;
    sample.order = point.x;
    for (int p = 0; p < phi.count; ++p) sample.value[p] = phi.value[p] * point.ds;
    for (Index q = 0; q < ring.points; ++q) {
      sample.number = q;
      samples.push_back(sample);
      places.push_back({center + ring.offset(q)});
    }
    first.push_back(static_cast<Index>(samples.size()));
    centers.push_back({center, mesh.cell_id[piece.cell], mesh.comm.rank()});
  };
  visit_points(mesh, pieces, rule, visit);
  location.locate(places);
  std::vector<std::pair<Sample, int>> inside;
  inside.reserve(samples.size());
  const auto take = [&](Sample sample, const Place& place, double share) {
    sample.cell = place.cell;
    for (int i = 0; i < 3; ++i) sample.point[i] = place.point[i];
    for (Index p = 0; p < sample.rows; ++p) sample.value[p] *= share;
    inside.emplace_back(sample, place.rank);
  };
  for (std::size_t r = 0; r < centers.size(); ++r) {
    Index count = 0;
    for (Index k = first[r]; k < first[r + 1]; ++k) count += places[k].cell >= 0;
    if (count == 0) take(samples[first[r]], centers[r], 1.0);
    for (Index k = first[r]; k < first[r + 1]; ++k)
      if (places[k].cell >= 0) take(samples[k], places[k], 1.0 / count);
  }
  return inside;
}

}  // namespace

Index assemble_ring_m(const mesh::HexMesh& mesh, const Pieces& pieces, const fem::QuadratureRule& rule,
                      const Basis& basis, Cutting& cutting, search::SparseExchange& exchange, LocalM& m) {
  std::vector<Sample> mine;
  std::map<int, std::vector<Sample>> out;
  std::vector<int> ranks;
  const int self = exchange.comm().rank();
  for (const auto& [sample, rank] : ring_samples(mesh, pieces, rule, basis, cutting.location())) {
    if (cutting.local_cell(sample.cell) >= 0) {
      mine.push_back(sample);
    } else if (rank >= 0) {
      out[rank].push_back(sample);
    } else {
      // One of the ranks with a bin around the point holds the cell; the others drop the message.
      search::Aabb box;
      box.include(sample.point);
      cutting.bins().ranks_near(box, ranks);
      for (const int near : ranks)
        if (near != self) out[near].push_back(sample);
    }
  }
  for (const auto& [rank, list] : exchange.exchange(std::move(out)))
    for (const Sample& sample : list)
      if (cutting.local_cell(sample.cell) >= 0) mine.push_back(sample);
  std::sort(mine.begin(), mine.end(), [](const Sample& a, const Sample& b) {
    if (a.first_row != b.first_row) return a.first_row < b.first_row;
    return a.order != b.order ? a.order < b.order : a.number < b.number;
  });
  RowAssembly assembly(m);
  Index failed = 0;
  for (const Sample& sample : mine) {
    const Index cell = cutting.local_cell(sample.cell);
    Vec3 xi = Vec3::Zero();
    if (!project(make_cell(mesh, cell), Vec3(sample.point[0], sample.point[1], sample.point[2]), xi)) {
      ++failed;
      continue;
    }
    assembly.begin_group(sample.first_row, sample.rows);
    const std::array<double, 8> n = fem::hex8_shape(xi);
    for (Index p = 0; p < sample.rows; ++p)
      for (int a = 0; a < 8; ++a)
        assembly.add(p, mesh.cells[8 * static_cast<std::size_t>(cell) + a], sample.value[p] * n[a]);
  }
  assembly.finish();
  return failed;
}

}  // namespace fbi::coupling
