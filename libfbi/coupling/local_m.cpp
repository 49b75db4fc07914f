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

void RowAssembly::add(Index node, const double* value, Index stride) {
  calls_.push_back(static_cast<std::uint64_t>(node) << 32 | calls_.size());
  for (Index p = 0; p < count_; ++p) values_.push_back(value[static_cast<std::size_t>(p) * stride]);
}

void RowAssembly::finish() {
  end_group();
  first_ = -1;
  count_ = 0;
}

void RowAssembly::write_row(GlobalIndex row, const double* values) {
  if (!m_.row.empty() && m_.row.back() == row) {
    // The row that two elements share: merge two lists sorted by node.
    const std::size_t old = m_.begin[m_.begin.size() - 2];
    merged_.clear();
    std::size_t k = old;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      for (; k < m_.node.size() && m_.node[k] < nodes_[i]; ++k) merged_.emplace_back(m_.node[k], m_.value[k]);
      double value = values[i];
      if (k < m_.node.size() && m_.node[k] == nodes_[i]) value += m_.value[k++];
      merged_.emplace_back(nodes_[i], value);
    }
    for (; k < m_.node.size(); ++k) merged_.emplace_back(m_.node[k], m_.value[k]);
    m_.node.resize(old);
    m_.value.resize(old);
    for (const auto& [node, value] : merged_) {
      m_.node.push_back(node);
      m_.value.push_back(value);
    }
    m_.begin.back() = static_cast<Index>(m_.node.size());
    return;
  }
  m_.row.push_back(row);
  m_.node.insert(m_.node.end(), nodes_.begin(), nodes_.end());
  m_.value.insert(m_.value.end(), values, values + nodes_.size());
  m_.begin.push_back(static_cast<Index>(m_.node.size()));
}

void RowAssembly::end_group() {
  if (calls_.empty()) return;
  std::sort(calls_.begin(), calls_.end());
  nodes_.clear();
  for (const std::uint64_t call : calls_)
    if (const Index node = static_cast<Index>(call >> 32); nodes_.empty() || nodes_.back() != node)
      nodes_.push_back(node);
  sums_.assign(nodes_.size() * count_, 0.0);
  std::size_t place = 0;
  for (const std::uint64_t call : calls_) {
    if (nodes_[place] != static_cast<Index>(call >> 32)) ++place;
    const double* from = &values_[(call & 0xffffffff) * count_];
    for (Index p = 0; p < count_; ++p) sums_[p * nodes_.size() + place] += from[p];
  }
  for (Index p = 0; p < count_; ++p) write_row(first_ + p, &sums_[p * nodes_.size()]);
  calls_.clear();
  values_.clear();
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
      for (int a = 0; a < 8; ++a) assembly.add(nodes[a], &sums[0][a], 8);
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
    std::array<double, most_rows> value;
    for (int a = 0; a < 8; ++a) {
      for (Index p = 0; p < sample.rows; ++p) value[p] = sample.value[p] * n[a];
      assembly.add(mesh.cells[8 * static_cast<std::size_t>(cell) + a], value.data(), 1);
    }
  }
  assembly.finish();
  return failed;
}

}  // namespace fbi::coupling
