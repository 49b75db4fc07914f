#include "coupling/point_location.hpp"

#include <algorithm>

#include "coupling/segmentation.hpp"

namespace fbi::coupling {

namespace {

struct Query {
  Index place;  ///< on the asking rank
  double point[3];
};
struct Answer {
  Index place;
  GlobalIndex cell;
};

}  // namespace

PointLocation::PointLocation(const mesh::HexMesh& mesh, search::SparseExchange& exchange, const search::RankBins& bins,
                             const search::PairSearch* pairs, const std::vector<Vec3>& periods)
    : mesh_(mesh), exchange_(exchange), bins_(bins), pairs_(pairs) {
  std::vector<Vec3> sums(1, Vec3::Zero());
  for (const Vec3& period : periods) {
    const std::size_t count = sums.size();
    for (const double sign : {1.0, -1.0})
      for (std::size_t k = 0; k < count; ++k) sums.push_back(sums[k] + sign * period);
  }
  shifts_.assign(sums.begin() + 1, sums.end());
  std::stable_sort(shifts_.begin(), shifts_.end(),
                   [](const Vec3& a, const Vec3& b) { return a.squaredNorm() < b.squaredNorm(); });
}

GlobalIndex PointLocation::local_cell(const Vec3& point) {
  search::Aabb box;
  box.include(point.data());
  pairs_->cells_near(box, near_);
  GlobalIndex lowest = -1;
  for (const Index cell : near_) {
    const GlobalIndex id = mesh_.cell_id[cell];
    if (lowest >= 0 && id > lowest) continue;
    Vec3 xi = Vec3::Zero();
    if (project(make_cell(mesh_, cell), point, xi) && is_inside(xi)) lowest = id;
  }
  return lowest;
}

void PointLocation::locate_once(std::vector<Place>& places) {
  if (mesh_.box) {
    for (Place& place : places) place.cell = cell_in_box(*mesh_.box, place.point);
    return;
  }
  const int self = exchange_.comm().rank();
  const auto take = [&](Place& place, GlobalIndex cell, int rank) {
    if (cell < 0 || (place.cell >= 0 && place.cell <= cell)) return;
    place.cell = cell;
    place.rank = rank;
  };
  std::map<int, std::vector<Query>> queries;
  std::vector<int> ranks;
  for (std::size_t i = 0; i < places.size(); ++i) {
    search::Aabb box;
    box.include(places[i].point.data());
    bins_.ranks_near(box, ranks);
    for (const int rank : ranks) {
      if (rank == self)
        take(places[i], local_cell(places[i].point), self);
      else
        queries[rank].push_back({static_cast<Index>(i), {places[i].point[0], places[i].point[1], places[i].point[2]}});
    }
  }
  std::map<int, std::vector<Answer>> replies;
  for (const auto& [rank, list] : exchange_.exchange(std::move(queries)))
    for (const Query& query : list) {
      const GlobalIndex cell = local_cell(Vec3(query.point[0], query.point[1], query.point[2]));
      if (cell >= 0) replies[rank].push_back({query.place, cell});
    }
  for (const auto& [rank, list] : exchange_.exchange(std::move(replies)))
    for (const Answer& answer : list) take(places[answer.place], answer.cell, rank);
}

void PointLocation::locate(std::vector<Place>& places) {
  locate_once(places);
  for (const Vec3& shift : shifts_) {
    std::vector<std::size_t> missing;
    std::vector<Place> moved;
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (places[i].cell >= 0) continue;
      missing.push_back(i);
      moved.push_back({places[i].point + shift});
    }
    if (!exchange_.comm().any(!missing.empty())) return;
    locate_once(moved);
    for (std::size_t k = 0; k < missing.size(); ++k)
      if (moved[k].cell >= 0) places[missing[k]] = moved[k];
  }
}

}  // namespace fbi::coupling
