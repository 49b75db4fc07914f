#include "coupling/interface_law.hpp"

#include <algorithm>

namespace fbi::coupling {

void OwnRadiusLaw::set_points(const Pieces& pieces, const fem::QuadratureRule& rule, const Basis& basis,
                              const std::vector<GlobalIndex>& offsets) {
  points_.clear();
  touched_.clear();
  std::vector<GlobalIndex> first_row;
  const auto visit = [&](const Piece& piece, const ElementGeometry& geometry, const Cell& cell,
                         const IntegrationPoint& point) {
    Point law{};
    law.tangent = geometry.curve.slope(point.x).normalized();
    law.cell = piece.cell;
    law.radius = geometry.radius;
    law.cell_size = size_across(cell, law.tangent);
    law.ring_radius = make_ring(law.radius, law.cell_size, law.tangent).radius;
    const BasisValues phi = basis.at(point.x, point.number);
    law.rows = phi.count;
    for (int p = 0; p < phi.count; ++p) {
      law.value[p] = phi.value[p] * point.ds;
      touched_.push_back(geometry.row + phi.first + p);
    }
    first_row.push_back(geometry.row + phi.first);
    points_.push_back(law);
  };
  visit_points(mesh_, pieces, rule, visit);
  std::sort(touched_.begin(), touched_.end());
  touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
  for (std::size_t k = 0; k < points_.size(); ++k)
    points_[k].first =
        static_cast<Index>(std::lower_bound(touched_.begin(), touched_.end(), first_row[k]) - touched_.begin());
  exchange_rows_ = std::make_unique<RowExchange>(exchange_, offsets, touched_);
}

void OwnRadiusLaw::evaluate(const std::vector<CellViscosity>& cells, std::vector<Symmetric>& rows) const {
  std::vector<double> touched(6 * touched_.size(), 0.0);
  for (const Point& point : points_) {
    const Compliance c =
        own_radius_law(point.radius, point.ring_radius, point.cell_size, viscosity_, cells[point.cell]);
    const Vec3& t = point.tangent;
    int k = 0;
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j, ++k) {
        const double value = (i == j ? c.across : 0.0) + (c.along - c.across) * t[i] * t[j];
        for (int p = 0; p < point.rows; ++p)
          touched[6 * static_cast<std::size_t>(point.first + p) + k] += point.value[p] * value;
      }
  }
  for (Symmetric& row : rows) row.fill(0.0);
  exchange_rows_->add_to_owners(touched.data(), 6, rows.empty() ? nullptr : rows.front().data());
}

}  // namespace fbi::coupling
