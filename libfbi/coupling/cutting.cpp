#include "coupling/cutting.hpp"

#include <algorithm>

namespace fbi::coupling {

namespace {

constexpr double box_tolerance = 1e-8;  ///< cells enlarged for the search, in sizes of the cell: above inside_tolerance

struct Query {
  Index element;  ///< on the asking rank
  Curve curve;
};
struct Answer {
  Index element;
  Claim claim;
};
struct Delivery {
  ElementGeometry element;
  Segment segment;
};

}  // namespace

void merge_segments(const std::vector<char>& kept, const ElementSegments& moved, ElementSegments& all) {
  ElementSegments merged;
  merged.first.assign(1, 0);
  std::size_t next = 0;
  for (std::size_t e = 0; e < kept.size(); ++e) {
    const ElementSegments& from = kept[e] ? all : moved;
    const std::size_t element = kept[e] ? e : next++;
    merged.segments.insert(merged.segments.end(), from.segments.begin() + from.first[element],
                           from.segments.begin() + from.first[element + 1]);
    merged.first.push_back(static_cast<Index>(merged.segments.size()));
  }
  all = std::move(merged);
}

Cutting::Cutting(const mesh::HexMesh& mesh, search::SparseExchange& exchange, const std::vector<Vec3>& periods)
    : mesh_(mesh),
      exchange_(exchange),
      numbers_(mesh),
      bins_(exchange.comm(), mesh, box_tolerance),
      pairs_(mesh.box ? nullptr : std::make_unique<search::PairSearch>(mesh, box_tolerance)),
      location_(mesh, exchange, bins_, pairs_.get(), periods) {}

void Cutting::cut(const std::vector<ElementGeometry>& elements, ElementSegments& result) {
  result.first.assign(1, 0);
  result.segments.clear();
  if (!mesh_.box) return cut_general(elements, result);
  std::vector<Segment> segments;
  for (const ElementGeometry& element : elements) {
    cut_in_box(element.curve, *mesh_.box, segments);
    result.segments.insert(result.segments.end(), segments.begin(), segments.end());
    result.first.push_back(static_cast<Index>(result.segments.size()));
  }
}

void Cutting::place_points(const std::vector<ElementGeometry>& elements, const fem::QuadratureRule& rule,
                           ElementSegments& result) {
  const Index count = static_cast<Index>(rule.points.size());
  std::vector<Place> places;
  places.reserve(elements.size() * count);
  for (const ElementGeometry& element : elements)
    for (const double x : rule.points) places.push_back({element.curve.point(x)});
  location_.locate(places);
  result.first.assign(1, 0);
  result.segments.clear();
  for (std::size_t e = 0; e < elements.size(); ++e) {
    for (Index q = 0; q < count; ++q) {
      const double x = rule.points[q];
      result.segments.push_back({places[e * count + q].cell, x, x, 0, q});
    }
    result.first.push_back(static_cast<Index>(result.segments.size()));
  }
}

void Cutting::claim(const Curve& curve, std::vector<Claim>& claims) {
  pairs_->cells_near(curve_box(curve), near_cells_);
  for (const Index cell : near_cells_) claim_parts(curve, make_cell(mesh_, cell), mesh_.cell_id[cell], claims);
}

void Cutting::cut_general(const std::vector<ElementGeometry>& elements, ElementSegments& result) {
  const int self = exchange_.comm().rank();
  std::map<int, std::vector<Query>> queries;
  std::vector<Answer> answers;
  std::vector<int> ranks;
  std::vector<Claim> claims;
  const auto answer = [&](const Query& query, std::vector<Answer>& to) {
    claims.clear();
    claim(query.curve, claims);
    for (const Claim& c : claims) to.push_back({query.element, c});
  };
  for (std::size_t e = 0; e < elements.size(); ++e) {
    const Query query{static_cast<Index>(e), elements[e].curve};
    bins_.ranks_near(curve_box(query.curve), ranks);
    for (const int rank : ranks) {
      if (rank == self)
        answer(query, answers);
      else
        queries[rank].push_back(query);
    }
  }
  std::map<int, std::vector<Answer>> replies;
  for (const auto& [rank, list] : exchange_.exchange(std::move(queries)))
    for (const Query& query : list) answer(query, replies[rank]);
  for (const auto& [rank, list] : exchange_.exchange(std::move(replies)))
    answers.insert(answers.end(), list.begin(), list.end());

  std::stable_sort(answers.begin(), answers.end(),
                   [](const Answer& a, const Answer& b) { return a.element < b.element; });
  std::vector<Segment> segments;
  std::size_t next = 0;
  for (std::size_t e = 0; e < elements.size(); ++e) {
    claims.clear();
    for (; next < answers.size() && answers[next].element == static_cast<Index>(e); ++next)
      claims.push_back(answers[next].claim);
    resolve(claims, segments);
    result.segments.insert(result.segments.end(), segments.begin(), segments.end());
    result.first.push_back(static_cast<Index>(result.segments.size()));
  }
}

void Cutting::deliver(const std::vector<ElementGeometry>& elements, const ElementSegments& segments, Pieces& result) {
  const int self = exchange_.comm().rank();
  result.geometries = elements;
  result.pieces.clear();
  std::map<int, std::vector<Delivery>> out;
  std::vector<int> ranks;
  for (std::size_t e = 0; e < elements.size(); ++e) {
    for (Index s = segments.first[e]; s < segments.first[e + 1]; ++s) {
      const Segment& segment = segments.segments[s];
      if (segment.cell < 0) continue;
      const Index cell = numbers_.local(segment.cell);
      if (cell >= 0) {
        result.pieces.push_back({static_cast<Index>(e), cell, segment});
        continue;
      }
      // One of the ranks with a bin around the midpoint holds the cell; the others drop the message.
      search::Aabb box;
      box.include(elements[e].curve.point(0.5 * (segment.begin + segment.end)).data());
      bins_.ranks_near(box, ranks);
      for (const int rank : ranks)
        if (rank != self) out[rank].push_back({elements[e], segment});
    }
  }
  for (const auto& [rank, list] : exchange_.exchange(std::move(out))) {
    for (const Delivery& delivery : list) {
      const Index cell = numbers_.local(delivery.segment.cell);
      if (cell < 0) continue;
      if (result.geometries.empty() || result.geometries.back().row != delivery.element.row)
        result.geometries.push_back(delivery.element);
      result.pieces.push_back({static_cast<Index>(result.geometries.size()) - 1, cell, delivery.segment});
    }
  }
  const auto before = [&](const Piece& a, const Piece& b) {
    const GlobalIndex row_a = result.geometries[a.geometry].row, row_b = result.geometries[b.geometry].row;
    return row_a < row_b || (row_a == row_b && a.segment.begin < b.segment.begin);
  };
  if (!std::is_sorted(result.pieces.begin(), result.pieces.end(), before))
    std::sort(result.pieces.begin(), result.pieces.end(), before);
}

}  // namespace fbi::coupling
